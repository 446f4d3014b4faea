//! What passes between a session and its caller.

use super::plan::RelativePose;
use crate::motion;

/// What the motion controller said.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MotionEvent {
    /// At rest where it was told to be.
    Settled,
    /// Anything else of no consequence.
    Underway,
    /// A fault.
    Fault(motion::FaultCode),
    /// The pose is refused.
    Refused(motion::Refusal),
    /// A frame that means nothing.
    Nonsense,
}

/// What the session wants done next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Action {
    /// Go to a pose relative to where the courier stood when the session started; then tell when settled.
    Go(RelativePose),
    /// Come to rest.
    Stop,
}

/// What the session is at: what its present pose is for, or what comes after all poses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Stage {
    /// The first pose, which the others are relative to.
    #[default]
    Origin,
    /// Poses that are fitted.
    Fit,
    /// Poses that decide.
    HeldOut,
    /// Nothing more to do.
    Finished,
    /// The joint schedule's steps.
    Solving,
}

/// How far a session is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Progress {
    /// What it is at.
    pub stage: Stage,
    /// Poses, or steps of the joint schedule, done in this stage.
    pub done: u32,
    /// How many there are.
    pub of: u32,
    /// Poses lost so far.
    pub lost: u32,
    /// Largest predicted deviation of a correction, metres; infinite at first.
    pub worst_deviation_m: f32,
}
