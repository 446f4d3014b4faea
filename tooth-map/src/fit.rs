//! Gauss-Newton in f64: rows into normal equations, chunk by chunk and place by place, with the priors beside them. Unknowns are counted
//! in deviations of their priors. With columns brought to equal length the condition number is some 1e8 at most: half of f64's digits
//! remain, whatever the columns' length, as a Cholesky factor does not depend on it (Demmel 1989).

use super::constraint::{Left, Linear, linear};
use super::pose::{Noise, Setup, TeethPose};
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

/// Passes of one fit, at most. A bound on the work: a fit goes on from where it then stands, and held-out poses judge the last
/// one.
const PASSES: usize = 12;
/// Settled when no unknown moves by more than this share of its deviation before the data. Derived from the deviations after the
/// data, 0.03 of 60 µm of a coefficient and 20 µm of 27 mm of a lever arm: a five hundredth of them.
const SETTLED: f64 = 1.0e-6;
/// Equations of a pose. By definition equation (5) and the two of equation (11).
const ROWS: usize = 3;
/// Poses that are turned into rows at once. Cost alone: the rows of a chunk stay in the processor's cache.
const CHUNK: usize = 64;
/// Sums that are formed side by side. Cost alone: the same number on every machine, so that the last digit is.
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
        let free: Vec<usize> = (0..problem.unknowns.count()).filter(|i| free(*i)).collect();
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
        let mut column = vec![None; problem.unknowns.count()];
        free.iter()
            .enumerate()
            .for_each(|(k, &i)| column[i] = Some(k));
        products(
            problem.setup,
            problem.poses,
            free.len() + 1,
            |pose, rows| {
                let pose = &problem.poses[pose];
                let at = linear(problem.setup, problem.unknowns, &self.values, pose);
                let entries = at.by.iter().filter_map(|(i, by)| Some((column[*i]?, *by)));
                let scaled = entries.map(|(k, by)| (k, by, sd[k]));
                add_rows(&at, &self.noise, scaled, sd.len(), rows);
            },
        )
    }

    /// The noise that the poses show. `spent` is the share of the poses' equations that the unknowns took.
    pub fn show_noise(&mut self, problem: &Problem, spent: f64) {
        let line = |pose| linear(problem.setup, problem.unknowns, &self.values, pose);
        let lines: Vec<Linear> = problem.poses.iter().map(line).collect();
        self.noise = Left::of(&lines).noise(&problem.setup.stated_noise(), spent);
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

/// Products of the columns of all poses' rows, `width` of them; `rows_of` is told a pose's number and appends its rows. Poses are taken in the
/// order of their places, in chunks, and the sums are the same on every machine.
#[must_use]
pub fn products(
    setup: &Setup,
    poses: &[TeethPose],
    width: usize,
    rows_of: impl Fn(usize, &mut RowBuffer) + Sync,
) -> Symmetric {
    let mut order: Vec<usize> = (0..poses.len()).collect();
    // Poses over the same teeth together: then few nodes act in a chunk.
    order.sort_by_cached_key(|pose| {
        order_of_places(middle(&poses[*pose].outputs_m).map(|p| p / setup.pitch_m))
    });
    let lane = |lane: usize| {
        let mut sum = Symmetric::zeros(width);
        let mut rows = RowBuffer::new(width, CHUNK * ROWS);
        for chunk in order.chunks(CHUNK).skip(lane).step_by(LANES) {
            rows.clear();
            chunk.iter().for_each(|pose| rows_of(*pose, &mut rows));
            rows.add_products(&mut sum);
        }
        sum
    };
    let lanes: Vec<Symmetric> = (0..LANES).into_par_iter().map(lane).collect();
    let mut sum = Symmetric::zeros(width);
    lanes.iter().for_each(|lane| sum += lane);
    sum
}

/// Appends a linearised pose's whitened and weighted equations: `entries` are column, derivatives of g_p, g_x and g_y, and the unit of the
/// column; what is left goes to the column `left`.
pub fn add_rows(
    at: &Linear,
    noise: &Noise,
    entries: impl Iterator<Item = (usize, [f64; 3], f64)>,
    left: usize,
    rows: &mut RowBuffer,
) {
    let (misclosure, whitening, root) = at.whitened(noise);
    rows.extend(ROWS);
    for (column, by, unit) in entries {
        let white = whitening * Vector3::from(by);
        rows.add(column, white.as_slice(), root * unit);
    }
    rows.set(left, misclosure.as_slice(), -root);
}
