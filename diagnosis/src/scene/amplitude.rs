//! Each pair's amplitude less what repeats with the own tooth phase.

use super::Scene;
use super::moment::multiples;
use std::f64::consts::TAU;

impl Scene<'_> {
    /// Logarithm of the amplitude and its regressors: mean and own-phase orders up to eight.
    fn amplitude_row(
        &self,
        segment: usize,
        i: usize,
    ) -> Option<(nalgebra::SVector<f64, PATTERN>, f64)> {
        let value = self.observations.amplitude_counts[segment][i].ln();
        let phase = TAU / self.observations.pitch_m * self.calibrated_m[segment][i];
        (value.is_finite() && phase.is_finite()).then(|| {
            let table = multiples::<9>(phase);
            let entry = |j: usize| {
                if j % 2 == 1 {
                    table[j.div_ceil(2)].0
                } else {
                    table[j / 2].1
                }
            };
            (nalgebra::SVector::from_fn(|j, _| entry(j)), value)
        })
    }

    pub(super) fn amplitude_pattern(&self, segment: usize) -> Vec<f64> {
        let n = self.observations.amplitude_counts[segment].len();
        let mut normal = nalgebra::SMatrix::<f64, PATTERN, PATTERN>::identity() * 1e-9;
        let mut right = nalgebra::SVector::<f64, PATTERN>::zeros();
        for (x, y) in (0..n).filter_map(|i| self.amplitude_row(segment, i)) {
            normal += x * x.transpose();
            right += x * y;
        }
        normal
            .cholesky()
            .filter(|_| n > 0)
            .map_or(Vec::new(), |factor| {
                factor.solve(&right).iter().copied().collect()
            })
    }

    pub(super) fn amplitude_excess(&self, segment: usize) -> Vec<f64> {
        let pattern = &self.normal.ln_amplitude[segment];
        if pattern.len() != PATTERN {
            return Vec::new();
        }
        let c = nalgebra::SVector::<f64, PATTERN>::from_column_slice(pattern);
        let n = self.observations.amplitude_counts[segment].len();
        (0..n)
            .map(|i| {
                self.amplitude_row(segment, i)
                    .map_or(0.0, |(x, y)| y - c.dot(&x))
            })
            .collect()
    }
}

/// Regressors of an amplitude's pattern.
const PATTERN: usize = 17;
