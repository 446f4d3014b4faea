//! The angle and the deflection at a sample as its neighbours tell them.
//!
//! The lever arms and the height of equation (11) are found by how the residual follows the angle and the deflection. Both are
//! readings with noise, and the same noise is in the residual: where the courier hardly turns, a fit by the reading itself follows
//! the noise and finds a lever too short (attenuation by errors in variables, Fuller 1987). On a smooth path the neighbours know the
//! angle without the sample's own noise, which makes them an instrument: the fit is right however little there is to be seen. Where
//! the angle changes far more than its noise the reading itself serves: neighbours smooth what turns fast.

use crate::algebra::statistics::{deviation, median};
use crate::data::observations::Observations;

/// Neighbours on either side. Derived from their mean: of fifty it is known to 0.14 of a reading's noise.
const INSTRUMENT_HALF_WINDOW: usize = 25;

/// Noise below this share of what the values spread over makes a fit by themselves too small by its square, a ten-thousandth:
/// nine micrometres of a lever of 90 mm, which over the whole spread is less than the noise itself. Derived from errors in
/// variables: a slope is too small by the share of the variance.
const NEGLIGIBLE_NOISE_SHARE: f64 = 0.01;

/// Angle and deflection of each sample without its own noise, its own reading at separate poses; empty where the readings serve.
#[derive(Clone, Debug, Default)]
pub struct Instruments {
    /// Rad.
    pub theta_rad: Vec<f64>,
    /// tan(psi) along both axes.
    pub tan_psi: [Vec<f64>; 2],
}

impl Instruments {
    /// From the angles by calibrated segments, the readings, and which samples move smoothly. Linear in samples.
    pub fn of(theta_rad: &[f64], observations: &Observations, smooth: &[bool]) -> Self {
        let o = observations;
        let of_segment = |s: usize| usual(&o.position_noise_m[s]).powi(2);
        let segments = (0..4).map(of_segment).sum::<f64>().sqrt();
        let smooth = |i: usize| smooth[i];
        let estimate =
            |values: &[f64], noise: f64| instrumental(values, noise, &o.unbroken, &smooth);
        Self {
            // Half the difference of each of two pairs.
            theta_rad: estimate(theta_rad, segments / (2.0 * o.span_m)),
            tan_psi: [0, 1].map(|axis| estimate(&o.tan_psi[axis], usual(&o.tan_psi_noise[axis]))),
        }
    }
}

/// The middle one of what is known.
fn usual(noise: &[f64]) -> f64 {
    let known = noise.iter().copied().filter(|n| n.is_finite());
    median(&mut known.collect::<Vec<f64>>()).unwrap_or(0.0)
}

/// The values as their neighbours tell them, where their own stated noise matters; else nothing, and the readings serve.
fn instrumental(
    values: &[f64],
    noise: f64,
    unbroken: &[usize],
    smooth: &dyn Fn(usize) -> bool,
) -> Vec<f64> {
    let known: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    if noise < NEGLIGIBLE_NOISE_SHARE * deviation(&known) {
        Vec::new()
    } else {
        by_neighbours(values, unbroken, smooth)
    }
}

/// Each value as the mean of its neighbours in its piece, as many on either side; itself where it has none. A piece is without a
/// break, smooth, and of values that are known.
fn by_neighbours(values: &[f64], unbroken: &[usize], smooth: &dyn Fn(usize) -> bool) -> Vec<f64> {
    let mut out = values.to_vec();
    let in_use = |i: usize| smooth(i) && values[i].is_finite();
    let mut start = 0;
    while start < values.len() {
        let same = |i: &usize| in_use(*i) && unbroken[*i] == unbroken[start];
        let end = (start..values.len())
            .find(|i| !same(i))
            .unwrap_or(values.len());
        without_itself(&values[start..end], &mut out[start..end]);
        start = end.max(start + 1);
    }
    out
}

fn without_itself(values: &[f64], out: &mut [f64]) {
    let first = values.first().copied().unwrap_or(0.0);
    let mut sums = vec![0.0; values.len() + 1];
    for (i, value) in values.iter().enumerate() {
        sums[i + 1] = sums[i] + (value - first);
    }
    for i in 0..values.len() {
        let half = INSTRUMENT_HALF_WINDOW.min(i).min(values.len() - 1 - i);
        if half > 0 {
            let all = sums[i + half + 1] - sums[i - half];
            out[i] = first + (all - (values[i] - first)) / (2 * half) as f64;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What turns far more than it is noisy is taken as it was read, however coarsely it was sampled.
    #[test]
    fn readings_serve_where_their_noise_does_not_matter() {
        let spin: Vec<f64> = (0..40).map(|i| (0.15 * f64::from(i)).sin()).collect();
        let estimate = |noise: f64| instrumental(&spin, noise, &[0; 40], &|_| true);
        assert!(estimate(0.005).is_empty());
        assert_eq!(estimate(0.02).len(), spin.len());
    }

    /// A straight course is kept, the sample's own deviation is not in it, and a break is not bridged.
    #[test]
    fn neighbours_tell_a_straight_course_without_the_sample_s_own_noise() {
        let mut values: Vec<f64> = (0..100).map(|i| 0.5 * f64::from(i)).collect();
        values[30] += 7.0;
        let unbroken: Vec<usize> = (0..100).map(|i| i / 60).collect();
        let estimate = by_neighbours(&values, &unbroken, &|i| i != 80);
        assert!((estimate[30] - 15.0).abs() < 1e-12, "{}", estimate[30]);
        assert!((estimate[59] - values[59]).abs() < 1e-12);
        assert!((estimate[31] - (15.5 + 7.0 / 50.0)).abs() < 1e-12);
        assert!((estimate[70] - 35.0).abs() < 1e-12 && estimate[80] == values[80]);
    }
}
