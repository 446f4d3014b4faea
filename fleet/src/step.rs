//! From a state to the next: a step on, a shorter one, or the same with the noise that shows.

use crate::aperture::{WithTeeth, likeliest, likeliest_of};
use crate::halved::{can_be_halved, halved};
use crate::key::{Key, Name, Platen};
use crate::shown::{Shown, Spent};
use crate::solve::{Solution, solve};
use crate::state::State;
use crate::sums::Sums;
use anyhow::Result;
use std::collections::BTreeMap;

/// Settled when the squares fall by no more than this. Derived from the deviations that the data leave: no combination of
/// unknowns then moves by a tenth of its own.
const SETTLED: f64 = 1.0e-2;
/// Settled enough for the noise to be told from what is left. Derived from the same: all within that deviation.
const SETTLED_FOR_NOISE: f64 = 1.0;
/// How often it is told. By definition twice: from a fit with too large a noise, and from one with the noise of that.
const NOISE_TOLD: u32 = 2;

/// Whether a step from a state is too short to count, with the noise that shows and the aperture looked for.
#[must_use]
pub fn is_settled(state: &State, solution: &Solution) -> bool {
    let is_told = state.is_aperture_told && state.noise_told >= NOISE_TOLD;
    is_told && solution.decrement < SETTLED
}

/// Factors of the damping where a step has made more of what is left, and where it has made less (Marquardt 1963).
const MORE: f64 = 10.0;
/// See [`MORE`].
const LESS: f64 = 0.1;
/// Damping of the first step that is damped, in weights of a prior, and the least that counts: choices that cost steps, not results.
const FIRST_DAMPING: f64 = 0.1;
/// See [`FIRST_DAMPING`].
const LEAST_DAMPING: f64 = 1.0e-3;

/// The next state. Where all is settled but the noise, it is the same with the noise that the recordings show; once that was told, and before
/// it is told again, the same with halved splines, and then with fields of teeth under the aperture that these tell. Fields that are too long to be
/// halved tell the aperture once the noise was told again. Where the last step has made less of what is left, it is a step on; else it is the one
/// before, for a shorter step: angles, lever arms and spans may change together along a curve that no reading sees, and a straight step along it goes astray.
///
/// # Errors
/// A reading is no number.
pub fn advanced(
    sums: &BTreeMap<Platen, Sums>,
    state: &State,
    solution: &Solution,
    shown: impl IntoIterator<Item = (Name, Shown)>,
) -> Result<State> {
    if state.is_halved {
        return Ok(by_halves(sums, state, solution, shown));
    }
    let is_near = solution.decrement < SETTLED_FOR_NOISE;
    if is_near && !state.is_aperture_told {
        let can_be_halved = sums.values().all(can_be_halved);
        if can_be_halved && state.noise_told > 0 {
            return Ok(halved(state));
        }
        if !can_be_halved && state.noise_told >= NOISE_TOLD {
            let apertures = likeliest(sums, state);
            return Ok(under(likeliest_of(&apertures, sums, state), state));
        }
    }
    if is_near && state.noise_told < NOISE_TOLD {
        return Ok(with_noise(state, solution, shown));
    }
    let mut next = match &state.before {
        Some((left, before)) if solution.objective > *left => {
            let mut again = State::clone(before);
            // The step there was damped by what this state has let go.
            again.damping = (state.damping / LESS * MORE).max(FIRST_DAMPING);
            again.steps = state.steps + 1;
            return Ok(again);
        }
        _ if state.damping < LEAST_DAMPING => solution.stepped(state),
        _ => solve(sums, state, state.damping)?.stepped(state),
    };
    let mut before = state.clone();
    before.before = None;
    next.damping = LESS * state.damping;
    next.before = Some((solution.objective, Box::new(before)));
    Ok(next)
}

/// The same state with the noise that the poses show.
fn with_noise(
    state: &State,
    solution: &Solution,
    shown: impl IntoIterator<Item = (Name, Shown)>,
) -> State {
    let mut next = state.clone();
    let spent = Spent::of(solution.posterior.shares_left());
    next.noise_m.extend(shown.into_iter().map(|(name, shown)| {
        let noise = shown.noise(&name, state, &spent);
        (name, [noise.segment_m, noise.displacement_m])
    }));
    next.noise_told += 1;
    next.steps += 1;
    // Other weights make other squares.
    next.before = None;
    next
}

/// From one state with halved splines to the next: these tell apertures, and once they are fitted the noise; by that noise one of the apertures is
/// the likeliest.
fn by_halves(
    sums: &BTreeMap<Platen, Sums>,
    state: &State,
    solution: &Solution,
    shown: impl IntoIterator<Item = (Name, Shown)>,
) -> State {
    if state.candidates.is_empty() {
        let mut next = solution.stepped(state);
        next.candidates = likeliest(sums, state);
        return if next.candidates.is_empty() {
            under(None, state)
        } else {
            next
        };
    }
    if state.noise_told < NOISE_TOLD {
        return with_noise(state, solution, shown);
    }
    under(likeliest_of(&state.candidates, sums, state), state)
}

/// The same state with fields of teeth under an aperture, where there is one. They begin where the splines have them, and by the noise that these
/// left. Where there is none, splines a pitch apart take the place of halved ones: such fields begin at zero again, and so the noise begins as
/// large as at first.
fn under(found: Option<WithTeeth>, state: &State) -> State {
    let mut next = state.clone();
    next.is_aperture_told = true;
    next.steps += 1;
    next.is_halved = false;
    next.candidates.clear();
    if found.is_some() || state.is_halved {
        let is_field = |key: &Key| matches!(key, Key::Node(..) | Key::Line(..));
        next.platens.retain(|(_, key), _| !is_field(key));
        next.before = None;
    }
    if let Some((aperture, teeth)) = found {
        next.aperture = Some(aperture);
        next.platens.extend(teeth);
        next.noise_told = NOISE_TOLD - 1;
    } else if state.is_halved {
        next.noise_m.clear();
        next.noise_told = 0;
    }
    next
}
