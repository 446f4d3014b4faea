//! What a change of equation (3)'s amounts does to the position.
//!
//! A position is the mean of a pair's outputs. Along one axis waves of amplitudes `a` and `b` of the pair's segments, at one order, move it
//! by `(a^2 + b^2 + 2 c a b) / 8` in the mean of squares over a tooth, where `c` tells how much both phases agree: they differ by the order
//! times the angle times the span.

use crate::equations::OWN_ORDERS;
use crate::watch::{AMOUNTS, Amounts};

/// How much the phases of a pair agree at each order where angles are uniform within ±0.5°, as in the paper's calibrations: the sine of
/// order times 29.98° over its argument (span 9.7 mm, pitch 1.016 mm).
pub const AS_CALIBRATED: [f32; OWN_ORDERS.len()] = [0.955, 0.827, 0.414, 0.001];
/// Where all angles come.
pub const ANY_ANGLE: [f32; OWN_ORDERS.len()] = [0.0; OWN_ORDERS.len()];
/// Amounts of one segment. A definition: four segments share them.
const A_SEGMENT: usize = AMOUNTS / 4;

/// Eight times half the gradient of the mean squares of [`axes`]: the amounts weighted by what they do to the position.
#[inline(never)] // one copy in the images
pub fn weighted(amounts_m: &Amounts, agree: &[f32; OWN_ORDERS.len()]) -> Amounts {
    core::array::from_fn(|i| {
        let other = amounts_m
            .get((i + AMOUNTS / 2) % AMOUNTS)
            .copied()
            .unwrap_or(0.0);
        let order = i % A_SEGMENT / 2;
        amounts_m[i] + agree.get(order).copied().unwrap_or(0.0) * other
    })
}

/// Mean square of the position's change along x and y, m².
pub fn axes(amounts_m: &Amounts, weighted_m: &Amounts) -> [f32; 2] {
    let mut axes = [0.0; 2];
    for (i, (amount, weighted)) in amounts_m.iter().zip(weighted_m).enumerate() {
        if let Some(axis) = axes.get_mut(i / A_SEGMENT % 2) {
            *axis += 0.125 * amount * weighted;
        }
    }
    axes
}

/// The amounts of one order of the pair along one axis alone: they change the position together.
pub fn group(amounts_m: &Amounts, axis: usize, order: usize) -> Amounts {
    core::array::from_fn(|i| {
        let is_of = i / A_SEGMENT % 2 == axis && i % A_SEGMENT / 2 == order;
        if is_of { amounts_m[i] } else { 0.0 }
    })
}
