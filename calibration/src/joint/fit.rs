//! Gauss-Newton by re-linearised QR rows: each pass over the poses rotates three whitened rows a pose into the triangle.
//!
//! Damped (Levenberg-Marquardt rows where a pass made things worse), bounded in steps, outliers bounded (Huber 1964, by
//! the robust size of all poses' misclosures, so that unmodelled structure is not taken for outliers). A pass of 1000 poses
//! with 62 unknowns is 1000 linearisations of 54,000 cycles and 3000 rows of 18,000: 0.63 s at 170 MHz; a fit takes two to
//! eight. So it is cut into slices, between which everything else has its turn: a slice is a pose, or at the end of a pass
//! the solution.

use super::constraint::{Constraints, Rows};
use super::layout::{Groups, JOINT_UNKNOWNS, Values};
use super::sample::{JointSample, Poses};
use super::solver::{FitReport, JointSolver};
use crate::lsq::SolveError;
use crate::math::sqrt;

/// Passes at most. A bound on the work: the fit then ends where it stands, and its report has the passes.
const PASSES: u32 = 25;
/// Settled when no unknown moves by more than this share of its standard deviation. Derived from the deviations themselves: the
/// rest of a series that falls by halves is as much again, 2 % of one.
const SETTLED: f32 = 0.01;
/// Steps below this many standard deviations: the robust size is measured again. A prior: farther ones mend the start's error,
/// beside which misclosures tell no outliers.
const NEAR: f32 = 1000.0;
/// Median length of one and of three independent normal numbers of deviation one. Derived from chi-square: roots of its medians,
/// 0.4549 and 2.366.
const MEDIAN_LENGTH: [f32; 2] = [0.6745, 1.538];
/// Poses whose whitened misclosure is longer than this, robust deviations, count less. Derived from chi-square with three degrees
/// of freedom: one good pose in 1000.
const FULL_WEIGHT: f32 = 4.0;
/// Longer than this: not at all. Derived from the same: none in 10^30, where a pose that is astray by a tooth is a thousand.
const LEFT_OUT: f32 = 12.0;
/// A pass made things worse if the sum of squares grew by more than this factor. A prior: less comes from the weights, which
/// follow the values.
const WORSE: f32 = 1.01;
/// Damping of the first try after a pass that made things worse, of the diagonal. Cost alone: a fit that settles is where its
/// slope is zero, however it came there.
const DAMPING: f32 = 1.0e-2;
/// Its growth from try to try (Marquardt 1963).
const DAMPING_GROWTH: f32 = 10.0;

/// A fit under way, or ended.
#[derive(Debug)]
pub struct Fit {
    walk: Walk,
    /// Robust size of the whitened misclosures: 1 where model and stated noise hold.
    scale: f32,
    best: Values,
    best_cost: f32,
    damping: f32,
    /// Largest move of the last solution, standard deviations.
    moved: f32,
    report: FitReport,
}

/// A walk over all poses.
#[derive(Debug)]
enum Walk {
    /// For the robust size of their misclosures, by the solver's median.
    Size,
    /// For their rows.
    Rows(Pass),
}

/// What a pass has summed up.
#[derive(Clone, Copy, Debug, Default)]
struct Pass {
    /// What Gauss-Newton lowers.
    cost: f32,
    squares: f32,
    left_out: u32,
    /// From the best values so far, since the pass before made things worse.
    again: bool,
}

impl Fit {
    /// None: all zeros.
    pub const fn idle() -> Self {
        Self {
            walk: Walk::Size,
            scale: 0.0,
            best: [0.0; JOINT_UNKNOWNS],
            best_cost: 0.0,
            damping: 0.0,
            moved: 0.0,
            report: FitReport {
                unknowns: 0,
                rank: 0,
                condition: 0.0,
                passes: 0,
                settled: false,
                whitened_rms: 0.0,
                left_out: 0,
            },
        }
    }

    /// Frees the unknowns of some groups; then [`Fit::slice`], again and again.
    pub fn begin(&mut self, solver: &mut JointSolver, constraints: &Constraints, groups: Groups) {
        solver.free_groups(constraints, groups);
        solver.median.clear();
        self.walk = Walk::Size;
        (self.best_cost, self.damping) = (f32::INFINITY, 0.0);
        self.report = FitReport {
            unknowns: solver.free().len() as u32,
            ..FitReport::default()
        };
    }

    /// How it ended, once it has.
    pub fn report(&self) -> &FitReport {
        &self.report
    }

    /// Takes the next of all `poses`, or none at the end of each walk over them, after which it begins with the first one
    /// again; true when the fit has ended. Cost: 110,000 cycles, and at the end of a pass the solution's.
    ///
    /// # Errors
    /// [`SolveError`]; `values` are then the best so far.
    pub fn slice(
        &mut self,
        solver: &mut JointSolver,
        constraints: &Constraints,
        values: &mut Values,
        sample: Option<&JointSample>,
        poses: usize,
    ) -> Result<bool, SolveError> {
        match (&mut self.walk, sample) {
            (Walk::Size, Some(sample)) => {
                let square = solver.square(&constraints.whitened(values, values, sample));
                solver.median.add(square);
            }
            (Walk::Rows(pass), Some(sample)) => {
                pass.enter(solver, &constraints.rows(values, sample), self.scale);
            }
            (Walk::Size, None) => {
                let length = MEDIAN_LENGTH[usize::from(solver.channels == 3)];
                let size = sqrt(solver.median.upper(poses)) / length;
                return Ok(self.sized(size.max(1.0), solver));
            }
            (Walk::Rows(pass), None) => {
                let pass = *pass;
                return self.passed(pass, solver, values, poses);
            }
        }
        Ok(false)
    }

