//! A reading of the watch, and its row of the regression.

use crate::equations::{OWN_ORDERS, PARITY_SIGN, own_functions};
use crate::frame::{Coordinate, Frame, SEGMENTS};
use crate::math::{sincos_turns, sqrt};
use crate::model::Unit;

/// Columns of equation (3): sine and cosine of each order of each segment.
pub(super) const OWN_COLUMNS: usize = 2 * OWN_ORDERS.len() * SEGMENTS;
/// Own and lateral orders of the shapes of both directions' phases together, of x's phase and y's. By definition the products of
/// lowest order, which couriers have been seen with (docs/effects.md, lateral dependence).
const PRODUCTS: [[i8; 2]; 6] = [[1, 1], [1, -1], [2, 1], [2, -1], [1, 2], [-1, 2]];
/// Their columns: sine and cosine each, and the same times the courier's angle, by which a pair's two segments differ. Derived
/// from that: two times two.
const PRODUCT_COLUMNS: usize = 4 * PRODUCTS.len();
/// Columns of orders 3 and 5 of each segment, sine and cosine each. A change of one wave moves the places at which all other
/// corrections are looked up: of orders 1, 2, 4 and 6 that makes waves of these orders, which equation (3) lacks. Without columns
/// of their own they pass for a change that both segments of a pair share, since that is what the parity tells least of. Derived
/// from the corrections' products, two orders of sine and cosine.
const BETWEEN_COLUMNS: usize = 4 * SEGMENTS;
/// What the parity holds beside an offset and equation (3).
pub(super) const SHAPE_COLUMNS: usize = PRODUCT_COLUMNS + BETWEEN_COLUMNS;
/// The offset comes first, then the shapes, then equation (3)'s columns: what is asked for last.
pub(super) const FIRST_OWN: usize = 1 + SHAPE_COLUMNS;
/// All columns.
pub(super) const COLUMNS: usize = FIRST_OWN + OWN_COLUMNS;

/// What the watch takes of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reading {
    /// When, milliseconds since the start.
    pub time_ms: u64,
    /// Unmodified outputs.
    pub unmodified: [Coordinate; SEGMENTS],
    /// Parity g_p by the calibration in force, metres.
    pub parity_m: f32,
    /// Temperature over the calibration's, kelvin.
    pub temperature_delta_k: f32,
}

impl Reading {
    /// Of a frame.
    #[must_use]
    pub fn of(frame: &Frame, time_ms: u64) -> Self {
        Self {
            time_ms,
            unmodified: frame.segments.map(|segment| segment.unmodified),
            parity_m: frame.parity_m,
            temperature_delta_k: frame.raw.temperature_delta_k,
        }
    }

    /// The quarter of a tooth that the courier stands in, along x and y.
    pub(super) fn cell(&self) -> [i32; 2] {
        let [p1, p2, p3, p4] = self.unmodified;
        [p1.mean(p3), p2.mean(p4)].map(|place| {
            // Within a tooth either way: the conversion saturates.
            let quarters = (4.0 * (place.fraction_turns + 8.0)) as i32;
            place.teeth.wrapping_mul(4).wrapping_add(quarters)
        })
    }
}

/// `row * unknowns = parity` at unmodified outputs: the unknowns are metres of the calibrated outputs' errors.
pub(super) fn row(unmodified: &[Coordinate; SEGMENTS]) -> [f32; COLUMNS] {
    let mut row = [0.0; COLUMNS];
    row[0] = 1.0;
    let units = unmodified.map(|p| {
        let (sine, cosine) = sincos_turns(p.fraction_turns);
        Unit { sine, cosine }
    });
    let [x, y] = [mean(units[0], units[2]), mean(units[1], units[3])];
    let (shapes, own) = row[1..].split_at_mut(SHAPE_COLUMNS);
    let (products, between) = shapes.split_at_mut(PRODUCT_COLUMNS);
    let [p1, p2, p3, p4] = *unmodified;
    let angle_rad = core::f32::consts::PI * (p1.minus_turns(p3) + p2.minus_turns(p4));
    for (four, [i, j]) in products.as_chunks_mut::<4>().0.iter_mut().zip(PRODUCTS) {
        let Unit { sine, cosine } = multiple(x, i).plus(multiple(y, j));
        *four = [sine, cosine, angle_rad * sine, angle_rad * cosine];
    }
    let fours = between.as_chunks_mut::<4>().0.iter_mut();
    for ((four, unit), sign) in fours.zip(units).zip(PARITY_SIGN) {
        let two = unit.doubled();
        let three = two.plus(unit);
        let five = three.plus(two);
        *four = [three.sine, three.cosine, five.sine, five.cosine].map(|value| sign * value);
    }
    let segments = own.as_chunks_mut::<{ 2 * OWN_ORDERS.len() }>().0;
    for ((columns, unit), sign) in segments.iter_mut().zip(units).zip(PARITY_SIGN) {
        let functions = own_functions([unit.sine, unit.cosine]);
        let pairs = columns.as_chunks_mut::<2>().0.iter_mut().zip(functions);
        pairs.for_each(|(pair, function)| *pair = function.map(|value| sign * value));
    }
    row
}

/// The phase between two that are less than half a turn apart.
fn mean(a: Unit, b: Unit) -> Unit {
    let (sine, cosine) = (a.sine + b.sine, a.cosine + b.cosine);
    let length = sqrt(sine * sine + cosine * cosine);
    if length > 0.0 {
        Unit {
            sine: sine / length,
            cosine: cosine / length,
        }
    } else {
        a
    }
}

/// One or two times a phase, or against it.
fn multiple(unit: Unit, by: i8) -> Unit {
    let once = if by < 0 { Unit::ZERO.minus(unit) } else { unit };
    if by.unsigned_abs() > 1 {
        once.doubled()
    } else {
        once
    }
}
