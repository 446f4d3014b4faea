//! Gauss-Newton over all recordings: sums at a state, a step, and again until no unknown moves.

use crate::begin::{Beginning, begin};
use crate::key::Platen;
use crate::member::Member;
use crate::register::register;
use crate::shown::Shown;
use crate::solve::{Posterior, Solution, solve};
use crate::state::State;
use crate::step::{advanced, is_settled};
use crate::sums::{Sums, sums_by_noise, sums_of};
use anyhow::Result;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Steps of one fit, at most. A bound on the work: some three times what the longest of the tests takes; the answer says where a fit
/// has not settled by then (`is_settled`).
const STEPS: u32 = 240;

/// A fit, and what it was made of at its last step.
pub struct Fitted {
    /// What each recording says by itself, in the order of the members.
    pub beginnings: Vec<Beginning>,
    /// Where the last sums were taken.
    pub state: State,
    /// Sums of each recording, in the order of the members.
    pub sums: Vec<Sums>,
    /// What the poses of each recording leave there.
    pub shown: Vec<Shown>,
    /// The last step and what it leaves open.
    pub solution: Solution,
}

impl Fitted {
    /// Whether the last step was too short to count.
    #[must_use]
    pub fn is_settled(&self) -> bool {
        is_settled(&self.state, &self.solution)
    }
}

/// Fits all recordings together; `tick` is called after each step.
///
/// # Errors
/// Recordings that do not go together ([`register`]), or a reading that is no number.
pub fn fit(members: &[Member], tick: &(dyn Fn() + Sync)) -> Result<Fitted> {
    let beginnings: Vec<Beginning> = members.par_iter().map(begin).collect::<Result<_>>()?;
    tick();
    let mut fitted = at(members, beginnings, None)?;
    tick();
    while !fitted.is_settled() && fitted.state.steps < STEPS {
        let names = members.iter().map(|m| m.recording.clone());
        let shown = names.zip(fitted.shown.iter().copied());
        let sums = by_platen(members, &fitted.sums);
        let state = advanced(&sums, &fitted.state, &fitted.solution, shown)?;
        fitted = at(members, fitted.beginnings, Some(state))?;
        tick();
    }
    Ok(fitted)
}

/// Sums of all recordings at a state, and the step that they ask for. Without one, where the recordings lead by themselves.
///
/// # Errors
/// As [`fit`].
pub fn at(members: &[Member], beginnings: Vec<Beginning>, state: Option<State>) -> Result<Fitted> {
    let state = match state {
        Some(state) => state,
        None => register(&beginnings)?,
    };
    let of_each: Vec<(Sums, Shown)> = members.par_iter().map(|m| sums_of(m, &state)).collect();
    let (sums, shown): (Vec<Sums>, Vec<Shown>) = of_each.into_iter().unzip();
    let solution = solve(&by_platen(members, &sums), &state, 0.0)?;
    Ok(Fitted {
        beginnings,
        state,
        sums,
        shown,
        solution,
    })
}

/// The sums of all recordings over each platen.
#[must_use]
pub fn by_platen(members: &[Member], sums: &[Sums]) -> BTreeMap<Platen, Sums> {
    let mut all: BTreeMap<Platen, Sums> = BTreeMap::new();
    for (member, sums) in members.iter().zip(sums) {
        let sum = match all.remove(&member.platen) {
            Some(before) => before.plus(sums),
            None => sums.clone(),
        };
        all.insert(member.platen.clone(), sum);
    }
    all
}

/// What no estimate can do better than: the posterior by the readings' noise alone, as the recordings state it, the aperture being unknown as
/// well.
///
/// # Errors
/// A reading is no number.
pub fn bound(members: &[Member], state: &State) -> Result<Posterior> {
    let sums: Vec<Sums> = members
        .par_iter()
        .map(|m| sums_by_noise(m, state))
        .collect();
    Ok(solve(&by_platen(members, &sums), state, 0.0)?.posterior)
}
