//! Least-squares spectra of unevenly placed residuals (Lomb 1976): the amplitude of a sine and cosine at each place.

use std::f64::consts::TAU;

/// One line of a spectrum.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Line {
    /// Order (per tooth) or frequency, Hz.
    pub at: f64,
    /// Amplitude before, m.
    pub before_m: f64,
    /// Amplitude after, m.
    pub after_m: f64,
}

/// Amplitudes at `places` (per unit of `argument`) of two series over the same arguments. Cost: points times places.
pub fn spectrum(argument: &[f64], before_m: &[f64], after_m: &[f64], places: &[f64]) -> Vec<Line> {
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
    let (before_mean, after_mean) = (mean(before_m), mean(after_m));
    places
        .iter()
        .map(|&at| {
            let mut sums = Sums::default();
            for ((x, b), a) in argument.iter().zip(before_m).zip(after_m) {
                sums.add((TAU * at * x).sin_cos(), b - before_mean, a - after_mean);
            }
            Line {
                at,
                before_m: sums.amplitude(sums.before),
                after_m: sums.amplitude(sums.after),
            }
        })
        .collect()
}

/// Normal equations of a sine and a cosine with two right sides.
#[derive(Default)]
struct Sums {
    products: [f64; 3],
    before: [f64; 2],
    after: [f64; 2],
}

impl Sums {
    fn add(&mut self, (s, c): (f64, f64), before: f64, after: f64) {
        self.products[0] += s * s;
        self.products[1] += s * c;
        self.products[2] += c * c;
        self.before[0] += s * before;
        self.before[1] += c * before;
        self.after[0] += s * after;
        self.after[1] += c * after;
    }

    fn amplitude(&self, right: [f64; 2]) -> f64 {
        let [ss, sc, cc] = self.products;
        let determinant = ss * cc - sc * sc;
        // One of the two functions vanishes on all points: nothing can be told.
        if determinant < 1e-6 * (ss + cc).powi(2) {
            return 0.0;
        }
        let a = (right[0] * cc - right[1] * sc) / determinant;
        let b = (right[1] * ss - right[0] * sc) / determinant;
        a.hypot(b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wave_at_uneven_places_has_its_amplitude() {
        let x: Vec<f64> = (0..500)
            .map(|i| (f64::from(i) * 0.618_034).fract() * 9.3)
            .collect();
        let wave: Vec<f64> = x
            .iter()
            .map(|x| 2.0 * (TAU * 3.0 * x + 0.4).sin() + 5.0)
            .collect();
        let nothing = vec![0.0; x.len()];
        let lines = spectrum(&x, &wave, &nothing, &[1.0, 3.0, 4.0]);
        assert!((lines[1].before_m - 2.0).abs() < 0.02, "{lines:?}");
        assert!(
            lines[0].before_m < 0.1 && lines[2].before_m < 0.1,
            "{lines:?}"
        );
        assert_eq!(lines[1].after_m, 0.0);
    }
}
