//! What is not needed once the others are fitted about themselves: an effect may have stood in for their second order.

use super::ModelSelection;
use super::second_effect::absorbs_model_error;
use crate::data::folds::FOLDS;
use crate::inference::cross_validation::CrossValidation;
use crate::inference::fit::{solve, squares};
use crate::linearization::relinearized::RelinearizedFit;
use crate::selection::limits::{
    CLOSE_RATIO, COMPLETING_SHARE, COMPLETING_SQUARES, LARGELY_COMPLETES, LEADING_SHARE,
};
use crate::selection::worth::unexplained_fraction;
use effects::{Card, Detection};

/// An effect beside others must take this share of what is left without it, and of the whole gap.
const NEEDED_SHARE_OF_REST: f64 = 0.4;
/// See [`NEEDED_SHARE_OF_REST`].
const NEEDED_SHARE_OF_GAP: f64 = 0.002;
/// The same for free harmonics: beside a cause they may be what its own shape lacks. And for a clip beside them that no count and no
/// reference shows: a family of clips has their orders.
const NEEDED_SHARE_OF_A_SHAPE: f64 = 0.10;
/// The same beside a drift: its course is known to about a hundredth. What takes nearly all that is left is beside it as beside others.
const NEEDED_SHARE_BESIDE_DRIFT: f64 = 0.02;
/// An effect of less than this share of the whole gap stands in for a shape that takes so many times as much.
const MINOR_SHARE: f64 = 0.1;
/// See [`MINOR_SHARE`].
const SUBSTITUTION_RATIO: f64 = 1.8;
/// So many times what is needed need not be fitted anew without.
const CLEAR_MARGIN: f64 = 2.0;

/// What is left with and without an effect, the whole gap and the noise: mean squares a row beyond the noise.
struct MeanSquares {
    with: f64,
    without: f64,
    whole_gap: f64,
    noise: f64,
    rows: f64,
}

impl MeanSquares {
    /// True if the effect is needed, with so much to spare.
    fn needed(&self, small: &MinimumShares, margin: f64) -> bool {
        let gain = self.without - self.with;
        let share = 1.0 - (1.0 - NEEDED_SHARE_OF_REST) / margin;
        // Where less is left without it than the stated noise, nothing lacks.
        let completes = small.may_complete
            && self.without > 0.0
            && gain > small.completes * self.without
            && gain * self.rows > margin * COMPLETING_SQUARES;
        let shows = self.without > margin * (CLOSE_RATIO * CLOSE_RATIO - 1.0) * self.noise;
        completes
            || shows && gain > share * self.without && gain > margin * small.trifle * self.whole_gap
    }
}

/// How small a share of the whole gap an effect may be.
struct MinimumShares {
    trifle: f64,
    /// Smaller still, where it takes nearly all that is left:
    may_complete: bool,
    /// this share.
    completes: f64,
}

impl MinimumShares {
    /// Of the effect at a place among those that are found; `seen` where a clip is seen as such.
    fn of(names: &[String], at: usize, seen: bool) -> Self {
        let mut others = names.iter().enumerate().filter(|(k, _)| *k != at);
        let patterned = others.any(|(_, name)| effects::has(name, |card| card.patterned));
        let supposed = effects::is(&names[at], Detection::ByRails) && !seen;
        let beside_harmonics = names.iter().any(|name| effects::has(name, Card::is_shape));
        let is_shape = effects::has(&names[at], Card::is_shape);
        let (trifle, may_complete) = if is_shape && patterned || supposed && beside_harmonics {
            (NEEDED_SHARE_OF_A_SHAPE, false)
        } else if names
            .iter()
            .any(|name| effects::has(name, Card::keeps_its_own_time))
        {
            (NEEDED_SHARE_BESIDE_DRIFT, true)
        } else {
            (NEEDED_SHARE_OF_GAP, true)
        };
        Self {
            trifle,
            may_complete,
            completes: COMPLETING_SHARE,
        }
    }
}

impl<'a> ModelSelection<'a> {
    /// Drops what is not needed, that which is easiest to spare first.
    pub(super) fn prune(&mut self) {
        while self.selected.found.blocks.len() > 1 && self.drop_one() {}
        // Beside noise far above the stated one shapes may leave more than nothing would.
        let found = &mut self.selected.found.blocks;
        if self.noise.is_some() && self.after.white_rms() > self.before.white_rms() {
            found.clear();
            self.relinearized =
                RelinearizedFit::new(&self.design.linearized, self.prepared.point(), &[]);
            self.update_residuals();
        }
    }

