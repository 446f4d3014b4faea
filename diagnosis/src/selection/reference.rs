//! Whether a gap is the sensor's or that of the reference which it is held against.

use super::ModelSelection;
use crate::design::coordinate_basis::REFERENCE_PHASE;
use crate::inference::cross_validation::CrossValidation;
use crate::inference::residuals::Residuals;
use crate::selection::worth::unexplained_fraction;
use crate::verdict::answer::Named;
use effects::effect::Quantity;
use effects::{Card, Detection};

/// What stays of the gap in a sum that no error of the reference can be in, if the reference is the cause: less than this.
const PARITY_SHARE: f64 = 0.04;

/// What is found is not needed if an error of the reference in its place leaves no more than this beyond it, as a share of the gap.
const REPLACEMENT_SHARE: f64 = 0.01;
/// Odds of an error of the reference against a periodic shape that predicts the same. A prior: neither is likelier before the data, and
/// the data add nothing.
const EVEN_ODDS: f64 = 1.0;

impl ModelSelection<'_> {
    /// Against a reference in all coordinates: an error of the reference moves all segments as a rigid body and is not in the
    /// sum of equation (5). True if what is explained is not either.
    pub(super) fn of_the_reference(&self) -> bool {
        let scope = &self.design.linearized.scope;
        let selected = self.selected.names(&self.design);
        if !scope.reference
            || !scope.segments.iter().all(|s| *s)
            || selected.iter().all(|n| effects::has(n, |card| card.rigid))
        {
            return false;
        }
        let after = &self.after;
        let taken = mean_square(&self.before, |r| r.iter().map(|v| v * v).sum())
            - mean_square(after, |r| r.iter().map(|v| v * v).sum());
        let parity = |r: &[f64]| (r[0] - r[1] - r[2] + r[3]).powi(2);
        mean_square(&self.before, parity) - mean_square(after, parity) < PARITY_SHARE * taken
    }

    /// True if a periodic error of the reference would do in the place of something found.
    pub(super) fn at_the_reference(&self, validation: &mut CrossValidation) -> bool {
        let mut blocks = 1..self.design.columns.blocks.len();
        let Some(shape) = blocks.find(|b| self.design.columns.blocks[*b].name == REFERENCE_PHASE)
        else {
            return false;
        };
        let found = &self.selected.found.blocks;
        let with = unexplained_fraction(validation, found, self.selected.base);
        if !self.paired() {
            // One against several: a single shape may be either's.
            return found.len() > 1
                && unexplained_fraction(validation, &[shape], self.selected.base)
                    < with + REPLACEMENT_SHARE;
        }
        found.iter().any(|block| {
            let mut others: Vec<usize> = found.iter().copied().filter(|b| b != block).collect();
            others.push(shape);
            unexplained_fraction(validation, &others, self.selected.base) < with + REPLACEMENT_SHARE
        })
    }

    /// True if every segment in use has its partner.
    fn paired(&self) -> bool {
        let used = &self.design.linearized.scope.segments;
        (0..4).all(|s| !used[s] || used[(s + 2) % 4])
    }

    /// With one segment of an axis a periodic error of the reference looks like orders that equation (3) leaves out: these are
    /// not told for certain, and the doubt is.
    pub(super) fn doubt_the_reference(&self, effects: &mut [Named]) -> Option<String> {
        let shape = effects
            .iter_mut()
            .find(|e| effects::has(&e.name, Card::is_shape))?;
        if !self.design.linearized.scope.reference || self.paired() {
            return None;
        }
        shape.rivals.unlisted = EVEN_ODDS;
        Some(format!(
            "{}: a periodic error of the reference itself looks the same to one segment; a second segment of the axis tells them apart",
            shape.name
        ))
    }
}

impl ModelSelection<'_> {
    /// Against a reference, rulings that are turned or of another pitch look like a reference that is mounted askew or of another scale, as far
    /// as all segments share it.
    pub(super) fn shared_with_the_reference(&self, effects: &[Named]) -> Option<String> {
        let of_rulings = |card: &Card| {
            let along_the_platen = card.follows == Quantity::PlaceOnPlaten;
            along_the_platen && card.rigid && card.detection != Detection::AsField
        };
        let mut of_rulings = effects.iter().filter(|e| effects::has(&e.name, of_rulings));
        let first = of_rulings
            .next()
            .filter(|_| self.design.linearized.scope.reference)?;
        Some(format!(
            "{}: a turn or a scale that all segments share may be the reference's own: mounted askew, or of another scale, it shows the same",
            first.name
        ))
    }
}

/// Mean over the samples that have all four segments' residuals of some square of them.
fn mean_square(residuals: &Residuals, square: impl Fn(&[f64]) -> f64) -> f64 {
    let (mut sum, mut count) = (0.0, 0);
    let mut start = 0;
    while start < residuals.sample.len() {
        let end = (start..residuals.sample.len())
            .find(|k| residuals.sample[*k] != residuals.sample[start])
            .unwrap_or(residuals.sample.len());
        if end - start == 4 {
            sum += square(&residuals.value_m[start..end]);
            count += 1;
        }
        start = end;
    }
    sum / f64::from(count.max(1))
}
