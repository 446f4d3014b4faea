//! Variance components: how much of each reading's noise is in residuals that several readings make together.
//!
//! By likelihood, Fisher scoring (Patterson and Thompson 1971): of three residuals the four segments and the diode have a share each,
//! and what two residuals have in common tells whose it is.

use crate::linearization::recording::{ROWS, SampleRows};
use effects::sensor::READINGS;
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

/// Rows of a sample that shows all of them: g_p, g_x and g_y. By definition of a sample that has a beacon.
const ROWS_OF_A_SAMPLE: usize = 3;
/// The four segments, and the diode's two axes together. A definition: four and one.
const COMPONENTS: usize = 5;
/// Steps. A bound on the work: they stop once no factor moves by more than `CONVERGED_STEP` of itself, and the last factors are
/// taken where none stand.
const MOST_STEPS: usize = 30;
/// See [`MOST_STEPS`]. Derived from the scatter of a factor, 1 % of ten thousand rows: a tenth of that.
const CONVERGED_STEP: f64 = 1e-3;

/// One sample: its residuals' slopes by the readings, what is left, and the variances of the readings by the stated noise.
pub(super) struct SampleResiduals {
    /// Slopes of each row, of which all three are in use.
    pub(super) by_reading: [[f64; READINGS]; ROWS],
    /// What is left, m.
    pub(super) left_m: [f64; ROWS_OF_A_SAMPLE],
    /// Stated variances of the readings, in their units squared.
    pub(super) variance: [f64; READINGS],
}

impl SampleResiduals {
    /// A sample with all of its rows; none where some are missing.
    pub(super) fn new(
        rows: &SampleRows,
        left_m: &[f64],
        variance: [f64; READINGS],
    ) -> Option<Self> {
        let left_m = <[f64; ROWS_OF_A_SAMPLE]>::try_from(left_m).ok()?;
        (rows.count == ROWS_OF_A_SAMPLE).then_some(Self {
            by_reading: rows.by_reading,
            left_m,
            variance,
        })
    }

    /// The rows' covariance for a unit factor of each component.
    fn parts(&self) -> [Matrix3<f64>; COMPONENTS] {
        let slope = |r: usize| Vector3::from_fn(|row, _| self.by_reading[row][r]);
        let own = |r: usize| slope(r) * slope(r).transpose() * self.variance[r];
        std::array::from_fn(|c| if c < 4 { own(c) } else { own(4) + own(5) })
    }
}

/// Noise of each reading over the stated one (at least 1), from a start; none where the residuals do not tell.
///
/// Cost: a few hundred operations for a sample and a step.
pub(super) fn noise_over_stated(
    seen: &[SampleResiduals],
    start: [f64; READINGS],
) -> Option<[f64; READINGS]> {
    let mut factor: [f64; COMPONENTS] = std::array::from_fn(|c| start[c].max(1.0).powi(2));
    for _ in 0..MOST_STEPS {
        let (score, information) = derivatives(seen, &factor)?;
        // What stands at the stated noise and would go below it stays there.
        let free: Vec<usize> = (0..COMPONENTS)
            .filter(|c| factor[*c] > 1.0 || score[*c] > 0.0)
            .collect();
        let some = DMatrix::from_fn(free.len(), free.len(), |a, b| information[free[a]][free[b]]);
        let step = some
            .cholesky()?
            .solve(&DVector::from_fn(free.len(), |a, _| score[free[a]]));
        let mut moved: f64 = 0.0;
        for (&c, step) in free.iter().zip(&step) {
            // No factor changes by more than four times at once.
            let next = (factor[c] + step)
                .clamp(0.25 * factor[c], 4.0 * factor[c])
                .max(1.0);
            moved = moved.max((next / factor[c] - 1.0).abs());
            factor[c] = next;
        }
        if moved < CONVERGED_STEP {
            break;
        }
    }
    let factor = |r: usize| factor[r.min(COMPONENTS - 1)].sqrt();
    let out: [f64; READINGS] = std::array::from_fn(factor);
    out.iter().all(|f| f.is_finite()).then_some(out)
}

type Score = [f64; COMPONENTS];

