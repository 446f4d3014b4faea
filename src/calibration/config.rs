//! What a session is told, and its check.

use super::average::FRAMES;
use super::outcome::AcceptanceLimits;
use super::plan::{Plan, Range};
use crate::geometry::Geometry;
use crate::model::{ErrorModel, TermTable};

/// What a session is to do.
#[derive(Clone, Debug, PartialEq)]
pub struct SessionConfig {
    /// Nominal geometry.
    pub geometry: Geometry,
    /// Calibration in force, or the terms to fit with zeros; what the parity cannot tell is kept from it.
    pub model: ErrorModel,
    /// Poses to fit, at most.
    pub poses: u32,
    /// Poses held out.
    pub held_out_poses: u32,
    /// How poses are chosen.
    pub plan: Plan,
    /// Of the pose generator.
    pub seed: u64,
    /// Where poses are drawn from.
    pub range: Range,
    /// Frames averaged at a pose, 2 to 32.
    pub frames_per_pose: u32,
    /// Upper bound of one frame's noise, metres: what the standstill is judged by.
    pub frame_noise_m: f32,
    /// Samples from a command until settled, at most.
    pub settle_limit: u32,
    /// Samples between settled and the first one averaged.
    pub rest: u32,
    /// Fitting ends when the largest predicted deviation of a correction is below this, metres; 0: use all poses.
    pub target_deviation_m: f32,
    /// What the result must meet.
    pub limits: AcceptanceLimits,
}

impl Default for SessionConfig {
    /// The paper's 3.1.2: 1000 poses over ten pitches and ±0.5°.
    fn default() -> Self {
        let geometry = Geometry::PAPER;
        Self {
            geometry,
            model: ErrorModel::zero(TermTable::equation_3()),
            poses: 1000,
            held_out_poses: 200,
            plan: Plan::Random,
            seed: 1,
            range: Range {
                travel_m: 10.0 * geometry.pitch_m,
                turn_rad: 8.726_646e-3,
            },
            frames_per_pose: 16,
            frame_noise_m: 1.0e-6,
            settle_limit: 40_000,
            rest: 20,
            target_deviation_m: 0.0,
            limits: AcceptanceLimits::default(),
        }
    }
}

/// Why a session does not start.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StartError {
    /// A number is outside its range, or not one.
    #[error("{name} is {value}, wanted {low} to {high}")]
    Range {
        /// Which.
        name: &'static str,
        /// Its value.
        value: f32,
        /// Smallest.
        low: f32,
        /// Largest.
        high: f32,
    },
    /// The model has no term that the parity can give, or more than six.
    #[error("the model must have 1 to 6 terms of the own phase alone")]
    Terms,
    /// A session is under way.
    #[error("a session is under way")]
    Busy,
}

impl SessionConfig {
    /// The defaults for a plan. `Optimal` turns three times as far, as the paper's 3.2.1 does, and needs a third of the poses.
    #[must_use]
    pub fn of_plan(plan: Plan) -> Self {
        let default = Self::default();
        match plan {
            Plan::Random => default,
            Plan::Optimal => Self {
                plan,
                poses: default.poses / 3,
                range: Range {
                    turn_rad: 3.0 * default.range.turn_rad,
                    ..default.range
                },
                ..default
            },
        }
    }

    /// Checks every number.
    ///
    /// # Errors
    /// The first that is out of range.
    pub fn validate(&self) -> Result<(), StartError> {
        let g = &self.geometry;
        within("pitch_m", g.pitch_m, 1.0e-5, 0.1)?;
        within("span_m", g.span_m, 1.0e-4, 1.0)?;
        within("poses", self.poses as f32, 1.0, 1.0e6)?;
        within("held_out_poses", self.held_out_poses as f32, 8.0, 1.0e6)?;
        within("travel_m", self.range.travel_m, g.pitch_m, 10.0)?;
        within("turn_rad", self.range.turn_rad, 0.0, 0.1)?;
        within(
            "frames_per_pose",
            self.frames_per_pose as f32,
            2.0,
            FRAMES as f32,
        )?;
        within("frame_noise_m", self.frame_noise_m, 1.0e-10, 1.0e-4)?;
        within("settle_limit", self.settle_limit as f32, 1.0, 1.0e9)?;
        within("rest", self.rest as f32, 0.0, 1.0e9)?;
        within("target_deviation_m", self.target_deviation_m, 0.0, 1.0)?;
        within("limits.condition", self.limits.condition, 1.0, 1.0e6)?;
        within("limits.lost_share", self.limits.lost_share, 0.0, 1.0)?;
        within(
            "limits.held_out_ratio",
            self.limits.held_out_ratio,
            0.0,
            1.0,
        )
    }
}

/// Not a number fails as well.
#[inline(never)]
pub(super) fn within(
    name: &'static str,
    value: f32,
    low: f32,
    high: f32,
) -> Result<(), StartError> {
    if (low..=high).contains(&value) {
        Ok(())
    } else {
        Err(StartError::Range {
            name,
            value,
            low,
            high,
        })
    }
}
