//! Poses under the beacon: where to go next, and what a set of poses will tell before anything moves.

use super::constraint::Constraints;
use super::layout::{Groups, JOINT_UNKNOWNS, Values};
use super::sample::JointSample;
use super::solver::JointSolver;
use crate::equations::outputs;
use crate::frame::SEGMENTS;
use crate::math::{round, sincos_turns, sqrt};
use crate::plan::{Planner, RelativePose};
use crate::sample::Sample;
use core::f32::consts::TAU;

/// Candidates per chosen pose. A bound on the work: the best of so many is taken. Cost of a choice: as many times six
/// substitutions of 61 unknowns, about 5 Mcycles.
const CANDIDATES: usize = 16;
/// Phases per pitch at which a predicted deviation is looked at, along. Derived from the sampling theorem, with a factor of two:
/// four per period of order 6.
const OWN_PHASES: usize = 24;
/// The same across. Derived from the sampling theorem, with a factor of two: four per period of order 2.
const LATERAL_PHASES: usize = 8;

/// The pose that turns by an angle about the coordination sensor and displaces that by `(x_m, y_m)`: relative to where the
/// courier stands straight under the beacon.
#[must_use]
pub fn about_sensor(lever_m: [f32; 2], displaced: RelativePose) -> RelativePose {
    let [lx, ly] = lever_m;
    let (sine, _) = sincos_turns(displaced.theta_rad / TAU);
    let (half, _) = sincos_turns(0.5 * displaced.theta_rad / TAU);
    let rest = 2.0 * half * half;
    RelativePose {
        x_m: displaced.x_m - rest * lx - sine * ly,
        y_m: displaced.y_m + sine * lx - rest * ly,
        theta_rad: displaced.theta_rad,
    }
}

/// The sample to be expected at a pose relative to the first, by entered values.
#[must_use]
pub fn foreseen_under_beacon(
    constraints: &Constraints,
    values: &Values,
    start: &Sample,
    pose: &RelativePose,
) -> JointSample {
    let geometry = &constraints.geometry;
    let moved = outputs([pose.x_m, pose.y_m], pose.theta_rad, geometry.span_m);
    let mut sample = JointSample::ZERO;
    for i in 0..SEGMENTS {
        let turns = start.unmodified[i].fraction_turns + moved[i] / geometry.pitch_m;
        let (whole, teeth) = round(turns);
        sample.fraction_turns[i] = turns - whole;
        sample.teeth[i] = i16::try_from(teeth).unwrap_or_default();
    }
    let lever = constraints.layout.lever();
    let straight = about_sensor(
        [values[lever], values[lever + 1]],
        RelativePose {
            x_m: 0.0,
            y_m: 0.0,
            ..*pose
        },
    );
    let (dx, dy) = (pose.x_m - straight.x_m, pose.y_m - straight.y_m);
    let (s, c) = sincos_turns(pose.theta_rad / TAU);
    let scale = values[constraints.layout.height()] * geometry.tan_full_scale;
    sample.deflection = [(c * dx + s * dy) / scale, (c * dy - s * dx) / scale];
    sample
}

impl JointSolver {
    /// Starts a plan: nothing known but the priors.
    pub fn begin_plan(&mut self, constraints: &Constraints, values: &Values, groups: Groups) {
        self.free = constraints.layout.free(groups);
        self.estimator.reset(self.free.len());
        self.enter_priors(values);
    }

    /// Adds a pose to the plan.
    #[inline(never)] // its stack is not that of the way on to the next pose
    pub fn add_to_plan(
        &mut self,
        constraints: &Constraints,
        values: &Values,
        sample: &JointSample,
    ) {
        for row in &constraints.rows(values, sample).jacobian {
            self.enter(row, 0.0, 1.0);
        }
    }

