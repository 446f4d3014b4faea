//! Gauss-Newton in f64: sparse rows into the normal matrix, priors beside them, Cholesky. With columns brought to equal length its
//! condition number is some 1e8 at most: half of f64's digits remain.

use super::constraint::{Linear, Noise, linear};
use super::pose::{Setup, TeethPose};
use super::unknowns::Unknowns;
use anyhow::{Context, Result};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn, Vector3};

/// Passes of one fit, at most.
const PASSES: usize = 12;
/// Settled when no unknown moves by more than this share of its deviation before the data.
const SETTLED: f64 = 1.0e-6;
/// Longer whitened misclosures count less (Huber 1964).
const FULL_WEIGHT: f64 = 4.0;

/// Values, and what determines them.
pub struct Fit {
    /// Of all unknowns.
    pub values: Vec<f64>,
    /// Noise that the weights follow.
    pub noise: Noise,
    factor: Option<(Cholesky<f64, Dyn>, Vec<f64>)>,
}

/// What a fit is of.
pub struct Problem<'a> {
    /// Geometry and stated noise.
    pub setup: &'a Setup,
    /// Order of the unknowns.
    pub unknowns: &'a Unknowns,
    /// Poses to fit.
    pub poses: &'a [TeethPose],
}

impl Fit {
    /// Where every fit starts.
    pub fn start(problem: &Problem, noise: Noise) -> Self {
        Self {
            values: problem.unknowns.start(problem.setup),
            noise,
            factor: None,
        }
    }

    /// Fits the unknowns that `free` says; the rest keep their values. `tick` is called after each pass.
    ///
    /// # Errors
    /// The poses and priors do not make a positive matrix: a reading that is no number.
    pub fn improve(
        &mut self,
        problem: &Problem,
        free: impl Fn(usize) -> bool,
        tick: &mut dyn FnMut(),
    ) -> Result<()> {
        let sd = problem.unknowns.deviations(problem.setup);
        let start = problem.unknowns.start(problem.setup);
        let free: Vec<usize> = (0..problem.unknowns.len()).filter(|i| free(*i)).collect();
        for _ in 0..PASSES {
            let (mut normal, mut right) = self.accumulate(problem, &free);
            for (row, &i) in free.iter().enumerate() {
                let weight = sd[i].powi(-2);
                normal[(row, row)] += weight;
                right[row] += (start[i] - self.values[i]) * weight;
            }
            let scale: Vec<f64> = (0..free.len())
                .map(|i| normal[(i, i)].sqrt().recip())
                .collect();
            for i in 0..free.len() {
                right[i] *= scale[i];
                for j in 0..=i {
                    normal[(i, j)] *= scale[i] * scale[j];
                }
            }
            let factor = normal
                .cholesky()
                .context("the poses: found a reading that is no number, wanted none")?;
            let change = factor.solve(&right);
            let mut largest = 0.0_f64;
            for (row, &i) in free.iter().enumerate() {
                let step = change[row] * scale[row];
                self.values[i] += step;
                largest = largest.max(step.abs() / sd[i]);
            }
            self.factor = Some((factor, scale));
            tick();
            if largest < SETTLED {
                break;
            }
        }
        Ok(())
    }

    /// Lower half of the normal matrix of the free unknowns, and its right side.
    fn accumulate(&self, problem: &Problem, free: &[usize]) -> (DMatrix<f64>, DVector<f64>) {
        let mut place = vec![usize::MAX; problem.unknowns.len()];
        free.iter().enumerate().for_each(|(row, &i)| place[i] = row);
        let mut normal = DMatrix::<f64>::zeros(free.len(), free.len());
        let mut right = DVector::<f64>::zeros(free.len());
        for pose in problem.poses {
            let at = linear(problem.setup, problem.unknowns, &self.values, pose);
            let whitening = at.whitening(&self.noise);
            let misclosure = whitening * Vector3::from(at.g_m);
            let length = misclosure.norm();
            let root = if length > FULL_WEIGHT {
                (FULL_WEIGHT / length).sqrt()
            } else {
                1.0
            };
            let rows: Vec<(usize, Vector3<f64>)> = at
                .by
                .iter()
                .filter(|(i, _)| place[*i] != usize::MAX)
                .map(|(i, by)| (place[*i], whitening * Vector3::from(*by) * root))
                .collect();
            for (i, row) in &rows {
                right[*i] -= row.dot(&misclosure) * root;
                for (j, other) in &rows {
                    if j <= i {
                        normal[(*i, *j)] += row.dot(other);
                    }
                }
            }
        }
        (normal, right)
    }

    /// The noise that the poses show, not below the stated: segments by g_p, displacements by what of g_x these leave. `spent` is the
    /// share of the poses' equations that the unknowns took.
    pub fn show_noise(&mut self, problem: &Problem, spent: f64) {
        let lines: Vec<Linear> = problem
            .poses
            .iter()
            .map(|pose| linear(problem.setup, problem.unknowns, &self.values, pose))
            .collect();
        let robust = |k: usize| {
            let mut sizes: Vec<f64> = lines.iter().map(|line| line.g_m[k].abs()).collect();
            let middle = sizes.len() / 2;
            // Gaussian deviation over median absolute value.
            1.4826 * *sizes.select_nth_unstable_by(middle, f64::total_cmp).1 / (1.0 - spent).sqrt()
        };
        let segment_m = (0.5 * robust(0)).max(problem.setup.segment_noise_m);
        let share = lines.iter().map(Linear::segment_share_of_x).sum::<f64>() / lines.len() as f64;
        let left = robust(1).powi(2) - share * segment_m.powi(2);
        self.noise = Noise {
            segment_m,
            displacement_m: left.max(0.0).sqrt().max(problem.setup.displacement_noise_m),
        };
    }

    /// Predicted deviation of a linear function of the unknowns of the last fit, all of which were free.
    pub fn deviation(&self, function: &[(usize, f64)]) -> f64 {
        let Some((factor, scale)) = &self.factor else {
            return f64::INFINITY;
        };
        let mut column = DVector::zeros(scale.len());
        for (i, value) in function {
            column[*i] += value * scale[*i];
        }
        factor
            .l_dirty()
            .solve_lower_triangular(&column)
            .map_or(f64::INFINITY, |half| half.norm())
    }
}