    /// After a walk for the robust size.
    fn sized(&mut self, size: f32, solver: &mut JointSolver) -> bool {
        if self.report.passes == 0 {
            self.scale = size;
        } else if size < 0.9 * self.scale {
            // It has shrunk with the misclosures; costs are then of another measure.
            (self.scale, self.best_cost) = (size, f32::INFINITY);
        } else {
            return self.settle(solver);
        }
        self.next_pass(solver)
    }

    /// After a walk for the rows: damps, solves and moves the values, or goes back to the best ones.
    fn passed(
        &mut self,
        pass: Pass,
        solver: &mut JointSolver,
        values: &mut Values,
        poses: usize,
    ) -> Result<bool, SolveError> {
        let used = poses as f32 - pass.left_out as f32;
        self.report.left_out = pass.left_out;
        self.report.whitened_rms = sqrt(pass.squares / (solver.channels as f32 * used).max(1.0));
        let cost = pass.cost + solver.enter_priors(values);
        if !pass.again {
            if cost > self.best_cost * WORSE {
                self.go_back(solver, values);
                return Ok(false);
            }
            (self.best, self.best_cost) = (*values, cost);
            self.damping /= DAMPING_GROWTH;
        }
        if self.damping >= DAMPING / DAMPING_GROWTH {
            solver.damp(self.damping);
        }
        self.moved = solver.step(values)?;
        let solution = solver.estimator().solution();
        self.report.rank = solution.rank as u32;
        self.report.condition = solution.condition_equilibrated;
        if self.moved < NEAR {
            solver.median.clear();
            self.walk = Walk::Size;
            return Ok(false);
        }
        Ok(self.settle(solver))
    }

    /// To the best values so far, from which a smaller step is taken.
    fn go_back(&mut self, solver: &mut JointSolver, values: &mut Values) {
        self.damping = if self.damping == 0.0 {
            DAMPING
        } else {
            self.damping * DAMPING_GROWTH
        };
        *values = self.best;
        self.begin_pass(true, solver);
    }

    /// True if the fit has ended.
    fn settle(&mut self, solver: &mut JointSolver) -> bool {
        self.report.settled = self.moved < SETTLED && self.damping < DAMPING;
        self.report.settled || self.next_pass(solver)
    }

    /// True if there have been too many.
    fn next_pass(&mut self, solver: &mut JointSolver) -> bool {
        if self.report.passes >= PASSES {
            return true;
        }
        self.report.passes += 1;
        self.begin_pass(false, solver);
        false
    }

    fn begin_pass(&mut self, again: bool, solver: &mut JointSolver) {
        self.walk = Walk::Rows(Pass {
            again,
            ..Pass::default()
        });
        solver.estimator.reset(solver.free.len());
    }
}

impl Pass {
    /// Rotates a pose's rows in, weighted by how far off it is.
    fn enter(&mut self, solver: &mut JointSolver, rows: &Rows, scale: f32) {
        let square = solver.square(&rows.misclosure);
        let ratio = sqrt(square) / scale;
        if ratio.is_nan() || ratio > LEFT_OUT {
            self.left_out += 1;
            self.cost += (2.0 * LEFT_OUT - FULL_WEIGHT) * FULL_WEIGHT * scale * scale;
            return;
        }
        self.squares += square;
        let weight = if ratio > FULL_WEIGHT {
            FULL_WEIGHT / ratio
        } else {
            1.0
        };
        self.cost += if weight < 1.0 {
            square * weight * (2.0 - weight)
        } else {
            square
        };
        let root = sqrt(weight);
        let used = rows.jacobian.iter().zip(rows.misclosure);
        for (row, misclosure) in used.take(solver.channels) {
            solver.enter(row, -misclosure, root);
        }
    }
}

impl JointSolver {
    /// Fits the unknowns of some groups to the poses, from `values` on, in place.
    ///
    /// # Errors
    /// [`SolveError`]; `values` are then the best so far.
    pub fn fit(
        &mut self,
        constraints: &Constraints,
        samples: &impl Poses,
        groups: Groups,
        values: &mut Values,
    ) -> Result<FitReport, SolveError> {
        let mut fit = Fit::idle();
        fit.begin(self, constraints, groups);
        let mut walk = samples.clone();
        loop {
            let sample = walk.next();
            if sample.is_none() {
                walk = samples.clone();
            }
            let poses = samples.len();
            if fit.slice(self, constraints, values, sample.as_ref(), poses)? {
                return Ok(*fit.report());
            }
        }
    }
}
