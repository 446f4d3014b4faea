//! The schedule: platen sensor by g_p; height, lever arm and beacon's place with the platen fixed; all together; then the
//! coordination sensor's own errors. Each step stays only if poses that no step fitted gain by it.

mod comparison;
mod shown;
mod step;

pub use comparison::HeldOut;
pub use step::Step;

use self::comparison::Comparison;
use self::shown::ShownNoise;
use super::constraint::{Constraints, ReadingNoise};
use super::fit::Fit;
use super::layout::{Groups, JOINT_UNKNOWNS, Values};
use super::sample::JointBuffer;
use super::solver::{FitReport, JointSolver};
use crate::lsq::SolveError;
use serde::{Deserialize, Serialize};

/// A gain must be this many of its own standard errors. Derived from the normal tail: by chance one useless step in 40 would
/// pass, were its expected gain zero; it is negative.
const SIGNIFICANT: f32 = 2.0;
/// Times that a step is fitted again with the noise it showed. A bound on the work: the noise that the last one showed is told as
/// it is.
const REWEIGHTINGS: u32 = 3;
/// What a step did.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StepReport {
    /// Which.
    pub step: Step,
    /// What was free.
    pub groups: Groups,
    /// The fit.
    pub fit: FitReport,
    /// Before, whitened as after.
    pub before: HeldOut,
    /// After.
    pub after: HeldOut,
    /// Mean gain in squared whitened misclosure over its standard error.
    pub significance: f32,
    /// Whether it stays; if not, the values are as before.
    pub accepted: bool,
}

/// A joint calibration under way: values, and what has been accepted.
#[derive(Clone, Debug)]
pub struct JointProgress {
    /// Present values.
    pub values: Values,
    /// Groups of accepted steps.
    pub accepted: Groups,
}

/// A step that is being made. The readings' noise is taken from the poses themselves where they show more than was stated
/// (unmodelled structure, the platen's teeth above all, is noise to the fit), and the fit repeated with it.
#[derive(Debug)]
pub struct Trial {
    step: Step,
    groups: Groups,
    /// Before the step.
    noise: ReadingNoise,
    values: Values,
    walk: Walk,
    /// Pose that is next in the walk.
    next: usize,
    fits: u32,
    fit: Fit,
    shown: ShownNoise,
    comparison: Comparison,
}

/// A walk over the poses.
#[derive(Clone, Copy, Debug)]
enum Walk {
    /// The fit's, over those to be fitted.
    Fit,
    /// For the noise that these show.
    Noise,
    /// For the median of the held-out poses' squared misclosures.
    Size,
    /// For what the held-out poses gain.
    Gain,
}

impl Default for Trial {
    fn default() -> Self {
        Self::idle()
    }
}

impl Trial {
    /// Of nothing: all zeros.
    #[must_use]
    pub const fn idle() -> Self {
        Self {
            step: Step::Platen,
            groups: Groups::empty(),
            noise: ReadingNoise {
                segment_m: 0.0,
                displacement_m: 0.0,
            },
            values: [0.0; JOINT_UNKNOWNS],
            walk: Walk::Fit,
            next: 0,
            fits: 0,
            fit: Fit::idle(),
            shown: ShownNoise::NONE,
            comparison: Comparison::NONE,
        }
    }

    /// Begins with a step from the present values; then [`Trial::slice`], again and again.
    pub fn begin(
        &mut self,
        step: Step,
        constraints: &Constraints,
        solver: &mut JointSolver,
        progress: &JointProgress,
    ) {
        (self.step, self.groups) = (step, step.groups(progress.accepted));
        self.noise = constraints.noise;
        self.values = progress.values;
        (self.next, self.fits) = (0, 0);
        self.begin_fit(constraints, solver);
    }

    fn begin_fit(&mut self, constraints: &Constraints, solver: &mut JointSolver) {
        self.fits += 1;
        self.walk = Walk::Fit;
        self.fit.begin(solver, constraints, self.groups);
    }

    /// Goes on by a pose; tells what came of the step when it is made. Cost: 110,000 cycles, now and then a solution's.
    ///
    /// # Errors
    /// [`SolveError`]; nothing is changed.
    pub fn slice(
        &mut self,
        constraints: &mut Constraints,
        solver: &mut JointSolver,
        buffer: &JointBuffer,
        progress: &mut JointProgress,
    ) -> Result<Option<StepReport>, SolveError> {
        let poses = match self.walk {
            Walk::Fit | Walk::Noise => buffer.fitted(),
            Walk::Size | Walk::Gain => buffer.held_out(),
        };
        let sample = poses.get(self.next);
        self.next = sample.map_or(0, |_| self.next + 1);
        let (values, count) = (&mut self.values, poses.len());
        match (self.walk, sample) {
            (Walk::Fit, sample) => {
                let fit = &mut self.fit;
                let sliced = fit.slice(solver, constraints, values, sample.as_ref(), count);
                if sliced.inspect_err(|_| constraints.noise = self.noise)? {
                    self.end_fit(solver);
                }
            }
            (Walk::Noise, Some(sample)) => self.shown.add(constraints, values, &sample),
            (Walk::Noise, None) => self.take_noise(constraints, solver, count),
            (Walk::Size, Some(sample)) => {
                let square = solver.square(&constraints.whitened(values, values, &sample));
                solver.median.add(square);
            }
            (Walk::Size, None) => {
                self.comparison = Comparison::within(solver.median.upper(count));
                self.walk = Walk::Gain;
            }
            (Walk::Gain, Some(sample)) => {
                let sides = [&progress.values, &*values];
                self.comparison.add(constraints, solver, sides, &sample);
            }
            (Walk::Gain, None) => return Ok(Some(self.judge(constraints, solver, progress))),
        }
        Ok(None)
    }

    fn end_fit(&mut self, solver: &mut JointSolver) {
        if self.fits > REWEIGHTINGS {
            return self.compare(solver);
        }
        self.shown = ShownNoise::NONE;
        self.walk = Walk::Noise;
    }

    fn take_noise(
        &mut self,
        constraints: &mut Constraints,
        solver: &mut JointSolver,
        poses: usize,
    ) {
        let shown = self.shown.noise(constraints, self.step, poses);
        let before = core::mem::replace(&mut constraints.noise, shown);
        if shown.is_about(&before) {
            self.compare(solver);
        } else {
            self.begin_fit(constraints, solver);
        }
    }

    fn compare(&mut self, solver: &mut JointSolver) {
        solver.median.clear();
        self.walk = Walk::Size;
    }

    /// Keeps what the step has found, or goes back to what was before.
    fn judge(
        &self,
        constraints: &mut Constraints,
        solver: &JointSolver,
        progress: &mut JointProgress,
    ) -> StepReport {
        let fit = *self.fit.report();
        let (comparison, channels) = (&self.comparison, solver.channels);
        let significance = comparison.significance();
        // What has not settled is not where the data want it, whatever it gains.
        let accepted = significance > SIGNIFICANT && fit.settled;
        if accepted {
            progress.values = self.values;
            progress.accepted |= self.groups;
        } else {
            constraints.noise = self.noise;
        }
        StepReport {
            step: self.step,
            groups: self.groups,
            fit,
            before: comparison.before.held_out(channels),
            after: comparison.after.held_out(channels),
            significance,
            accepted,
        }
    }
}
