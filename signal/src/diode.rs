//! The coordination sensor's own errors, sensor's side: from the measured deflection to the true one.
//!
//! Deflections are normalised, 1 at full scale. `u' = (1 + g) u - a v + sum d_k u^n v^m` for x, with u and v exchanged and
//! `(1 - g) u + a v` for y. Misalignment: g and a. Nonlinearity: degrees 2 and 3, where the second stand for a centre
//! that is not the origin.

/// Terms of one axis. A definition: as many as `TERMS` has.
pub const AXIS_TERMS: usize = 7;
/// Powers of the own and of the other deflection. By definition all products of second and third degree.
pub const TERMS: [(u8, u8); AXIS_TERMS] = [(3, 0), (2, 1), (1, 2), (2, 0), (1, 1), (0, 2), (0, 3)];
/// Gain difference, angle, and the terms of x and of y.
pub type DiodeErrors = [f32; 2 + 2 * AXIS_TERMS];

/// Values of [`TERMS`] for one axis.
#[must_use]
#[inline]
pub fn functions(own: f32, other: f32) -> [f32; AXIS_TERMS] {
    let (own2, other2) = (own * own, other * other);
    [
        own2 * own,
        own2 * other,
        own * other2,
        own2,
        own * other,
        other2,
        other2 * other,
    ]
}

/// True deflection. 50 operations.
#[must_use]
#[inline]
pub fn corrected([u, v]: [f32; 2], errors: &DiodeErrors) -> [f32; 2] {
    let [gain, turn, x @ .., _, _, _, _, _, _, _] = errors;
    let [.., y0, y1, y2, y3, y4, y5, y6] = errors;
    let sum = |coefficients: &[f32; AXIS_TERMS], values: [f32; AXIS_TERMS]| -> f32 {
        coefficients.iter().zip(values).map(|(c, v)| c * v).sum()
    };
    [
        u + gain * u - turn * v + sum(x, functions(u, v)),
        v - gain * v + turn * u + sum(&[*y0, *y1, *y2, *y3, *y4, *y5, *y6], functions(v, u)),
    ]
}
