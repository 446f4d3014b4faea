//! The coordination sensor's own errors, sensor's side: from the measured deflection to the true one.
//!
//! Deflections are normalised, 1 at full scale. `u' = (1 + g) u - a v + sum d_k u^n v^m` for x, with u and v exchanged and
//! `(1 - g) u + a v` for y. Misalignment: g and a. Nonlinearity: degrees 2 and 3, where the second stand for a centre
//! that is not the origin.

use super::layout::NONLINEARITY;

/// Powers of the own and of the other deflection.
pub const TERMS: [(u8, u8); NONLINEARITY / 2] = [(3, 0), (1, 2), (2, 0), (1, 1), (0, 2), (0, 3)];

/// Values of [`TERMS`] for one axis.
#[must_use]
pub fn functions(own: f32, other: f32) -> [f32; TERMS.len()] {
    let (own2, other2) = (own * own, other * other);
    [
        own2 * own,
        own * other2,
        own2,
        own * other,
        other2,
        other2 * other,
    ]
}

/// True deflection; `misalignment` is `[g, a]`, `nonlinearity` six coefficients an axis.
#[must_use]
pub fn corrected([u, v]: [f32; 2], misalignment: &[f32; 2], nonlinearity: &[f32]) -> [f32; 2] {
    let [gain, turn] = *misalignment;
    let (x, y) = nonlinearity.split_at(TERMS.len().min(nonlinearity.len()));
    let sum = |coefficients: &[f32], values: [f32; TERMS.len()]| -> f32 {
        coefficients.iter().zip(values).map(|(c, v)| c * v).sum()
    };
    [
        u + gain * u - turn * v + sum(x, functions(u, v)),
        v - gain * v + turn * u + sum(y, functions(v, u)),
    ]
}