/// Slope of the logarithm of the likelihood by the factors, and the information.
fn derivatives(seen: &[SampleResiduals], factor: &Score) -> Option<(Score, [Score; COMPONENTS])> {
    let (mut score, mut information) = ([0.0; COMPONENTS], [[0.0; COMPONENTS]; COMPONENTS]);
    for sample in seen {
        let parts = sample.parts();
        let whole_gap: Matrix3<f64> = parts.iter().zip(factor).map(|(p, f)| p * *f).sum();
        let inverse = whole_gap.try_inverse()?;
        let selected = inverse * Vector3::from(sample.left_m);
        let by_part = parts.map(|p| inverse * p);
        for a in 0..COMPONENTS {
            score[a] += 0.5 * (selected.dot(&(parts[a] * selected)) - by_part[a].trace());
            for b in 0..COMPONENTS {
                information[a][b] += 0.5 * (by_part[a] * by_part[b]).trace();
            }
        }
    }
    Some((score, information))
}

#[cfg(test)]
mod tests {
    use super::*;
    use effects::random::{ChaCha8Rng, SeedableRng, normal, uniform};

    /// Samples of a courier that turns under its beacon, with so much more noise in each reading.
    fn seen(rng: &mut ChaCha8Rng, factor: &[f64; READINGS]) -> Vec<SampleResiduals> {
        let sample = |_| {
            let d = uniform(rng, -3.0, 3.0);
            let e = uniform(rng, -3.0, 3.0);
            let by_reading = [
                [1.0, -1.0, -1.0, 1.0, 0.0, 0.0],
                [d - 0.5, d, -d - 0.5, -d, 0.05, 0.0],
                [e, e - 0.5, -e, -e - 0.5, 0.0, 0.05],
                [0.0; READINGS],
            ];
            let variance = [0.01, 0.01, 0.012, 0.011, 4.0, 4.0];
            let noise: [f64; READINGS] =
                std::array::from_fn(|r| factor[r] * f64::sqrt(variance[r]) * normal(rng));
            let left_m = std::array::from_fn(|row| {
                let slopes = by_reading[row].iter().zip(&noise);
                slopes.map(|(slope, noise)| slope * noise).sum()
            });
            SampleResiduals {
                by_reading,
                left_m,
                variance,
            }
        };
        (0..4000).map(sample).collect()
    }

    /// Four segments and a diode, each by itself, over draws: as far off as the information says, and no farther.
    #[test]
    fn each_readings_noise_is_told_from_what_three_residuals_have_in_common() {
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        let (mut sum, mut count) = (0.0, 0.0);
        for _ in 0..40 {
            let mut factor: [f64; READINGS] =
                std::array::from_fn(|_| uniform(&mut rng, 1.0, 3.5).exp());
            factor[5] = factor[4];
            let seen = seen(&mut rng, &factor);
            let found = noise_over_stated(&seen, [10.0; READINGS]).unwrap();
            let square = |of: &[f64; READINGS]| std::array::from_fn(|c| of[c].powi(2));
            let (_, information) = derivatives(&seen, &square(&factor)).unwrap();
            let information = DMatrix::from_fn(COMPONENTS, COMPONENTS, |a, b| information[a][b]);
            let covariance = information.try_inverse().unwrap();
            let [found, there]: [Score; 2] = [square(&found), square(&factor)];
            for c in 0..COMPONENTS {
                let deviation = covariance[(c, c)].sqrt();
                // One far below the others may stand at the stated noise.
                if there[c] > 1.0 + 3.0 * deviation {
                    sum += ((found[c] - there[c]) / deviation).powi(2);
                    count += 1.0;
                }
            }
        }
        let mean: f64 = sum / count;
        assert!(
            count > 100.0 && (0.6..1.5).contains(&mean),
            "{mean} over {count}"
        );
    }

    #[test]
    fn what_is_as_stated_stays_so() {
        let mut rng = ChaCha8Rng::seed_from_u64(12);
        let factor = [1.0, 6.0, 1.0, 1.0, 1.0, 1.0];
        let found = noise_over_stated(&seen(&mut rng, &factor), [3.0; READINGS]).unwrap();
        for (found, true_) in found.iter().zip(&factor) {
            assert!((found / true_ - 1.0).abs() < 0.1, "{found:?}");
        }
    }

    /// Where one residual is all there is, its noise may be anyone's.
    #[test]
    fn nothing_is_told_of_nothing() {
        assert_eq!(noise_over_stated(&[], [2.0; READINGS]), None);
    }
}
