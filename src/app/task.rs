//! The session that runs or ran last. Both kinds share one memory: never are both needed.

use crate::calibration::joint::{JointConfig, JointSession, StepReport};
use crate::calibration::{
    Action, MotionEvent, Progress, Session, SessionConfig, Stage, StartError,
};
use crate::frame::Frame;

/// One of the sessions, or none yet. To live in a static: the joint session's poses and triangle are 57 KiB.
#[derive(Debug, Default)]
#[repr(u8)]
// none is zero, so that a static of it lies in .bss and not in flash
// The largest is what the memory is for.
#[allow(clippy::large_enum_variant)]
pub enum Task {
    /// None since start-up.
    #[default]
    Idle,
    /// The platen sensor's calibration.
    Platen(Session),
    /// The joint calibration under a beacon.
    Joint(JointSession),
}

impl Task {
    /// Starts a calibration of the platen sensor. Another kind of session that ran before is forgotten.
    ///
    /// # Errors
    /// [`StartError`]; no session runs then.
    pub fn start(&mut self, config: SessionConfig) -> Result<(), StartError> {
        config.validate()?;
        if !matches!(self, Self::Platen(_)) {
            self.make_platen();
        }
        match self {
            Self::Platen(session) => session.start(config),
            _ => Err(StartError::Busy),
        }
    }

    /// Starts a joint calibration. Another kind of session that ran before is forgotten.
    ///
    /// # Errors
    /// [`StartError`]; no session runs then.
    pub fn start_joint(&mut self, config: JointConfig) -> Result<(), StartError> {
        config.validate()?;
        if !matches!(self, Self::Joint(_)) {
            self.make_joint();
        }
        match self {
            Self::Joint(session) => session.start(config),
            _ => Err(StartError::Busy),
        }
    }

    // Functions of their own, so that the new session is made in its place: inlined, it is made on the stack first.
    // `cargo xtask firmware` states the stack and fails where this does not hold.
    #[inline(never)]
    fn make_platen(&mut self) {
        *self = Self::Platen(Session::idle());
    }

    #[inline(never)]
    fn make_joint(&mut self) {
        *self = Self::Joint(JointSession::idle());
    }

    /// Takes a frame.
    pub fn frame(&mut self, frame: &Frame) {
        match self {
            Self::Idle => {}
            Self::Platen(session) => session.frame(frame),
            Self::Joint(session) => session.frame(frame),
        }
    }

    /// Takes what the motion controller said.
    pub fn motion(&mut self, event: MotionEvent) {
        match self {
            Self::Idle => {}
            Self::Platen(session) => session.motion(event),
            Self::Joint(session) => session.motion(event),
        }
    }

    /// What is to be done now, once.
    pub fn poll(&mut self) -> Option<Action> {
        match self {
            Self::Idle => None,
            Self::Platen(session) => session.poll(),
            Self::Joint(session) => session.poll(),
        }
    }

    /// Makes a step of the joint schedule if one is due.
    pub fn work(&mut self, breathe: &mut dyn FnMut()) {
        if let Self::Joint(session) = self {
            session.work(breathe);
        }
    }

    /// Ends it.
    pub fn abort(&mut self) {
        match self {
            Self::Idle => {}
            Self::Platen(session) => session.abort(),
            Self::Joint(session) => session.abort(),
        }
    }

    /// Whether a session is under way.
    pub fn is_running(&self) -> bool {
        match self {
            Self::Idle => false,
            Self::Platen(session) => session.is_running(),
            Self::Joint(session) => session.is_running(),
        }
    }

    /// How far it is.
    pub fn progress(&self) -> Progress {
        match self {
            Self::Idle => Progress {
                stage: Stage::Finished,
                done: 0,
                of: 0,
                lost: 0,
                worst_deviation_m: f32::INFINITY,
            },
            Self::Platen(session) => session.progress(),
            Self::Joint(session) => session.progress(),
        }
    }

    /// Steps that a joint calibration has made so far.
    pub fn reports(&self) -> &[StepReport] {
        match self {
            Self::Joint(session) => session.reports(),
            _ => &[],
        }
    }
}
