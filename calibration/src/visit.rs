//! One visit to a pose: go there, wait until settled, rest, average, and once more where the courier did not stand still.

use super::average::{Average, PoseMean, Unsteady};
use super::outcome::Refusal;
use super::plan::RelativePose;
use super::port::{Action, MotionEvent};
use crate::frame::{Frame, Status};

/// Tries at a pose where the courier does not stand still. A bound on the work: a pose that is given up is told (`session`), and
/// the next one is taken.
const TRIES: u8 = 3;

/// What all visits of a session have in common.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct VisitRules {
    pub frames_per_pose: u32,
    pub frame_noise_m: f32,
    pub pitch_m: f32,
    /// Samples from a command until settled, at most.
    pub settle_limit: u32,
    /// Samples between settled and the first one averaged.
    pub rest: u32,
    /// Bits that make a frame useless.
    pub unusable: Status,
}

/// What a frame led to.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Visited {
    /// Still under way.
    Nothing,
    /// The pose's mean.
    Mean(PoseMean),
    /// The courier did not stand still in any try.
    Unsteady(Unsteady),
    /// Too many unusable frames.
    BadFrames(Refusal),
    /// It never settled.
    NotSettled(Refusal),
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Doing {
    Waiting { waited: u32 },
    Resting { left: u32 },
    Averaging,
}

/// A visit under way.
#[derive(Clone, Debug)]
pub(super) struct Visit {
    average: Average,
    doing: Doing,
    pose: RelativePose,
    number: u32,
    tries: u8,
    last_sequence: Option<u32>,
    bad_frames: u32,
    bad_status: Status,
    answers: u32,
    nonsense: u32,
    action: Option<Action>,
}

impl Visit {
    /// Nowhere to go.
    pub const fn none() -> Self {
        Self {
            average: Average::empty(),
            doing: Doing::Waiting { waited: 0 },
            pose: RelativePose {
                x_m: 0.0,
                y_m: 0.0,
                theta_rad: 0.0,
            },
            number: 0,
            tries: 0,
            last_sequence: None,
            bad_frames: 0,
            bad_status: Status::empty(),
            answers: 0,
            nonsense: 0,
            action: None,
        }
    }

    /// Sets out for a pose; `number` is for refusals.
    pub fn go(&mut self, pose: RelativePose, number: u32) {
        self.pose = pose;
        self.number = number;
        self.tries = 0;
        self.set_out();
    }

    /// Nothing to do, whatever there was.
    pub fn forget(&mut self) {
        self.last_sequence = None;
        self.action = None;
    }

    /// Ends it.
    pub fn stop(&mut self) {
        self.last_sequence = None;
        self.action = Some(Action::Stop);
    }

    /// What is to be done now, once.
    pub fn poll(&mut self) -> Option<Action> {
        self.action.take()
    }

    /// Takes what the motion controller said.
    pub fn motion(&mut self, event: MotionEvent, rules: &VisitRules) -> Option<Refusal> {
        let pose = self.number;
        match event {
            MotionEvent::Settled
                if matches!(self.doing, Doing::Waiting { .. }) && self.action.is_none() =>
            {
                self.doing = Doing::Resting { left: rules.rest };
            }
            MotionEvent::Settled | MotionEvent::Underway => {
                self.answers = self.answers.saturating_add(1)
            }
            MotionEvent::Nonsense => self.nonsense = self.nonsense.saturating_add(1),
            MotionEvent::Fault(fault) => return Some(Refusal::MotionFault { fault, pose }),
            MotionEvent::Refused(refusal) => return Some(Refusal::MotionRefused { refusal, pose }),
        }
        None
    }

    /// Whether every frame is of use: the courier has settled.
    pub fn wants_all_frames(&self) -> bool {
        !matches!(self.doing, Doing::Waiting { .. })
    }

    /// Takes a frame. While [`Visit::wants_all_frames`] says so every one; otherwise they are the clock, and some may be left out.
    pub fn frame(&mut self, frame: &Frame, rules: &VisitRules) -> Visited {
        let passed = self
            .last_sequence
            .map_or(1, |last| frame.sequence.wrapping_sub(last));
        self.last_sequence = Some(frame.sequence);
        match self.doing {
            Doing::Waiting { waited } => {
                self.wait(waited.saturating_add(passed), rules.settle_limit)
            }
            Doing::Resting { left } if left > 0 => {
                self.doing = Doing::Resting {
                    left: left.saturating_sub(passed),
                };
                Visited::Nothing
            }
            Doing::Resting { .. } | Doing::Averaging => {
                self.doing = Doing::Averaging;
                self.take(frame, rules)
            }
        }
    }

    fn wait(&mut self, waited: u32, limit: u32) -> Visited {
        self.doing = Doing::Waiting { waited };
        if waited <= limit {
            return Visited::Nothing;
        }
        let (pose, answers, nonsense) = (self.number, self.answers, self.nonsense);
        Visited::NotSettled(Refusal::NotSettled {
            pose,
            waited,
            limit,
            answers,
            nonsense,
        })
    }

    fn take(&mut self, frame: &Frame, rules: &VisitRules) -> Visited {
        let limit = rules.frames_per_pose;
        if frame.status.intersects(rules.unusable) {
            self.bad_frames += 1;
            self.bad_status |= frame.status & rules.unusable;
            let (pose, status, bad) = (self.number, self.bad_status, self.bad_frames);
            if bad > limit {
                return Visited::BadFrames(Refusal::BadFrames {
                    pose,
                    status,
                    bad,
                    limit,
                });
            }
            return Visited::Nothing;
        }
        self.average.add(frame);
        if self.average.count() < limit as usize {
            return Visited::Nothing;
        }
        match self.average.finish(rules.pitch_m, rules.frame_noise_m) {
            Ok(mean) => Visited::Mean(mean),
            Err(unsteady) => self.try_again(unsteady),
        }
    }

    fn try_again(&mut self, unsteady: Unsteady) -> Visited {
        self.tries += 1;
        if self.tries >= TRIES {
            return Visited::Unsteady(unsteady);
        }
        self.set_out();
        Visited::Nothing
    }

    fn set_out(&mut self) {
        self.average.clear();
        (self.bad_frames, self.bad_status) = (0, Status::empty());
        (self.answers, self.nonsense) = (0, 0);
        self.doing = Doing::Waiting { waited: 0 };
        self.action = Some(Action::Go(self.pose));
    }
}