    /// Best of some poses for the plan so far: the one that takes most from the coefficients' variances.
    pub fn choose(
        &self,
        constraints: &Constraints,
        values: &Values,
        start: &Sample,
        planner: &mut Planner,
    ) -> RelativePose {
        let lever = constraints.layout.lever();
        let mut best = (RelativePose::default(), -1.0);
        for candidate in 0..CANDIDATES {
            let displaced = planner.centred(candidate % 2 == 1);
            let pose = about_sensor([values[lever], values[lever + 1]], displaced);
            let gain = self.variance_gain(
                constraints,
                values,
                &foreseen_under_beacon(constraints, values, start, &pose),
            );
            if gain > best.1 {
                best = (pose, gain);
            }
        }
        best.0
    }

    /// Sum over the three rows of how much each alone would lower the coefficients' variances.
    fn variance_gain(
        &self,
        constraints: &Constraints,
        values: &Values,
        sample: &JointSample,
    ) -> f32 {
        let coefficients = self
            .free
            .iter()
            .filter(|&&i| usize::from(i) < constraints.layout.parity_offset())
            .count();
        let rows = constraints.rows(values, sample);
        let gain = |row: &Values| {
            let packed = self.packed(row);
            let (moved, leverage) = self.estimator.rows.pull(&packed[..self.free.len()])?;
            Some(moved[..coefficients].iter().map(|m| m * m).sum::<f32>() / (1.0 + leverage))
        };
        rows.jacobian.iter().filter_map(gain).sum()
    }

    fn packed(&self, row: &Values) -> Values {
        let mut packed = [0.0; JOINT_UNKNOWNS];
        for (to, &from) in packed.iter_mut().zip(&self.free) {
            *to = row[usize::from(from)];
        }
        packed
    }

    /// Predicted rms deviation of a correction over segments and phases, constants aside, metres; for the poses planned or
    /// fitted so far. Cost: 40 substitutions.
    #[must_use]
    pub fn rms_deviation_m(&self, constraints: &Constraints) -> f32 {
        let coefficients = self
            .free
            .iter()
            .filter(|&&i| usize::from(i) < constraints.layout.parity_offset())
            .count();
        let variance = |column: usize| {
            let mut unit = [0.0; JOINT_UNKNOWNS];
            unit[column] = 1.0;
            self.estimator
                .rows
                .predict(&unit[..self.free.len()])
                .map_or(f32::INFINITY, |p| p.leverage)
        };
        // Half of a sine's square, over four segments.
        sqrt((0..coefficients).map(variance).sum::<f32>() / (2.0 * SEGMENTS as f32))
    }

    /// Largest predicted standard deviation of a segment's correction over own and lateral phases, constants aside,
    /// metres; for the poses planned or fitted so far. Cost: 768 substitutions.
    #[must_use]
    pub fn worst_deviation_m(&self, constraints: &Constraints) -> f32 {
        let layout = &constraints.layout;
        let mut worst = 0.0f32;
        for step in 0..OWN_PHASES * LATERAL_PHASES {
            let own = (step / LATERAL_PHASES) as f32 / OWN_PHASES as f32;
            let lateral = (step % LATERAL_PHASES) as f32 / LATERAL_PHASES as f32;
            for segment in 0..SEGMENTS {
                let mut functional = [0.0; JOINT_UNKNOWNS];
                let mut columns = functional[segment * layout.columns()..]
                    .as_chunks_mut::<2>()
                    .0
                    .iter_mut();
                for ((_, term), pair) in layout.terms.iter().zip(&mut columns) {
                    let turns =
                        own * f32::from(term.own_order) + lateral * f32::from(term.lateral_order);
                    let (sine, cosine) = crate::math::sincos_turns(turns);
                    let still = if term.theta_power == 0 { 1.0 } else { 0.0 };
                    *pair = [still * sine, still * cosine];
                }
                let packed = self.packed(&functional);
                let prediction = self.estimator.rows.predict(&packed[..self.free.len()]);
                worst = worst.max(prediction.map_or(f32::INFINITY, |p| p.leverage));
            }
        }
        sqrt(worst)
    }
}
