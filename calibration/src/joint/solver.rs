//! What a joint fit works with: rows, priors and the present solution. [`super::fit`] drives it.

use super::constraint::{Constraints, Misclosure};
use super::layout::{Groups, JOINT_UNKNOWNS, Unknown, Values};
use super::median::Median;
use crate::lsq::{Estimator, SolveError, Triangle, packed_len};
use crate::math::sqrt;
use serde::{Deserialize, Serialize};

/// Rows of a joint fit.
pub type JointRows = Triangle<JOINT_UNKNOWNS, { packed_len(JOINT_UNKNOWNS) }>;
/// Rows, workspace and solution of a joint fit; 20 KiB.
pub type JointEstimator = Estimator<JOINT_UNKNOWNS, { packed_len(JOINT_UNKNOWNS) }>;

/// Standard deviations of what is believed before the data, by kind of unknown. Entered as rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Priors {
    /// Coefficients of the error model, about zero, metres. Three times the largest of domain encoders.
    pub coefficient_m: f32,
    /// Parity offset, metres: half a pitch.
    pub parity_offset_m: f32,
    /// Angle offset, metres: 5 mrad over the span, how well segments are mounted.
    pub angle_offset_m: f32,
    /// Height, as a share of the entered one.
    pub height_share: f32,
    /// Lever arm, each component, as a share of its entered length.
    pub lever_share: f32,
    /// Beacon's place, metres.
    pub place_m: f32,
    /// Difference of gains, and angle in radians.
    pub misalignment: f32,
    /// Terms of second and third degree at full scale: 17 % of the linear term is published.
    pub nonlinearity: f32,
}

impl Default for Priors {
    fn default() -> Self {
        Self {
            coefficient_m: 60.0e-6,
            parity_offset_m: 0.5e-3,
            angle_offset_m: 0.1e-3,
            height_share: 0.3,
            lever_share: 0.3,
            place_m: 20.0e-3,
            misalignment: 0.1,
            nonlinearity: 0.2,
        }
    }
}

/// How a fit ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FitReport {
    /// Unknowns that were free.
    pub unknowns: u32,
    /// Directions that rows and priors determine.
    pub rank: u32,
    /// Condition number of the whitened rows, columns brought to equal length.
    pub condition: f32,
    /// Passes over the poses.
    pub passes: u32,
    /// Whether the last one moved nothing.
    pub settled: bool,
    /// Rms of the whitened misclosures: 1 where model and stated noise hold.
    pub whitened_rms: f32,
    /// Poses left out as outliers.
    pub left_out: u32,
}

/// Solver with its state; to live in a static.
#[derive(Debug)]
pub struct JointSolver {
    pub(super) estimator: JointEstimator,
    pub(super) free: heapless::Vec<u8, JOINT_UNKNOWNS>,
    prior_centre: Values,
    prior_deviation: Values,
    /// Constraints in use: g_p alone, or all three.
    pub(super) channels: usize,
    /// Of squared misclosures.
    pub(super) median: Median,
}

impl Default for JointSolver {
    fn default() -> Self {
        Self::new()
    }
}

impl JointSolver {
    /// All zeros, so that as a constant it is a clearing of memory in its place; [`JointSolver::set_priors`] comes before all else.
    pub const fn new() -> Self {
        Self {
            estimator: Estimator::blank(),
            free: heapless::Vec::new(),
            prior_centre: [0.0; JOINT_UNKNOWNS],
            prior_deviation: [0.0; JOINT_UNKNOWNS],
            channels: 0,
            median: Median::new(),
        }
    }

    /// States what is believed before the data: the entered values of height and lever arm, zero for the rest.
    pub fn set_priors(&mut self, constraints: &Constraints, entered: &Values, priors: &Priors) {
        self.prior_deviation = [f32::INFINITY; JOINT_UNKNOWNS];
        self.channels = 3;
        let layout = &constraints.layout;
        let lever = layout.lever();
        let length_m =
            sqrt(entered[lever] * entered[lever] + entered[lever + 1] * entered[lever + 1]);
        for i in 0..layout.len() {
            let (centre, deviation) = match layout.unknown(i) {
                Unknown::Coefficient { .. } => (0.0, priors.coefficient_m),
                Unknown::ParityOffset => (0.0, priors.parity_offset_m),
                Unknown::AngleOffset => (0.0, priors.angle_offset_m),
                Unknown::Height => (entered[i], priors.height_share * entered[i].abs()),
                Unknown::Lever(_) => (entered[i], priors.lever_share * length_m),
                Unknown::Place(_) => (entered[i], priors.place_m),
                Unknown::GainDifference | Unknown::Turn => (0.0, priors.misalignment),
                Unknown::Nonlinearity(..) => (0.0, priors.nonlinearity),
            };
            self.prior_centre[i] = centre;
            self.prior_deviation[i] = deviation;
        }
    }

