//! A quadratic through a sample and its neighbours.

use std::ops::Range;

/// Value, slope and curvature at a sample by the quadratic through its neighbours, and what the quadratic through all of them leaves.
/// The sample's own noise is in none of the three: a column made of it would rebuild the residual.
#[derive(Clone, Copy, Default)]
pub struct QuadraticFit {
    /// Value at the sample.
    pub value: f64,
    pub(super) slope: f64,
    pub(super) curvature: f64,
    pub(super) slope_noise: f64,
    pub(super) curvature_noise: f64,
    /// Rms of what the quadratic through all leaves.
    pub residual: f64,
    pub(super) travel: f64,
}

/// Quadratic through the window by least squares, in time centred on sample `i`.
pub fn local(t_s: &[f64], value: &[f64], i: usize, window: Range<usize>) -> QuadraticFit {
    let points: Vec<(f64, f64)> = window
        .filter(|&j| value[j].is_finite())
        .map(|j| (t_s[j] - t_s[i], value[j]))
        .collect();
    let count = points.len() as f64;
    if points.len() < 4 {
        return QuadraticFit {
            residual: f64::INFINITY,
            ..QuadraticFit::default()
        };
    }
    let scale = points
        .iter()
        .map(|(t, _)| t.abs())
        .fold(0.0, f64::max)
        .max(1e-12);
    let mean = points.iter().map(|(_, y)| y).sum::<f64>() / count;
    let mut normal = nalgebra::Matrix3::<f64>::zeros();
    let mut right = nalgebra::Vector3::zeros();
    for (t, y) in &points {
        let row = nalgebra::Vector3::new(1.0, t / scale, (t / scale).powi(2));
        normal += row * row.transpose();
        right += row * (y - mean);
    }
    let Some(inverse) = normal.try_inverse() else {
        return QuadraticFit {
            residual: f64::INFINITY,
            ..QuadraticFit::default()
        };
    };
    let whole = inverse * right;
    let misfit = |(t, y): &(f64, f64)| {
        y - mean - whole[0] - whole[1] * t / scale - whole[2] * (t / scale).powi(2)
    };
    let sum: f64 = points.iter().map(|p| misfit(p).powi(2)).sum();
    // The fit without the sample itself, which stands at time 0: its leverage is the inverse's first element.
    let own = inverse.column(0) / (1.0 - inverse[(0, 0)]).max(1e-9);
    let c = if value[i].is_finite() {
        whole - own * misfit(&(0.0, value[i]))
    } else {
        whole
    };
    let noise =
        |k: usize| (sum / (count - 3.0) * (inverse[(k, k)] + own[k] * inverse[(k, 0)])).sqrt();
    let (low, high) = points
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), (_, y)| {
            (l.min(*y), h.max(*y))
        });
    QuadraticFit {
        value: mean + c[0],
        slope: c[1] / scale,
        curvature: 2.0 * c[2] / (scale * scale),
        slope_noise: noise(1) / scale,
        curvature_noise: 2.0 * noise(2) / (scale * scale),
        residual: (sum / count).sqrt(),
        travel: high - low,
    }
}
