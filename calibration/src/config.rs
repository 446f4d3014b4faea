//! What a session is told, and its check.

use super::outcome::AcceptanceLimits;
use super::plan::{Plan, Range};
use super::visits::Visits;
use crate::geometry::Geometry;
use crate::model::{ErrorModel, TermTable};
use crate::range::{OutOfRange, within};

/// What a session is to do.
#[derive(Clone, Debug, PartialEq)]
pub struct SessionConfig {
    /// Nominal geometry.
    pub geometry: Geometry,
    /// Calibration in force, or the terms to fit with zeros; what the parity cannot tell is kept from it.
    pub model: ErrorModel,
    /// Where it goes.
    pub visits: Visits,
    /// Fitting ends when the largest predicted deviation of a correction is below this, metres; 0: use all poses.
    pub target_deviation_m: f32,
    /// What the result must meet.
    pub limits: AcceptanceLimits,
}

impl Default for SessionConfig {
    /// The paper's 3.1.2: 1000 poses over ten pitches and ±0.5°.
    #[inline(never)] // as for the joint calibration's
    fn default() -> Self {
        let geometry = Geometry::PAPER;
        Self {
            geometry,
            model: ErrorModel::zero(TermTable::equation_3()),
            visits: Visits::paper(Range {
                travel_m: 10.0 * geometry.pitch_m,
                turn_rad: 8.726_646e-3,
            }),
            target_deviation_m: 0.0,
            limits: AcceptanceLimits::default(),
        }
    }
}

impl SessionConfig {
    /// The defaults for a plan. `Optimal` turns three times as far, as the paper's 3.2.1 does, and needs a third of the poses.
    #[must_use]
    pub fn of_plan(plan: Plan) -> Self {
        let mut config = Self::default();
        if plan == Plan::Optimal {
            config.visits.plan = plan;
            config.visits.poses /= 3;
            config.visits.range.turn_rad *= 3.0;
        }
        config
    }

    /// Checks every number.
    ///
    /// # Errors
    /// The first that is out of range.
    pub fn validate(&self) -> Result<(), OutOfRange> {
        let g = &self.geometry;
        within("pitch_m", g.pitch_m, 1.0e-5, 0.1)?;
        within("span_m", g.span_m, 1.0e-4, 1.0)?;
        let visits = &self.visits;
        within("poses", visits.poses as f32, 1.0, 1.0e6)?;
        within("held_out_poses", visits.held_out_poses as f32, 8.0, 1.0e6)?;
        within("travel_m", visits.range.travel_m, g.pitch_m, 10.0)?;
        within("turn_rad", visits.range.turn_rad, 0.0, 0.1)?;
        visits.validate()?;
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