    /// Standard deviation of an unknown by its prior alone.
    #[must_use]
    pub fn prior_deviation(&self, index: usize) -> f32 {
        self.prior_deviation
            .get(index)
            .copied()
            .unwrap_or(f32::INFINITY)
    }

    /// Standard deviation of an unknown after the last fit, for the stated noise, and whether it is mostly its prior's:
    /// then the data do not tell it. `None` if it was not free.
    #[must_use]
    pub fn deviation(&self, index: usize) -> Option<(f32, bool)> {
        let column = self.free.iter().position(|&i| usize::from(i) == index)?;
        let deviation = sqrt(self.estimator.covariance(column, column));
        Some((deviation, deviation > 0.7 * self.prior_deviation(index)))
    }

    /// Estimator of the last fit; its unknowns are the free ones, in order.
    #[must_use]
    pub fn estimator(&self) -> &JointEstimator {
        &self.estimator
    }

    /// Indices of the unknowns that were free.
    #[must_use]
    pub fn free(&self) -> &[u8] {
        &self.free
    }

    /// Frees the unknowns of some groups, and picks the constraints that tell them.
    pub(super) fn free_groups(&mut self, constraints: &Constraints, groups: Groups) {
        self.free = constraints.layout.free(groups);
        // g_p comes first in the whitening, so its row alone is right when g_x and g_y are not used.
        self.channels = if Groups::PLATEN.contains(groups) {
            1
        } else {
            3
        };
    }

    /// Sum of squares over the constraints in use.
    pub(super) fn square(&self, whitened: &Misclosure) -> f32 {
        whitened.iter().take(self.channels).map(|w| w * w).sum()
    }

    pub(super) fn enter(&mut self, row: &Values, rhs: f32, factor: f32) {
        let mut packed = [0.0; JOINT_UNKNOWNS];
        for (to, &from) in packed.iter_mut().zip(&self.free) {
            *to = row[usize::from(from)] * factor;
        }
        // Rows of poses whose misclosure is finite; any other is refused and counts for nothing.
        let _ = self
            .estimator
            .rows
            .enter(&packed[..self.free.len()], rhs * factor);
    }

    pub(super) fn enter_priors(&mut self, values: &Values) -> f32 {
        let mut cost = 0.0;
        for column in 0..self.free.len() {
            let i = usize::from(self.free[column]);
            let weight = 1.0 / self.prior_deviation[i];
            let off = (self.prior_centre[i] - values[i]) * weight;
            self.enter_one(column, weight, off);
            cost += off * off;
        }
        cost
    }

    /// Rows that hold each unknown back by its column's length times `damping`.
    pub(super) fn damp(&mut self, damping: f32) {
        for column in 0..self.free.len() {
            let length = (0..=column)
                .map(|row| self.estimator.rows.entry(row, column))
                .fold(0.0, |a, b| a + b * b);
            self.enter_one(column, sqrt(damping * length), 0.0);
        }
    }

    fn enter_one(&mut self, column: usize, entry: f32, rhs: f32) {
        let mut row = [0.0; JOINT_UNKNOWNS];
        row[column] = entry;
        let _ = self.estimator.rows.enter(&row[..self.free.len()], rhs);
    }

    /// Solves and moves the values, at most by one prior deviation each; returns the largest move in standard deviations.
    pub(super) fn step(&mut self, values: &mut Values) -> Result<f32, SolveError> {
        self.estimator.solve_equilibrated()?;
        let solution = self.estimator.solution();
        let (moves, unit) = (&solution.values, 1.0 / solution.noise);
        let mut share = 1.0f32;
        for (&i, change) in self.free.iter().zip(moves) {
            let allowed = self.prior_deviation[usize::from(i)];
            share = share.min(allowed / change.abs().max(1.0e-30));
        }
        let mut largest = 0.0f32;
        for (column, &i) in self.free.iter().enumerate() {
            let change = moves[column] * share;
            values[usize::from(i)] += change;
            largest = largest.max(change.abs() / (solution.deviations[column] * unit));
        }
        Ok(largest / share)
    }
}
