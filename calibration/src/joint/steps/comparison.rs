//! What the poses that no step fitted say of one: before it and after it.

use super::step::OUTLIER;
use crate::joint::constraint::{Constraints, Misclosure};
use crate::joint::layout::Values;
use crate::joint::sample::JointSample;
use crate::joint::solver::JointSolver;
use crate::math::sqrt;
use crate::spread::Spread;
use serde::{Deserialize, Serialize};

/// Residuals of the held-out poses at some values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HeldOut {
    /// Rms of g_p, g_x and g_y about their means, metres.
    pub rms_m: [f32; 3],
    /// Rms of the whitened misclosures.
    pub whitened_rms: f32,
}

/// What held-out poses gain by a step; both sides are whitened by the covariance of the values after.
#[derive(Debug)]
pub(super) struct Comparison {
    /// A pose that is farther off after the step is no evidence for or against it.
    limit: f32,
    gain: Spread,
    pub(super) before: Side,
    pub(super) after: Side,
}

impl Comparison {
    pub(super) const NONE: Self = Self {
        limit: 0.0,
        gain: Spread::EMPTY,
        before: Side::NONE,
        after: Side::NONE,
    };

    /// Poses that are not much farther off than the others, of whose squares the median is given.
    pub(super) fn within(median_square: f32) -> Self {
        Self {
            limit: OUTLIER * OUTLIER * median_square.max(1.0),
            ..Self::NONE
        }
    }

    pub(super) fn add(
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
    pub(super) fn significance(&self) -> f32 {
        let error = self.gain.deviation() / sqrt(self.gain.count().max(1.0));
        if error > 0.0 {
            self.gain.mean() / error
        } else {
            0.0
        }
    }
}

/// Held-out poses on one side of a step.
#[derive(Debug)]
pub(super) struct Side {
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

    pub(super) fn held_out(&self, channels: usize) -> HeldOut {
        let count = channels as f32 * self.spreads[0].count().max(1.0);
        HeldOut {
            rms_m: self.spreads.map(|s| s.deviation()),
            whitened_rms: sqrt(self.squares / count),
        }
    }
}
