//! Functions of one variable that courses and bends are made of.

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

/// Uniform cubic B-spline with knots a unit apart, centred at zero.
#[must_use]
pub fn spline(x: f64) -> f64 {
    let x = x.abs();
    if x < 1.0 {
        2.0 / 3.0 - x * x + 0.5 * x * x * x
    } else if x < 2.0 {
        (2.0 - x).powi(3) / 6.0
    } else {
        0.0
    }
}
