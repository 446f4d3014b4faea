//! The schedule: platen sensor by g_p; height, lever arm and beacon's place with the platen fixed; all together; then the
//! coordination sensor's own errors. Each step stays only if poses that no step fitted gain by it.

use super::constraint::{Constraints, Misclosure, ReadingNoise, Values};
use super::layout::Groups;
use super::sample::{JointBuffer, Poses};
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

/// Makes one step. The readings' noise is taken from the poses themselves where they show more than was stated
/// (unmodelled structure, the platen's teeth above all, is noise to the fit), and the fit repeated with it.
///
/// # Errors
/// [`SolveError`]; nothing is changed.
pub fn make_step(
    step: Step,
    constraints: &mut Constraints,
    solver: &mut JointSolver,
    buffer: &JointBuffer,
    progress: &mut JointProgress,
    breathe: &mut dyn FnMut(),
) -> Result<StepReport, SolveError> {
    let (groups, noise) = (step.groups(progress.accepted), constraints.noise);
    let mut values = progress.values;
    let fit = fit_with_shown_noise(
        step,
        constraints,
        solver,
        &buffer.fitted(),
        groups,
        &mut values,
        breathe,
    );
    let fit = fit.inspect_err(|_| constraints.noise = noise)?;
    let channels = if step == Step::Platen { 1 } else { 3 };
    let comparison = Comparison::of(
        constraints,
        &buffer.held_out(),
        &progress.values,
        &values,
        channels,
        breathe,
    );
    // What has not settled is not where the data want it, whatever it gains.
    let accepted = comparison.significance > SIGNIFICANT && fit.settled;
    if accepted {
        progress.values = values;
        progress.accepted |= groups;
    } else {
        constraints.noise = noise;
    }
    let Comparison {
        before,
        after,
        significance,
    } = comparison;
    Ok(StepReport {
        step,
        groups,
        fit,
        before,
        after,
        significance,
        accepted,
    })
}

fn fit_with_shown_noise(
    step: Step,
    constraints: &mut Constraints,
    solver: &mut JointSolver,
    samples: &impl Poses,
    groups: Groups,
    values: &mut Values,
    breathe: &mut dyn FnMut(),
) -> Result<FitReport, SolveError> {
    let mut report = solver.fit(constraints, samples, groups, values, breathe)?;
    for _ in 0..REWEIGHTINGS {
        let (before, shown) = (
            constraints.noise,
            shown_noise(constraints, samples, values, step, breathe),
        );
        constraints.noise = shown;
        let same = |a: f32, b: f32| (a / b - 1.0).abs() < SAME_NOISE;
        if same(shown.segment_m, before.segment_m)
            && same(shown.displacement_m, before.displacement_m)
        {
            break;
        }
        report = solver.fit(constraints, samples, groups, values, breathe)?;
    }
    Ok(report)
}

/// Noise as the poses show it, not below the stated: segments by g_p, deflections by what of g_x the segments leave.
fn shown_noise(
    constraints: &Constraints,
    samples: &impl Poses,
    values: &Values,
    step: Step,
    breathe: &mut dyn FnMut(),
) -> ReadingNoise {
    let mut shown = [Spread::EMPTY; 3];
    let mut share = 0.0;
    for sample in samples.clone() {
        breathe();
        let misclosure = constraints.misclosure(values, &sample);
        for (spread, g) in shown.iter_mut().zip(misclosure) {
            spread.add_within(g, OUTLIER);
        }
        share += constraints.segment_share_of_x(values, &sample) / samples.len() as f32;
    }
    let stated = constraints.stated_noise;
    let segment_m = stated.segment_m.max(shown[0].deviation() / 2.0);
    if step == Step::Platen {
        return ReadingNoise {
            segment_m,
            ..constraints.noise
        };
    }
    let of_x = shown[1].deviation();
    let left = of_x * of_x - share * segment_m * segment_m;
    ReadingNoise {
        segment_m,
        displacement_m: stated.displacement_m.max(sqrt(left.max(0.0))),
    }
}

struct Comparison {
    before: HeldOut,
    after: HeldOut,
    significance: f32,
}

impl Comparison {
    /// Both sides whitened by the covariance of the values after.
    fn of(
        constraints: &Constraints,
        samples: &impl Poses,
        before: &Values,
        after: &Values,
        channels: usize,
        breathe: &mut dyn FnMut(),
    ) -> Self {
        let square = |w: Misclosure| w.iter().take(channels).map(|w| w * w).sum::<f32>();
        let mut sides = [Side::default(), Side::default()];
        let mut gain = Spread::EMPTY;
        let limit =
            OUTLIER * OUTLIER * median_square(constraints, samples, after, channels, breathe);
        for sample in samples.clone() {
            breathe();
            let squares =
                [before, after].map(|values| square(constraints.whitened(values, after, &sample)));
            // A pose that is far off after the step, by the measure of the others, is no evidence for or against it.
            if squares[1].is_nan() || squares[1] > limit {
                continue;
            }
            gain.add(squares[0] - squares[1]);
            for ((side, values), square) in sides.iter_mut().zip([before, after]).zip(squares) {
                side.add(constraints.misclosure(values, &sample), square);
            }
        }
        let error = gain.deviation() / sqrt(gain.count().max(1.0));
        let significance = if error > 0.0 {
            gain.mean() / error
        } else {
            0.0
        };
        let [before, after] = sides.map(|side| side.held_out(channels));
        Self {
            before,
            after,
            significance,
        }
    }
}

#[derive(Clone, Copy, Default)]
struct Side {
    spreads: [Spread; 3],
    squares: f32,
}

impl Side {
    fn add(&mut self, misclosure: Misclosure, square: f32) {
        for (spread, g) in self.spreads.iter_mut().zip(misclosure) {
            spread.add(g);
        }
        self.squares += square;
    }

    fn held_out(self, channels: usize) -> HeldOut {
        let count = channels as f32 * self.spreads[0].count().max(1.0);
        HeldOut {
            rms_m: self.spreads.map(|s| s.deviation()),
            whitened_rms: sqrt(self.squares / count),
        }
    }
}

/// Median, within an eighth, of the squared whitened misclosure, by bisection: no memory.
fn median_square(
    constraints: &Constraints,
    samples: &impl Poses,
    values: &Values,
    channels: usize,
    breathe: &mut dyn FnMut(),
) -> f32 {
    let (mut low, mut high) = (1.0e-3f32, 1.0e12f32);
    while high / low > 1.3 {
        let middle = sqrt(low * high);
        let below = samples.clone().filter(|sample| {
            breathe();
            let w = constraints.whitened(values, values, sample);
            w.iter().take(channels).map(|w| w * w).sum::<f32>() < middle
        });
        if 2 * below.count() > samples.len() {
            high = middle
        } else {
            low = middle
        }
    }
    high.max(1.0)
}
