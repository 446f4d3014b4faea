//! The session that runs or ran last. Both kinds share one memory: never are both needed.

#[cfg(target_os = "none")]
use crate::board::room;
use crate::calibration::Service;
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
    Idle = 0,
    /// The platen sensor's calibration.
    Platen(Session) = 1,
    /// The joint calibration under a beacon.
    Joint(JointSession) = 2,
    /// No session: the watch over the calibration in force, and its recalibration.
    Watch(Service) = 3,
}

/// How a session comes into its memory where the stack is large; `board::room` does it in place.
#[cfg(not(target_os = "none"))]
mod room {
    use super::{JointSession, Service, Session, Task};

    pub fn platen(task: &mut Task) {
        *task = Task::Platen(Session::idle());
    }

    pub fn joint(task: &mut Task) {
        *task = Task::Joint(JointSession::idle());
    }

    pub fn watch(task: &mut Task) {
        *task = Task::Watch(Service::new());
    }
}

impl Task {
    /// Tag of [`Task::Platen`].
    #[cfg(target_os = "none")]
    pub(crate) const PLATEN: u8 = 1;
    /// Tag of [`Task::Joint`].
    #[cfg(target_os = "none")]
    pub(crate) const JOINT: u8 = 2;
    /// Tag of [`Task::Watch`].
    #[cfg(target_os = "none")]
    pub(crate) const WATCH: u8 = 3;

    /// Makes room for a calibration of the platen sensor. Another kind of session that ran before is forgotten.
    pub fn make_platen(&mut self) {
        if !matches!(self, Self::Platen(_)) {
            self.new_platen();
        }
    }

    /// Makes room for a joint calibration. Another kind of session that ran before is forgotten.
    pub fn make_joint(&mut self) {
        if !matches!(self, Self::Joint(_)) {
            self.new_joint();
        }
    }

    fn new_platen(&mut self) {
        room::platen(self);
        if let Self::Platen(session) = self {
            session.make_idle();
        }
    }

    fn new_joint(&mut self) {
        room::joint(self);
        if let Self::Joint(session) = self {
            session.make_idle();
        }
    }

    /// What runs between calibrations. What a session that has ended left is forgotten; to be called while none runs.
    pub fn service(&mut self) -> Option<&mut Service> {
        if self.is_running() {
            return None;
        }
        if !matches!(self, Self::Watch(_)) {
            room::watch(self);
        }
        match self {
            Self::Watch(service) => Some(service),
            _ => None,
        }
    }

    /// What runs between calibrations, if it does.
    #[must_use]
    pub fn running_service(&self) -> Option<&Service> {
        match self {
            Self::Watch(service) => Some(service),
            _ => None,
        }
    }

    /// Lets it begin anew.
    pub fn forget_service(&mut self) {
        if let Self::Watch(service) = self {
            service.forget();
        }
    }

    /// Starts a calibration of the platen sensor, for which there must be room.
    ///
    /// # Errors
    /// [`StartError`]; no session runs then.
    #[inline(never)]
    pub fn start(&mut self, config: &SessionConfig) -> Result<(), StartError> {
        match self {
            Self::Platen(session) => session.start(config),
            _ => Err(StartError::Busy),
        }
    }

    /// Starts a joint calibration, for which there must be room.
    ///
    /// # Errors
    /// [`StartError`]; no session runs then.
    #[inline(never)]
    pub fn start_joint(&mut self, config: &mut JointConfig) -> Result<(), StartError> {
        match self {
            Self::Joint(session) => session.start(config),
            _ => Err(StartError::Busy),
        }
    }

    /// Whether there is an outcome.
    pub fn has_ended(&self) -> bool {
        match self {
            Self::Idle | Self::Watch(_) => false,
            Self::Platen(session) => session.outcome().is_some(),
            Self::Joint(session) => session.outcome().is_some(),
        }
    }

    /// Takes a frame.
    #[inline(never)]
    pub fn frame(&mut self, frame: &Frame) {
        match self {
            Self::Idle | Self::Watch(_) => {}
            Self::Platen(session) => session.frame(frame),
            Self::Joint(session) => session.frame(frame),
        }
    }

    /// Whether the session has use for every frame: it rests at a pose or averages there. Otherwise frames are its clock alone, and one that
    /// is skipped counts by the next one's number.
    pub fn wants_all_frames(&self) -> bool {
        match self {
            Self::Idle | Self::Watch(_) => false,
            Self::Platen(session) => session.wants_all_frames(),
            Self::Joint(session) => session.wants_all_frames(),
        }
    }

    /// Takes what the motion controller said.
    pub fn motion(&mut self, event: MotionEvent) {
        match self {
            Self::Idle | Self::Watch(_) => {}
            Self::Platen(session) => session.motion(event),
            Self::Joint(session) => session.motion(event),
        }
    }

    /// What is to be done now, once.
    pub fn poll(&mut self) -> Option<Action> {
        match self {
            Self::Idle | Self::Watch(_) => None,
            Self::Platen(session) => session.poll(),
            Self::Joint(session) => session.poll(),
        }
    }

    /// Goes on with the joint schedule's steps, if they are due; false: there is nothing to do.
    #[inline(never)]
    pub fn work(&mut self) -> bool {
        match self {
            Self::Joint(session) => session.work(),
            _ => false,
        }
    }

    /// Ends it.
    pub fn abort(&mut self) {
        match self {
            Self::Idle | Self::Watch(_) => {}
            Self::Platen(session) => session.abort(),
            Self::Joint(session) => session.abort(),
        }
    }

    /// Whether a session is under way.
    pub fn is_running(&self) -> bool {
        match self {
            Self::Idle | Self::Watch(_) => false,
            Self::Platen(session) => session.is_running(),
            Self::Joint(session) => session.is_running(),
        }
    }

    /// How far it is.
    pub fn progress(&self) -> Progress {
        match self {
            Self::Idle | Self::Watch(_) => Progress {
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
