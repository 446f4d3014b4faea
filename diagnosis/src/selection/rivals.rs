//! Shapes without a name in the place of a course: what wanders by the clock, or follows the temperature, may be told by so many unknowns
//! that it takes in what something else does.

use super::ModelSelection;
use crate::inference::cross_validation::CrossValidation;
use crate::selection::limits::MINIMUM_SQUARES;
use crate::selection::limits::{COMPLETING_SQUARES, STAYS_VISIBLE};
use crate::selection::worth::unexplained_fraction;
use effects::Card;

/// A shape that leaves so many times what a drift leaves does not do as well, whatever share of the gap it takes.
const CLEAR_DRIFT_RATIO: f64 = 10.0;
/// The shape that follows the clock,
const CLOCK_COORDINATE: &str = "time";
/// and the share of what the one leaves that the other leaves where it is the cause. On 21 recordings of other hands and of our own where
/// a drift with the temperature was rightly found by itself it left 1.17 times as much or more.
const CLOCK_LEAVES: f64 = 0.7;

impl ModelSelection<'_> {
    /// A shape that leaves less than this is believed in the place of a drift: a tenth of what is left without the drift beyond what is
    /// left with it, unless that is many times what the drift leaves and would be a gap by itself.
    pub(super) fn as_good_as_drift(&self, validation: &mut CrossValidation) -> f64 {
        let found = self.selected.found.unexplained_fraction;
        let (whole_gap, noise) = self.levels();
        let shows = (STAYS_VISIBLE * STAYS_VISIBLE - 1.0) * noise / whole_gap;
        let tenth =
            0.1 * unexplained_fraction(validation, &self.beside_the_drift(), self.selected.base);
        (found + tenth).min(shows.max(CLEAR_DRIFT_RATIO * found))
    }

    /// What is found besides a drift.
    fn beside_the_drift(&self) -> Vec<usize> {
        self.beside(Card::keeps_its_own_time)
    }

    /// What is found besides effects with a property.
    fn beside(&self, property: fn(&Card) -> bool) -> Vec<usize> {
        let blocks = self.selected.found.blocks.iter().copied();
        let of_it = |b: &usize| effects::has(&self.design.columns.blocks[*b].name, property);
        blocks.filter(|b| !of_it(b)).collect()
    }

    /// True if what follows the temperature follows the clock far better: a temperature that falls while a mount creeps is not its cause.
    pub(super) fn is_no_warmth(&self, validation: &mut CrossValidation) -> bool {
        let found = &self.selected.found;
        let names = self.names_of(&found.blocks);
        // A course beside it has the unknowns that a clock's shape has.
        let has = |property: fn(&Card) -> bool| names.iter().any(|n| effects::has(n, property));
        if !has(Card::follows_temperature) || has(Card::keeps_its_own_time) {
            return false;
        }
        let others = self.beside(Card::follows_temperature);
        let whole_gap = (validation.score(&[]).squares - self.selected.base).max(MINIMUM_SQUARES);
        let mut clock = self.design.coordinate_blocks().into_iter();
        let clock = clock.find(|b| self.design.columns.blocks[*b].name == CLOCK_COORDINATE);
        clock.is_some_and(|clock| {
            let left = unexplained_fraction(
                validation,
                &[others, vec![clock]].concat(),
                self.selected.base,
            );
            left < CLOCK_LEAVES * found.unexplained_fraction
                && (found.unexplained_fraction - left) * whole_gap > COMPLETING_SQUARES
        })
    }

    /// True if one shape does nearly as well as a drift, beside what else is found or in the place of all.
    pub(super) fn is_no_drift(&self, validation: &mut CrossValidation) -> bool {
        let most = self.as_good_as_drift(validation);
        let others = self.beside_the_drift();
        self.design.coordinate_blocks().into_iter().any(|b| {
            let beside: Vec<usize> = others.iter().copied().chain([b]).collect();
            [vec![b], beside]
                .iter()
                .any(|set| unexplained_fraction(validation, set, self.selected.base) < most)
        })
    }
}
