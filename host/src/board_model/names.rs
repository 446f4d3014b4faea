//! What the amounts of a diagnosed model are called, and which term of the board each of them is.

use super::refit::TURN_RAD;
use courier_sensor::frame::SEGMENTS;
use courier_sensor::model::{Multiplier, Term};

/// What changes over a tooth.
const TIMES: &str = " times order ";
/// A power of the angle that the board has no term for.
pub(super) const FOURTH: &str = "theta to the fourth times ";

/// Term, its part (0 sine, 1 cosine) and segment of a named amount; none where the board has no such term.
pub(super) fn place(effect: &str, amount: &str) -> Option<(Term, usize, usize)> {
    let segment = number(amount, "segment ")?
        .checked_sub(1)
        .filter(|s| *s < SEGMENTS as i64)? as usize;
    let constant = |multiplier| Some((Term::default().with(multiplier), 1, segment));
    match effect {
        "velocity_lag" if amount.starts_with("delay,") => return constant(Multiplier::Speed),
        // What turns over within a tenth of a millimetre is, on the board, a direction.
        "hysteresis"
            if amount.starts_with("direction of travel,")
                || amount.starts_with("direction turned ") && !amount.contains(TIMES) =>
        {
            return constant(Multiplier::Direction);
        }
        "thermal_drift" if amount.starts_with("offset, segment") => {
            return constant(Multiplier::Temperature);
        }
        _ => {}
    }
    let part = if amount.contains(" sine,") {
        0
    } else if amount.contains(" cosine,") {
        1
    } else {
        return None;
    };
    let order = |mark| number(amount, mark).and_then(|n| i8::try_from(n).ok());
    let term = match effect {
        "lateral_dependence" if amount.starts_with("own order ") => Term {
            own_order: order("own order ")?.unsigned_abs(),
            lateral_order: order("lateral order ")?,
            ..Term::default()
        },
        "lateral_dependence" => Term::lateral(order("order ")?),
        "extra_harmonics" => Term::own(order("order ")?.unsigned_abs()),
        "velocity_lag" if amount.starts_with("delay times ") => {
            Term::own(order("order ")?.unsigned_abs()).with(Multiplier::Speed)
        }
        "thermal_drift" if amount.starts_with("warmth times ") => {
            Term::own(order("order ")?.unsigned_abs()).with(Multiplier::Temperature)
        }
        "hysteresis" if amount.contains(TIMES) => {
            Term::own(order("order ")?.unsigned_abs()).with(Multiplier::Direction)
        }
        "angle_dependence" if amount.starts_with("theta times ") => {
            Term::own(order("order ")?.unsigned_abs()).with_theta(1)
        }
        "angle_dependence"
            if amount.starts_with("theta squared times ") || amount.starts_with(FOURTH) =>
        {
            Term::own(order("order ")?.unsigned_abs()).with_theta(2)
        }
        _ => return None,
    };
    Some((term, part, segment))
}

/// What an amount is of its term: the fourth power as the parabola that is nearest over the angles of a self-calibration (least
/// squares), others as they are.
pub(super) fn share_of_term(amount: &str) -> f64 {
    if amount.starts_with(FOURTH) {
        5.0 / 7.0 * TURN_RAD * TURN_RAD
    } else {
        1.0
    }
}

/// The whole number behind a mark.
fn number(text: &str, mark: &str) -> Option<i64> {
    let rest = text.split(mark).nth(1)?;
    let end = rest
        .char_indices()
        .find(|(i, c)| !(c.is_ascii_digit() || *i == 0 && *c == '-'))
        .map_or(rest.len(), |(i, _)| i);
    rest[..end].parse().ok()
}
