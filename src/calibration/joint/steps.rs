//! The schedule: platen sensor by g_p; height, lever arm and beacon's place with the platen fixed; all together; then the
//! coordination sensor's own errors. Each step stays only if poses that no step fitted gain by it.

use super::constraint::{Constraints, Misclosure, ReadingNoise, Values};
use super::fit::Fit;
use super::layout::{Groups, JOINT_UNKNOWNS};
use super::sample::{JointBuffer, JointSample};
use super::solver::{FitReport, JointSolver};
use crate::calibration::spread::Spread;
use crate::lsq::SolveError;
use crate::math::sqrt;
use serde::{Deserialize, Serialize};

/// A gain must be this many of its own standard errors: by chance one useless step in 40 would pass, were its expected
/// gain zero; it is negative.
const SIGNIFICANT: f32 = 2.0;
/// Times that a step is fitted again with the noise it showed, and a change of noise not worth that.
const REWEIGHTINGS: u32 = 3;
const SAME_NOISE: f32 = 0.05;
/// Whitened misclosures longer than this many times their rms say nothing about a step.
const OUTLIER: f32 = 8.0;

/// A step of the schedule.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Step {
    /// Own-phase coefficients, by g_p.
    Platen,
    /// Height, lever arm and beacon's place, platen fixed.
    Mounting,
    /// Everything of the paper's 3.2 together.
    Joint,
    /// That and the diode's angle and difference of gains.
    Misalignment,
    /// That and the diode's terms of second and third degree.
    Nonlinearity,
}

impl Step {
    /// In order.
    pub const ALL: [Self; 5] = [
        Self::Platen,
        Self::Mounting,
        Self::Joint,
        Self::Misalignment,
        Self::Nonlinearity,
    ];
    /// The paper's three.
    pub const PAPER: [Self; 3] = [Self::Platen, Self::Mounting, Self::Joint];

    /// What it frees, given what the steps before have freed for good.
    fn groups(self, accepted: Groups) -> Groups {
        match self {
            Self::Platen => Groups::PLATEN,
            Self::Mounting => Groups::MOUNTING,
            Self::Joint => Groups::PAPER,
            Self::Misalignment => Groups::PAPER | Groups::MISALIGNMENT,
            Self::Nonlinearity => {
                Groups::PAPER | (accepted & Groups::MISALIGNMENT) | Groups::NONLINEARITY
            }
        }
    }
}

/// Residuals of the held-out poses at some values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HeldOut {
    /// Rms of g_p, g_x and g_y about their means, metres.
    pub rms_m: [f32; 3],
    /// Rms of the whitened misclosures.
    pub whitened_rms: f32,
}

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

impl ReadingNoise {
    /// Whether the difference is not worth another fit.
    fn is_about(&self, other: &Self) -> bool {
        let same = |a: f32, b: f32| (a / b - 1.0).abs() < SAME_NOISE;
        same(self.segment_m, other.segment_m) && same(self.displacement_m, other.displacement_m)
    }
}

/// Noise as the poses show it, not below the stated: segments by g_p, deflections by what of g_x the segments leave.
#[derive(Debug)]
struct ShownNoise {
    misclosures: [Spread; 3],
    segment_share_of_x: f32,
}

impl ShownNoise {
    const NONE: Self = Self {
        misclosures: [Spread::EMPTY; 3],
        segment_share_of_x: 0.0,
    };

    fn add(&mut self, constraints: &Constraints, values: &Values, sample: &JointSample) {
        let misclosure = constraints.misclosure(values, sample);
        for (spread, g) in self.misclosures.iter_mut().zip(misclosure) {
            spread.add_within(g, OUTLIER);
        }
        self.segment_share_of_x += constraints.segment_share_of_x(values, sample);
    }

    fn noise(&self, constraints: &Constraints, step: Step, poses: usize) -> ReadingNoise {
        let stated = constraints.stated_noise;
        let segment_m = stated.segment_m.max(self.misclosures[0].deviation() / 2.0);
        if step == Step::Platen {
            return ReadingNoise {
                segment_m,
                ..constraints.noise
            };
        }
        let of_x = self.misclosures[1].deviation();
        let share = self.segment_share_of_x / poses as f32;
        let left = of_x * of_x - share * segment_m * segment_m;
        ReadingNoise {
            segment_m,
            displacement_m: stated.displacement_m.max(sqrt(left.max(0.0))),
        }
    }
}

/// What held-out poses gain by a step; both sides are whitened by the covariance of the values after.
#[derive(Debug)]
struct Comparison {
    /// A pose that is farther off after the step is no evidence for or against it.
    limit: f32,
    gain: Spread,
    before: Side,
    after: Side,
}

impl Comparison {
    const NONE: Self = Self {
        limit: 0.0,
        gain: Spread::EMPTY,
        before: Side::NONE,
        after: Side::NONE,
    };

    /// Poses that are not much farther off than the others, of whose squares the median is given.
    fn within(median_square: f32) -> Self {
        Self {
            limit: OUTLIER * OUTLIER * median_square.max(1.0),
            ..Self::NONE
        }
    }

    fn add(
        &mut self,
        constraints: &Constraints,
        solver: &JointSolver,
        [before, after]: [&Values; 2],
        sample: &JointSample,
    ) {
        let squares = [before, after]
            .map(|values| solver.square(&constraints.whitened(values, after, sample)));
        if squares[1].is_nan() || squares[1] > self.limit {
            return;
        }
        self.gain.add(squares[0] - squares[1]);
        let sides = [&mut self.before, &mut self.after];
        for ((side, values), square) in sides.into_iter().zip([before, after]).zip(squares) {
            side.add(constraints.misclosure(values, sample), square);
        }
    }

    /// Mean gain over its standard error.
    fn significance(&self) -> f32 {
        let error = self.gain.deviation() / sqrt(self.gain.count().max(1.0));
        if error > 0.0 {
            self.gain.mean() / error
        } else {
            0.0
        }
    }
}

#[derive(Debug)]
struct Side {
    spreads: [Spread; 3],
    squares: f32,
}

impl Side {
    const NONE: Self = Self {
        spreads: [Spread::EMPTY; 3],
        squares: 0.0,
    };

    fn add(&mut self, misclosure: Misclosure, square: f32) {
        for (spread, g) in self.spreads.iter_mut().zip(misclosure) {
            spread.add(g);
        }
        self.squares += square;
    }

    fn held_out(&self, channels: usize) -> HeldOut {
        let count = channels as f32 * self.spreads[0].count().max(1.0);
        HeldOut {
            rms_m: self.spreads.map(|s| s.deviation()),
            whitened_rms: sqrt(self.squares / count),
        }
    }
}
