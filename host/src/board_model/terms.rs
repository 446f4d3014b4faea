//! Which term of the board's error model an amount of a diagnosed model is.

use super::row::USUAL_ANGLE_RAD;
use courier_sensor::model::{Multiplier, Term};
use diagnosis::Model;
use diagnosis::transfer::model::EffectAmounts;
use effects::identity::{Factor, Identity, Part, Wave};
use std::collections::HashMap;

/// A place in the board's error model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    /// Term.
    pub(super) term: Term,
    /// 0 of its sine, 1 of its cosine.
    pub(super) part: usize,
    /// Segment, 0 to 3.
    pub(super) segment: usize,
    /// What an amount of 1 is of the term.
    pub(super) share: f64,
}

/// The places of an effect's amounts by the amounts' names. What the board has no term for is not among them.
pub(super) fn places(diagnosed: &Model, effect: &EffectAmounts) -> HashMap<String, Place> {
    let Some(effect) = effects::effect(&effect.name) else {
        return HashMap::new();
    };
    if effect.card().on_board.is_empty() {
        return HashMap::new();
    }
    let all = effect.regressors(&diagnosed.inputs).into_iter();
    all.filter_map(|regressor| match regressor.identity {
        Some(Identity::Wave(wave)) => Some((regressor.name, place(&wave)?)),
        _ => None,
    })
    .collect()
}

/// The place of a wave; none where the board has no such term.
pub(super) fn place(wave: &Wave) -> Option<Place> {
    let plain = Term {
        own_order: wave.own_order.try_into().ok()?,
        lateral_order: wave.lateral_order.try_into().ok()?,
        ..Term::default()
    };
    let (term, share) = match wave.factor {
        Factor::One => (plain, 1.0),
        Factor::Angle(power @ 1..=2) => (plain.with_theta(power as u8), 1.0),
        // The parabola that is nearest to a fourth power over the angles of a self-calibration (least squares).
        Factor::Angle(4) => (
            plain.with_theta(2),
            5.0 / 7.0 * USUAL_ANGLE_RAD * USUAL_ANGLE_RAD,
        ),
        Factor::Speed => (plain.with(Multiplier::Speed), 1.0),
        Factor::Way => (plain.with(Multiplier::Direction), 1.0),
        Factor::Warmth => (plain.with(Multiplier::Temperature), 1.0),
        _ => return None,
    };
    Some(Place {
        term,
        part: match wave.part {
            Part::Sine => 0,
            Part::Cosine => 1,
        },
        segment: wave.segment,
        share,
    })
}

/// The coordinates over which a correction without a name has shapes that the board has terms for.
pub(super) const COORDINATES_ON_BOARD: &str =
    "own tooth phase with speed, direction or temperature";

/// The effects of which the board takes something over, by name.
pub(super) fn on_board() -> String {
    let cards = effects::EFFECTS.iter().map(|effect| effect.card());
    let of_it = cards.filter(|card| !card.on_board.is_empty());
    of_it.map(|card| card.name).collect::<Vec<_>>().join(", ")
}
