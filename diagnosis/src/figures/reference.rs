//! Whether a gap is the sensor's or that of the reference which it is held against.

use super::fitted_effects::FittedEffects;
use crate::verdict::answer::Named;
use effects::effect::Quantity;
use effects::{Card, Detection};

/// Odds of an error of the reference against a periodic shape that predicts the same. A prior: neither is likelier before the data, and
/// the data add nothing.
const EVEN_ODDS: f64 = 1.0;

impl FittedEffects<'_> {
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
        shape.odds.unlisted = EVEN_ODDS;
        Some(format!(
            "{}: a periodic error of the reference itself looks the same to one segment; a second segment of the axis tells them apart",
            shape.name
        ))
    }
}

impl FittedEffects<'_> {
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
