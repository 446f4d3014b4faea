//! Where to go next.
//!
//! Every row of equation (7) has the same length, so what a plan can gain is balance. Random poses leave the difference
//! of a pair's equal coefficients weak: both segments see nearly the same phase unless the courier is turned. The
//! optimal plan chooses, among candidates of which half are turned as far as allowed, the pose that takes most from the
//! mean variance of the four corrections over a pitch (A-optimal; Pukelsheim 1993, sec. 6.5), which those weak directions
//! make up.
//!
//! Where a segment will read is told by where it read at the start and by the fit so far: with waves of 40 µm its phases come to lie
//! unevenly, and a plan that took them for even would spread its poses unevenly itself.
//!
//! Bound, for segments without waves: with phase differences `n d` of a pair at order n and `C_n = mean cos(n d)`, no design of M poses has
//! a smaller worst variance than `2 / M * sum 1 / (1 - C_n^2)`, by the criterion's convexity and the invariance under shifts. Waves turn a
//! pair's phases further apart or closer together, and so may leave somewhat less or more. At
//! ±0.5° that is 18.3 / M, random poses have 33 / M: the best plan needs more than half as many. At ±1.5° it is 8 / M.

use super::gate::PlatenEstimator;
use super::regression::{PLATEN_UNKNOWNS, Regression};
use super::sample::Sample;
use crate::equations::outputs;
use crate::frame::SEGMENTS;
use crate::math::round;
use rand_pcg::Lcg64Xsh32;
use rand_pcg::rand_core::Rng;
use serde::{Deserialize, Serialize};

/// Candidates per chosen pose. A bound on the work: the best of so many is taken. Cost of a choice: as many times two
/// substitutions of 33 unknowns, some 50 rows' worth.
const CANDIDATES: usize = 24;

/// Looks at a reading's own error. Derived from the slope of the corrections, a half at most (waves of 40 µm of orders 1 and 2):
/// an eighth of 40 µm is left, 5 µm of a place.
const LOOKS: usize = 3;

/// The generator's stream: any would do. By definition always the same, so that plans are.
const STREAM: u64 = 721_347_520_444_481_703;

/// How poses are chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Plan {
    /// Uniformly over the range, as in the paper.
    #[default]
    Random,
    /// Each to shrink the predicted deviation most.
    Optimal,
}

/// A pose relative to where the session started.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RelativePose {
    /// Along x, metres.
    pub x_m: f32,
    /// Along y, metres.
    pub y_m: f32,
    /// Counter-clockwise, radians.
    pub theta_rad: f32,
}

/// Range of poses: `0..travel_m` in x and y, `-turn_rad..turn_rad`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Range {
    /// Travel in x and y, metres.
    pub travel_m: f32,
    /// Largest angle, radians.
    pub turn_rad: f32,
}

/// The sample to be expected at a pose, from the one at the start; equation (4). `values`: the unknowns by what is known so far, metres; none
/// where that is nothing.
#[must_use]
pub fn foreseen(
    regression: &Regression,
    values: &[f32],
    start: &Sample,
    pose: &RelativePose,
) -> Sample {
    let geometry = regression.geometry();
    let moved = outputs([pose.x_m, pose.y_m], pose.theta_rad, geometry.span_m);
    let at_start = regression.corrections_m(values, start);
    let mut sample = advanced(start, moved, geometry.pitch_m);
    for _ in 0..LOOKS {
        // The calibrated outputs are what moves so far.
        let there = regression.corrections_m(values, &sample);
        let by = core::array::from_fn(|i| moved[i] + at_start[i] - there[i]);
        sample = advanced(start, by, geometry.pitch_m);
    }
    sample
}

/// Unmodified outputs that have gone on, metres.
fn advanced(start: &Sample, by_m: [f32; SEGMENTS], pitch_m: f32) -> Sample {
    let mut sample = *start;
    for (output, by_m) in sample.unmodified.iter_mut().zip(by_m) {
        let turns = output.fraction_turns + by_m / pitch_m;
        let (whole, teeth) = round(turns);
        output.fraction_turns = turns - whole;
        output.teeth = output.teeth.wrapping_add(teeth);
    }
    sample
}

