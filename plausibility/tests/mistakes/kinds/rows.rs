//! Rows as a mistake leaves them.

use recording::{Meta, Row};
use std::f64::consts::TAU;

pub fn swap(row: &mut Row, a: usize, b: usize) {
    row.quadrature_counts.swap(a, b);
    row.teeth.swap(a, b);
    row.position_m.swap(a, b);
}

/// A pair that was wired otherwise and counted by the board: the tooth count follows the wrong phase.
pub fn rewired(row: &mut Row, meta: &Meta, segment: usize, wire: fn([f64; 2]) -> [f64; 2]) {
    let (Some(output_m), Some(pair)) = (output(row, meta, segment), row.quadrature_counts[segment])
    else {
        return;
    };
    // Where the wrong phase is zero, the true one is that of this pair.
    let [sine, cosine] = wire([0.0, 1.0]);
    let start = sine.atan2(cosine) / TAU;
    let turns = start - output_m / meta.geometry.pitch_m;
    let wrong = wire(pair);
    row.quadrature_counts[segment] = Some(wrong);
    row.teeth[segment] = Some((turns - wrong[0].atan2(wrong[1]) / TAU).round() as i32);
}

/// Columns of a file that were mixed up: the tooth count is right.
pub fn mixed(row: &mut Row, segment: usize, mix: fn([f64; 2]) -> [f64; 2]) {
    row.quadrature_counts[segment] = row.quadrature_counts[segment].map(mix);
}

pub fn electrodes(row: &mut Row, order: [usize; 4]) {
    row.electrode_counts = row.electrode_counts.map(|e| order.map(|k| e[k]));
}

pub fn scaled(row: &mut Row, factors: [f64; 3]) {
    for (value, factor) in row.reference.iter_mut().zip(factors) {
        *value = value.map(|v| v * factor);
    }
}

pub fn output(row: &Row, meta: &Meta, segment: usize) -> Option<f64> {
    let (teeth, pair) = (row.teeth[segment]?, row.quadrature_counts[segment]?);
    Some(recording::unmodified_m(teeth, pair, meta.geometry.pitch_m))
}
