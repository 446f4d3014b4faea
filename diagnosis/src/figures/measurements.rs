//! How large a gap is, what of it is noise, and what is left.

use super::bursts::Bursts;
use super::fitted_effects::FittedEffects;
use super::location::Located;
use crate::figures::gap::stands_out;
use crate::figures::limits::MINIMUM_SQUARES;
use crate::figures::limits::{NOISY_RATIO, VISIBLE_GAP_RATIO};
use crate::inference::cross_validation::CrossValidation;
use crate::inference::fit_scatter;
use crate::trace::log;

/// A remainder is located if some shape takes this share of it.
const LOCATED_SHARE: f64 = 0.15;
/// Share of a noise that had to be found which shapes may take by chance.
const CHANCE_SHARE_OF_NOISE: f64 = 0.03;

/// What is measured of a gap.
pub(super) struct Measurements {
    pub(super) white_before: f64,
    pub(super) white_after: f64,
    /// Whitened squares beyond the noise without any effect, as the search sees them.
    pub(super) whole_gap: f64,
    /// The same by the stated noise.
    pub(super) shaped: f64,
    /// That with excess noise and bursts.
    pub(super) total: f64,
    pub(super) bursts: Bursts,
    /// Share of `whole_gap` that is left.
    pub(super) left: f64,
    pub(super) located: Vec<Located>,
    gap: bool,
    pub(super) structured: bool,
}

impl FittedEffects<'_> {
    /// Measures the gap, and what the effects leave of it.
    pub(super) fn measure(&self, validation: &mut CrossValidation) -> Measurements {
        let floor = self.floor.white_square.sqrt();
        let white_before = self.before.white_rms() / floor;
        let white_after = self.ratio();
        let stated = validation.rows() * self.floor.white_square;
        let bursts = self.bursts();
        log(&format!(
            "bursts: {} samples, {:.0} squares",
            bursts.count, bursts.energy
        ));
        // Few samples scatter more: four standard deviations of an rms over these rows.
        let chance = 4.0 / (2.0 * validation.rows()).sqrt();
        let own = self.scatter_of_a_fit(validation, &[]);
        let most = (VISIBLE_GAP_RATIO + chance).powi(2) * stated + own;
        let gap = white_before.powi(2) * stated > most || stands_out(validation, self.base + own);
        let structured = gap && !self.blocks.is_empty();
        let left = match (gap, structured) {
            (true, true) => self.left(),
            (true, false) => 1.0,
            _ => 0.0,
        };
        let of_found = if structured { &self.blocks[..] } else { &[] };
        let most =
            (NOISY_RATIO + chance).powi(2) * stated + self.scatter_of_a_fit(validation, of_found);
        let noisy = white_after.powi(2) * stated > most
            && self.rough(&self.after)
            && self.is_noise(&self.after)
            && (bursts.are_few() || self.in_the_middle(&self.after));
        let noise = if noisy {
            (white_after * white_after - 1.0) * stated
        } else {
            0.0
        };
        let shaped = ((white_before * white_before - 1.0) * stated - noise).max(0.0);
        Measurements {
            white_before,
            white_after,
            whole_gap: (validation.score(&[]).squares - self.base).max(0.0),
            shaped,
            total: shaped + noise + bursts.energy,
            bursts,
            left,
            located: self.locate(validation, &self.blocks),
            gap,
            structured,
        }
    }

    /// Squares that the uncertainty of a fit, of the baseline with some blocks, may add to those of the noise, to four standard
    /// deviations.
    fn scatter_of_a_fit(&self, validation: &CrossValidation, blocks: &[usize]) -> f64 {
        let expected_squares =
            fit_scatter::expected_squares(validation.gram, &self.design.list(blocks));
        log(&format!(
            "the fit's own scatter: {expected_squares:.0?} squares"
        ));
        self.floor.white_square * (expected_squares.mean + 4.0 * expected_squares.deviation)
    }

    /// True if some shape takes a good part of what is left, beyond chance.
    pub(super) fn is_located(&self, seen: &Measurements) -> bool {
        // Where the noise itself had to be found, what the best shapes took of it by chance is no place.
        let least = if self.noise.is_some() {
            (2.0 * MINIMUM_SQUARES).max(CHANCE_SHARE_OF_NOISE * self.base)
        } else {
            2.0 * MINIMUM_SQUARES
        };
        let enough =
            |l: &Located| l.share > LOCATED_SHARE && l.share * seen.left * seen.whole_gap > least;
        seen.gap && seen.located.first().is_some_and(enough)
    }
}