/// The unknowns by the rows so far, metres; zeros while these are few: fewer than two for each unknown tell noise.
fn known(estimator: &PlatenEstimator) -> [f32; PLATEN_UNKNOWNS] {
    let (rows, mut values) = (&estimator.rows, [0.0; PLATEN_UNKNOWNS]);
    let unknowns = rows.unknowns().min(PLATEN_UNKNOWNS);
    if rows.effective_rows() < 2.0 * unknowns as f32 {
        return values;
    }
    for i in (0..unknowns).rev() {
        let others: f32 = (i + 1..unknowns)
            .map(|j| rows.entry(i, j) * values[j])
            .sum();
        let value = (rows.right_hand_side(i) - others) / rows.entry(i, i);
        values[i] = if value.is_finite() { value } else { 0.0 };
    }
    values
}

/// Draws poses.
#[derive(Clone, Debug)]
pub struct Planner {
    range: Range,
    seed: u64,
    /// Numbers drawn so far.
    drawn: u64,
}

impl Planner {
    /// From a seed; the same seed gives the same poses everywhere.
    #[must_use]
    pub const fn new(range: Range, seed: u64) -> Self {
        Self {
            range,
            seed,
            drawn: 0,
        }
    }

    /// Uniform over the range.
    pub fn random(&mut self) -> RelativePose {
        RelativePose {
            x_m: self.unit() * self.range.travel_m,
            y_m: self.unit() * self.range.travel_m,
            theta_rad: (2.0 * self.unit() - 1.0) * self.range.turn_rad,
        }
    }

    /// Uniform about the middle of the range, the angle as far as allowed to either side if `turned`.
    pub fn centred(&mut self, turned: bool) -> RelativePose {
        let pose = if turned { self.turned() } else { self.random() };
        let half = 0.5 * self.range.travel_m;
        RelativePose {
            x_m: pose.x_m - half,
            y_m: pose.y_m - half,
            ..pose
        }
    }

    /// Best of `CANDIDATES` poses for the estimate so far.
    pub fn optimal(
        &mut self,
        estimator: &PlatenEstimator,
        regression: &Regression,
        start: &Sample,
    ) -> RelativePose {
        let mut best = (RelativePose::default(), -1.0);
        let values = known(estimator);
        for candidate in 0..CANDIDATES {
            let pose = if candidate % 2 == 0 {
                self.random()
            } else {
                self.turned()
            };
            let sample = foreseen(regression, &values, start, &pose);
            let gain = variance_gain(estimator, regression, &sample);
            if gain > best.1 {
                best = (pose, gain);
            }
        }
        best.0
    }

    /// Uniform in 0..1, 24 bits. The generator is wound to its place: it cannot be made at compile time.
    fn unit(&mut self) -> f32 {
        let mut generator = Lcg64Xsh32::new(self.seed, STREAM);
        generator.advance(self.drawn);
        self.drawn += 1;
        (generator.next_u32() >> 8) as f32 / 16_777_216.0
    }

    /// Uniform in position, turned as far as allowed to either side.
    fn turned(&mut self) -> RelativePose {
        let pose = self.random();
        let turn = self.range.turn_rad;
        RelativePose {
            theta_rad: if pose.theta_rad < 0.0 { -turn } else { turn },
            ..pose
        }
    }
}

/// By how much a sample lowers the sum of the coefficients' variances, noise one: `|P v|^2 / (1 + v^T P v)` (Sherman and
/// Morrison 1950), the offset left out: it moves no position.
fn variance_gain(estimator: &PlatenEstimator, regression: &Regression, sample: &Sample) -> f32 {
    let unknowns = regression.unknowns();
    let (row, _) = regression.row(sample);
    let Some((moved, leverage)) = estimator.rows.pull(&row[..unknowns]) else {
        return 0.0;
    };
    let square: f32 = moved[..unknowns - 1].iter().map(|m| m * m).sum();
    square / (1.0 + leverage)
}
