//! What is measured of the residuals that a set of effects leaves, and is no matter of columns: for a decision that is made elsewhere.

use super::bursts::{BURST_SHARE, Bursts, Left};
use super::fitted_effects::FittedEffects;
use crate::data::prepare::Prepared;
use crate::design::assembly::{Design, Options};
use crate::figures::limits::{NOISY_RATIO, STAYS_VISIBLE, VISIBLE_GAP_RATIO};
use crate::inference::residuals::Residuals;
use crate::linearization::relinearized::RelinearizedFit;
use crate::noise::simulated::Floor;
use effects::sensor::READINGS;

/// What is measured.
#[derive(Default)]
pub(crate) struct Measured {
    /// What is left beyond the stated noise is shown to be white: noise, or bursts that are too small to stand out.
    pub(crate) white: bool,
    /// Nothing that shows is left beyond the noise in force.
    pub(crate) nothing_shows: bool,
    /// Short disturbances stand out of it.
    pub(crate) bursts: bool,
    /// What is louder than stated is in the tails alone: it is no noise but what is left of these bursts.
    pub(crate) small_bursts: bool,
    /// Where codes are missing that a converter should give, and the share of the whole gap that rounding to the others makes.
    pub(crate) missing_codes: Option<(String, f64)>,
    /// Samples in use, where the set shows others to be disturbed than was thought.
    pub(crate) mask: Option<Vec<bool>>,
    /// Noise of each reading, where most of what is left is rough.
    pub(crate) noise: Option<Noise>,
}

/// Noise of each reading as it is measured.
#[derive(Clone, Copy)]
pub(crate) struct Noise {
    /// Over the stated one.
    pub(crate) over_stated: [f64; READINGS],
    /// All that is left is shown to be noise. Otherwise most of it is rough, and a pattern is left as well.
    pub(crate) shown: bool,
}

/// Rounding to the codes that are left explains the gap if it makes more of it than all else.
/// By definition of most: half.
const MOST_OF_THE_GAP: f64 = 0.5;

impl Measured {
    /// The place of what missing codes make and its share of the gap, where that is most of it: it is measured at the codes themselves, and
    /// no effect is asked for it.
    pub(crate) fn codes_explain_it(&self) -> Option<(&String, f64)> {
        let (place, share) = self.missing_codes.as_ref()?;
        (*share > MOST_OF_THE_GAP).then_some((place, *share))
    }
}

/// A design with a fit of some effects, as it is measured.
pub(super) fn fitted_effects<'a>(
    prepared: &'a Prepared,
    options: &'a Options,
    (design, relinearized): (Design<'a>, RelinearizedFit<'a>),
) -> FittedEffects<'a> {
    let names = &relinearized.hypothesis.effects;
    let of_it = |b: &usize| names.contains(&design.columns.blocks[*b].name);
    let blocks = design.effects().into_iter().filter(of_it).collect();
    let linearized = &design.linearized;
    let noise = (!linearized.is_by_stated_noise()).then_some(linearized.noise);
    let floor = Floor {
        white_square: crate::posterior::weighing::floor(&design),
        ..design.floor
    };
    let base = floor.white_square * design.gram.total_rows() as f64;
    FittedEffects {
        prepared,
        options,
        floor,
        noise,
        before: design.residuals(&[]),
        after: relinearized.residuals().clone(),
        transfer_residuals: None,
        without_beats: None,
        before_by_folds: Residuals::default(),
        design,
        blocks,
        base,
        relinearized,
    }
}

/// Noise of each reading over the stated one beneath what the baseline alone leaves; the design comes back. Noise that is far above the stated
/// one is rebuilt by columns that are formed of noisy readings, and what a set leaves then says nothing of it.
pub(crate) fn noise_beneath_nothing<'a>(
    prepared: &'a Prepared,
    options: &'a Options,
    design: Design<'a>,
) -> (Option<Noise>, Design<'a>) {
    let bare = RelinearizedFit::new(&design.linearized, prepared.point(), &[]);
    let fitted = fitted_effects(prepared, options, (design, bare));
    (measured_noise(&fitted), fitted.design)
}

/// True unless what is louder than stated is in the tails alone: beside bursts, these are the ones that are too small to stand out.
fn is_no_tail(fitted: &FittedEffects, bursts: &Bursts) -> bool {
    bursts.are_few() || fitted.in_the_middle(&fitted.after)
}

/// Noise of each reading over the stated one, where what is left is shown to be noise, or most of it is rough; measured anew where the design is
/// whitened by such noise already.
fn measured_noise(fitted: &FittedEffects) -> Option<Noise> {
    let (over_stated, shown) = match (fitted.noise, fitted.noise_left()) {
        (Some(_), _) => (fitted.noise_of_readings(), true),
        (None, Some(shown)) => (shown, true),
        (None, None)
            if fitted.ratio() >= NOISY_RATIO && fitted.is_rough_on_the_whole(&fitted.after) =>
        {
            (fitted.noise_of_readings(), false)
        }
        (None, None) => return None,
    };
    let bursts = fitted.bursts();
    // Bursts are rough as well, and what is left beside them need be no noise.
    let no_bursts = if shown {
        is_no_tail(fitted, &bursts)
    } else {
        bursts.are_few() && fitted.in_the_middle(&fitted.after)
    };
    let is_noise = no_bursts && over_stated.iter().any(|n| *n > NOISY_RATIO);
    is_noise.then_some(Noise { over_stated, shown })
}

/// Measures what a fit of some effects leaves; design and fit come back.
pub(crate) fn measured<'a>(
    prepared: &'a Prepared,
    options: &'a Options,
    (design, fit): (Design<'a>, RelinearizedFit<'a>),
) -> (Measured, Design<'a>, RelinearizedFit<'a>) {
    let fitted = fitted_effects(prepared, options, (design, fit));
    let left = &fitted.after;
    let white = fitted.rough(left) && fitted.is_noise(left) && !fitted.hums();
    let squares = |r: &Residuals| (r.white_rms().powi(2) - 1.0).max(0.0) * r.white.len() as f64;
    let bursts = fitted.bursts();
    let whole = squares(&fitted.before) + bursts.energy;
    let of_left = Left {
        squares: if white { 0.0 } else { squares(left) },
        level: left.white_rms().powi(2),
        shows: fitted.ratio() > STAYS_VISIBLE * fitted.noise_rms(),
    };
    let hold = bursts.hold(bursts.least_squares(&of_left, whole, BURST_SHARE));
    let in_the_tails = !is_no_tail(&fitted, &bursts);
    let measured = Measured {
        white: white && (!in_the_tails || hold),
        nothing_shows: left.white_rms() <= VISIBLE_GAP_RATIO,
        bursts: hold,
        small_bursts: white && in_the_tails && hold,
        missing_codes: fitted.missing_codes().map(|l| (l.coordinate, l.share)),
        mask: fitted.revised_mask(),
        noise: measured_noise(&fitted),
    };
    (measured, fitted.design, fitted.relinearized)
}

#[cfg(test)]
mod tests {
    use super::Measured;

    #[test]
    fn missing_codes_explain_a_gap_that_they_make_most_of() {
        let told = |share| {
            let missing_codes = Some(("place".to_owned(), share));
            let measured = Measured {
                missing_codes,
                ..Measured::default()
            };
            measured.codes_explain_it().is_some()
        };
        assert!(told(0.6) && !told(0.4));
        assert!(Measured::default().codes_explain_it().is_none());
    }
}