    /// Drops the first effect that is not needed; false if all are.
    fn drop_one(&mut self) -> bool {
        let (whole_gap, noise) = self.levels();
        let with = self.relinearized.residuals().white_rms().powi(2) - noise;
        let names = self.selected.names(&self.design);
        let seen = self
            .design
            .linearized
            .inputs
            .clip
            .iter()
            .any(Option::is_some);
        let mut order: Vec<(f64, usize)> = (0..names.len())
            .map(|at| (self.mean_square_without(at) - noise, at))
            .collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut validation = self.design.cross_validation();
        for (without, at) in order {
            if self.substitutes_for_shape(&mut validation, at) {
                let mut fewer = names.clone();
                fewer.remove(at);
                self.relinearized = self.refitted(&fewer);
                self.selected.found.blocks.remove(at);
                self.update_residuals();
                return true;
            }
            let mut levels = MeanSquares {
                with,
                without,
                whole_gap,
                noise,
                rows: self.relinearized.gram.total_rows() as f64,
            };
            let mut small = MinimumShares::of(&names, at, seen);
            if self.leading_effect.as_ref() == Some(&names[at]) {
                small.may_complete = true;
                small.completes = if absorbs_model_error(&names[at]) {
                    LARGELY_COMPLETES
                } else {
                    LEADING_SHARE
                };
            }
            if levels.needed(&small, CLEAR_MARGIN) {
                continue;
            }
            let mut fewer = names.clone();
            fewer.remove(at);
            let relinearized = self.refitted(&fewer);
            levels.without = relinearized.residuals().white_rms().powi(2) - noise;
            if !levels.needed(&small, 1.0) {
                self.selected.found.blocks.remove(at);
                self.relinearized = relinearized;
                self.update_residuals();
                return true;
            }
        }
        false
    }

    /// True if an effect takes little of the whole, and a shape without a name takes far more of what is left without it: then it stands in
    /// for that shape.
    fn substitutes_for_shape(&self, validation: &mut CrossValidation, at: usize) -> bool {
        let found = &self.selected.found;
        let block = found.blocks[at];
        let others: Vec<usize> = found
            .blocks
            .iter()
            .copied()
            .filter(|b| *b != block)
            .collect();
        let others = self.with_what_a_gap_makes(validation, block, &others);
        let without = unexplained_fraction(validation, &others, self.selected.base);
        let takes = without
            - unexplained_fraction(
                validation,
                &[&others[..], &[block]].concat(),
                self.selected.base,
            );
        let mut of_shape = |b: &usize| {
            without
                - unexplained_fraction(
                    validation,
                    &[&others[..], &[*b]].concat(),
                    self.selected.base,
                )
        };
        takes < MINOR_SHARE
            && self
                .design
                .coordinate_blocks()
                .iter()
                .any(|b| of_shape(b) > SUBSTITUTION_RATIO * takes)
    }

    /// Fewer effects, or more, with all that is told of them.
    pub(super) fn refitted(&self, fewer: &[String]) -> RelinearizedFit<'a> {
        let (linearized, point) = (&self.design.linearized, self.prepared.point());
        if self.relinearized.linearized.inputs.gap_told {
            self.relinearized
                .with_forms(linearized, point, fewer, &|_| {})
        } else {
            RelinearizedFit::new(linearized, point, fewer)
        }
    }

    /// Held-out mean square a row without one of the effects, the others fitted anew to first order about all of them.
    fn mean_square_without(&self, at: usize) -> f64 {
        let relinearized = &self.relinearized;
        let out = relinearized.columns.blocks[1 + at].columns.clone();
        let list: Vec<usize> = (0..relinearized.gram.width())
            .filter(|c| !out.contains(c))
            .collect();
        let left = |f: usize| {
            let fit = solve(
                relinearized.gram.training(Some(f)),
                &list,
                &relinearized.gram.centre,
                1.0,
            );
            fit.map_or(f64::INFINITY, |fit| {
                squares(&relinearized.gram.fold[f], &fit)
            })
        };
        let sum: f64 = (0..FOLDS).map(left).sum();
        sum / relinearized.gram.total_rows() as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn needed(with: f64, rows: f64, may_complete: bool) -> bool {
        let levels = MeanSquares {
            with,
            without: 0.02,
            whole_gap: 5.0,
            noise: 1.0,
            rows,
        };
        let small = MinimumShares {
            trifle: NEEDED_SHARE_OF_GAP,
            may_complete,
            completes: COMPLETING_SHARE,
        };
        levels.needed(&small, 1.0)
    }

    /// A delay of the beacon has no harmonics that free ones could be mistaken for; a clip has.
    #[test]
    fn harmonics_are_needed_beside_a_cause_that_has_none() {
        let small =
            |cause: &str| MinimumShares::of(&["extra_harmonics".into(), cause.into()], 0, true);
        let (delay, clip) = (small("psd_latency"), small("adc_clipping"));
        assert!(delay.may_complete && delay.trifle < NEEDED_SHARE_OF_A_SHAPE);
        assert!(!clip.may_complete && clip.trifle == NEEDED_SHARE_OF_A_SHAPE);
    }

    /// Positions alone show no flat tops.
    #[test]
    fn a_clip_that_is_not_seen_gives_way_to_harmonics() {
        let names = ["extra_harmonics".into(), "adc_clipping".into()];
        let small = |seen: bool| MinimumShares::of(&names, 1, seen);
        assert!(!small(false).may_complete && small(false).trifle == NEEDED_SHARE_OF_A_SHAPE);
        assert!(small(true).may_complete && small(true).trifle < NEEDED_SHARE_OF_A_SHAPE);
        assert!(MinimumShares::of(&names[1..], 0, false).may_complete);
    }

    /// Two hundredths of the noise are left without it: they do not show in a sum of squares.
    #[test]
    fn what_takes_all_that_is_left_is_needed_however_small_if_it_is_beyond_chance() {
        assert!(needed(0.001, 30_000.0, true));
        assert!(!needed(0.001, 3_000.0, true));
        assert!(!needed(0.01, 30_000.0, true));
        assert!(!needed(0.001, 30_000.0, false));
    }
}
