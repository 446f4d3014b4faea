//! Which poses a session visits and how it stands at each: what both sensors' sessions are told alike.

use super::average::FRAMES;
use super::plan::{Plan, Range};
use super::visit::VisitRules;
use crate::frame::Status;
use crate::range::{OutOfRange, within};

/// Poses of a session, and the stay at each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Visits {
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
    /// Upper bound of one frame's noise of a segment, metres: what the standstill is judged by.
    pub frame_noise_m: f32,
    /// Samples from a command until settled, at most.
    pub settle_limit: u32,
    /// Samples between settled and the first one averaged.
    pub rest: u32,
}

impl Visits {
    /// The paper's number of poses within a range.
    #[must_use]
    pub const fn paper(range: Range) -> Self {
        Self {
            poses: 1000,
            held_out_poses: 200,
            plan: Plan::Random,
            seed: 1,
            range,
            frames_per_pose: 16,
            frame_noise_m: 1.0e-6,
            settle_limit: 40_000,
            rest: 20,
        }
    }

    /// All poses.
    #[must_use]
    pub const fn total(&self) -> u32 {
        self.poses.saturating_add(self.held_out_poses)
    }

    /// Checks what does not depend on the sensors; how many poses and how far is each session's own.
    ///
    /// # Errors
    /// The first that is out of range.
    pub(super) fn validate(&self) -> Result<(), OutOfRange> {
        let frames = self.frames_per_pose as f32;
        within("frames_per_pose", frames, 2.0, FRAMES as f32)?;
        within("frame_noise_m", self.frame_noise_m, 1.0e-10, 1.0e-4)?;
        within("settle_limit", self.settle_limit as f32, 1.0, 1.0e9)?;
        within("rest", self.rest as f32, 0.0, 1.0e9)
    }

    /// What every visit goes by; frames with a bit of `unusable` are none.
    pub(super) fn rules(&self, pitch_m: f32, unusable: Status) -> VisitRules {
        VisitRules {
            frames_per_pose: self.frames_per_pose,
            frame_noise_m: self.frame_noise_m,
            pitch_m,
            settle_limit: self.settle_limit,
            rest: self.rest,
            unusable,
        }
    }
}
