//! Gauss-Newton in f64: rows into normal equations, chunk by chunk and place by place, with the priors beside them. Unknowns are counted
//! in deviations of their priors. With columns brought to equal length the condition number is some 1e8 at most: half of f64's digits
//! remain, whatever the columns' length, as a Cholesky factor does not depend on it (Demmel 1989).

use super::constraint::{Linear, Noise, linear};
use super::pose::{Setup, TeethPose};
use super::unknowns::Unknowns;
use anyhow::{Context, Result};
use courier_sensor::equations::middle;
use nalgebra::{DMatrix, DVector, Vector3};
use normal_equations::cholesky::Factor;
use normal_equations::products::RowBuffer;
use normal_equations::symmetric::Symmetric;
use normal_equations::unit_priors;
use rayon::prelude::*;
use tooth_field::order_of_places;

/// Passes of one fit, at most.
const PASSES: usize = 12;
/// Settled when no unknown moves by more than this share of its deviation before the data.
const SETTLED: f64 = 1.0e-6;
/// Longer whitened misclosures count less (Huber 1964).
const FULL_WEIGHT: f64 = 4.0;
/// Equations of a pose: equation (5) and the two of equation (11).
const ROWS: usize = 3;
/// Poses that are turned into rows at once.
const CHUNK: usize = 64;
/// Sums that are formed side by side: the same number on every machine, so that the last digit is.
const LANES: usize = 2;

/// Values, and what determines them.
pub struct Fit {
    /// Of all unknowns.
    pub values: Vec<f64>,
    /// Noise that the weights follow.
    pub noise: Noise,
    /// Of the last fit's precision, and the prior deviations of its unknowns.
    factor: Option<(Factor, Vec<f64>)>,
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
        let free_sd: Vec<f64> = free.iter().map(|i| sd[*i]).collect();
        for _ in 0..PASSES {
            let sum = self.accumulate(problem, &free, &free_sd);
            let last = free.len();
            let normal = DMatrix::from_fn(last, last, |i, j| if i < j { 0.0 } else { sum[(i, j)] });
            let right = DVector::from_fn(last, |row, _| sum[(row, last)]);
            // The step that would lead back to where a fit starts.
            let back = free.iter().map(|&i| (start[i] - self.values[i]) / sd[i]);
            let solution = unit_priors::solve(normal, right, back)
                .context("the poses: found a reading that is no number, wanted none")?;
            for (step, &i) in solution.values.iter().zip(&free) {
                self.values[i] += step * sd[i];
            }
            self.factor = Some((solution.factor, free_sd.clone()));
            tick();
            if solution.values.amax() < SETTLED {
                break;
            }
        }
        Ok(())
    }

    /// Products of the free unknowns' columns, in prior deviations, with each other and with what is left, which is the last column.
    fn accumulate(&self, problem: &Problem, free: &[usize], sd: &[f64]) -> Symmetric {
        let width = free.len() + 1;
        let mut column = vec![None; problem.unknowns.len()];
        free.iter()
            .enumerate()
            .for_each(|(k, &i)| column[i] = Some(k));
        let pitch_m = problem.setup.pitch_m;
        let mut poses: Vec<&TeethPose> = problem.poses.iter().collect();
        // Poses over the same teeth together: then few nodes act in a chunk.
        poses.sort_by_cached_key(|pose| {
            order_of_places(middle(&pose.outputs_m).map(|p| p / pitch_m))
        });
        let lane = |lane: usize| {
            let mut sum = Symmetric::zeros(width);
            let mut rows = RowBuffer::new(width, CHUNK * ROWS);
            for chunk in poses.chunks(CHUNK).skip(lane).step_by(LANES) {
                rows.clear();
                for pose in chunk {
                    self.add_rows(problem, pose, &column, sd, &mut rows);
                }
                rows.add_products(&mut sum);
            }
            sum
        };
        let lanes: Vec<Symmetric> = (0..LANES).into_par_iter().map(lane).collect();
        let mut sum = Symmetric::zeros(width);
        lanes.iter().for_each(|lane| sum += lane);
        sum
    }

    /// A pose's whitened equations, weighted.
    fn add_rows(
        &self,
        problem: &Problem,
        pose: &TeethPose,
        column: &[Option<usize>],
        sd: &[f64],
        rows: &mut RowBuffer,
    ) {
        let at = linear(problem.setup, problem.unknowns, &self.values, pose);
        let whitening = at.whitening(&self.noise);
        let misclosure = whitening * Vector3::from(at.g_m);
        let length = misclosure.norm();
        let root = if length > FULL_WEIGHT {
            (FULL_WEIGHT / length).sqrt()
        } else {
            1.0
        };
        rows.extend(ROWS);
        for (i, by) in &at.by {
            if let Some(k) = column[*i] {
                let white = whitening * Vector3::from(*by);
                rows.add(k, white.as_slice(), root * sd[k]);
            }
        }
        rows.set(sd.len(), misclosure.as_slice(), -root);
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
        factor.deviation(&column)
    }
}
