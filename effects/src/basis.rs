//! Functions of one variable that courses and bends are made of.

pub use tooth_field::cubic_b_spline as spline;

/// Legendre polynomial (Abramowitz and Stegun 1964, equation 22.7.10).
#[must_use]
pub fn legendre(order: usize, u: f64) -> f64 {
    if order == 0 {
        return 1.0;
    }
    let (mut before, mut now) = (1.0, u);
    for n in 1..order {
        let n = n as f64;
        (before, now) = (now, ((2.0 * n + 1.0) * u * now - n * before) / (n + 1.0));
    }
    now
}
