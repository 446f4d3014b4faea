//! Self-motions: brings the courier where the session or a host wants it, over a line that may lose or garble frames.
//!
//! A command is repeated until the controller has acknowledged it; then the controller is asked, every [`ASK_SAMPLES`],
//! whether it has settled, and is believed only if it names the pose that was asked for. These questions are the heartbeat without
//! which the controller stops. Time is counted in samples.

use crate::calibration::{MotionEvent, RelativePose};
use crate::drivers::motion::{Command, MotionPort, Phase, PortCounters, PortError, Reply, Target};
use embedded_io::{Read, ReadReady, Write, WriteReady};

/// Samples between two questions, 2 ms at 20 kHz.
pub const ASK_SAMPLES: u32 = 40;
/// Samples after which a reply is given up and the command repeated, 10 ms at 20 kHz.
pub const REPLY_SAMPLES: u32 = 200;
/// A settled pose this close to the goal is the goal: what f32 and a controller's own rounding may do, metres or radians.
const SAME_POSE: f32 = 2.0e-6;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Errand {
    /// Nothing to do.
    Idle,
    /// Find out where the motion starts from, then go.
    Locate { then: RelativePose },
    /// Make the controller take the goal.
    Command { goal: Target },
    /// Wait until it has settled there.
    Settle { goal: Target },
    /// Make it come to rest.
    Halt,
}

/// The motion port with an errand. Owned by the background.
#[derive(Debug)]
pub struct Guide<S> {
    port: MotionPort<S>,
    errand: Errand,
    origin: Option<Target>,
    speed_m_per_s: f32,
    asked_at: Option<u32>,
    bad_frames: u32,
}

impl<S: Read + ReadReady + Write + WriteReady> Guide<S> {
    /// Nothing to do; nothing is sent.
    pub const fn new(port: MotionPort<S>) -> Self {
        Self {
            port,
            errand: Errand::Idle,
            origin: None,
            speed_m_per_s: 0.0,
            asked_at: None,
            bad_frames: 0,
        }
    }

    /// The next relative pose counts from where the courier stands then.
    pub fn forget_origin(&mut self) {
        self.origin = None;
    }

    /// Goes to a pose relative to the origin, no faster than `speed_m_per_s`.
    pub fn go_relative(&mut self, pose: RelativePose, speed_m_per_s: f32) {
        self.speed_m_per_s = speed_m_per_s;
        self.begin(match self.origin {
            Some(origin) => Errand::Command {
                goal: offset(origin, pose),
            },
            None => Errand::Locate { then: pose },
        });
    }

    /// Goes to a pose of the controller's own frame.
    pub fn go_to(&mut self, goal: Target, speed_m_per_s: f32) {
        self.speed_m_per_s = speed_m_per_s;
        self.begin(Errand::Command { goal });
    }

    /// Comes to rest; repeated until acknowledged.
    pub fn halt(&mut self) {
        self.begin(Errand::Halt);
    }

    /// Whether the courier is on its way somewhere. Coming to rest is not: a board without a controller would be at it for ever.
    pub fn is_busy(&self) -> bool {
        !matches!(self.errand, Errand::Idle | Errand::Halt)
    }

    /// What the line has brought so far.
    pub fn counters(&self) -> PortCounters {
        self.port.counters()
    }

    fn begin(&mut self, errand: Errand) {
        self.errand = errand;
        self.asked_at = None;
    }

    /// Moves the errand on; at most 64 bytes each way. `now` is a sample's sequence number. Tells what the controller
    /// said, if it said anything.
    pub fn poll(&mut self, now: u32) -> Option<MotionEvent> {
        let heard = self.port.poll();
        let event = match heard {
            Ok(Some(reply)) => self.hear(reply),
            Ok(None) => self.garbled(),
            Err(_) => Some(MotionEvent::Nonsense),
        };
        self.ask(now);
        event
    }

    /// Frames that meant nothing since the last look.
    fn garbled(&mut self) -> Option<MotionEvent> {
        let bad = self.port.counters().frames.bad();
        let more = bad != self.bad_frames;
        self.bad_frames = bad;
        more.then_some(MotionEvent::Nonsense)
    }

    fn hear(&mut self, reply: Reply) -> Option<MotionEvent> {
        let Reply::State { at, phase } = reply else {
            self.begin(Errand::Idle);
            return Some(reply.into());
        };
        // If nothing has been asked on this errand, the reply is to a question of the one before, which a stop at the start may be.
        self.asked_at?;
        match self.errand {
            Errand::Idle => None,
            Errand::Halt => {
                self.begin(Errand::Idle);
                None
            }
            Errand::Locate { then } => {
                self.origin = Some(at);
                self.begin(Errand::Command {
                    goal: offset(at, then),
                });
                Some(MotionEvent::Underway)
            }
            // The reply to a go-to repeats the pose of this moment: the question that follows tells of the goal.
            Errand::Command { goal } => {
                self.errand = Errand::Settle { goal };
                Some(MotionEvent::Underway)
            }
            Errand::Settle { goal } if phase == Phase::Settled && same(at, goal) => {
                self.begin(Errand::Idle);
                Some(MotionEvent::Settled)
            }
            Errand::Settle { .. } => Some(MotionEvent::Underway),
        }
    }

    fn ask(&mut self, now: u32) {
        let since = self.asked_at.map(|at| now.wrapping_sub(at));
        let due = match (self.errand, since) {
            (Errand::Idle, _) => false,
            (_, None) => true,
            (_, Some(since)) if self.port.is_awaiting() => since >= REPLY_SAMPLES,
            (Errand::Settle { .. }, Some(since)) => since >= ASK_SAMPLES,
            (_, Some(_)) => true,
        };
        if !due {
            return;
        }
        let command = match self.errand {
            Errand::Idle => return,
            Errand::Locate { .. } => Command::WhereAreYou,
            Errand::Settle { .. } => Command::GoOn,
            Errand::Command { goal } => Command::GoTo {
                target: goal,
                speed_m_per_s: self.speed_m_per_s,
            },
            Errand::Halt => Command::Stop,
        };
        match self.port.send(command) {
            Ok(_) => self.asked_at = Some(now),
            // A full line takes it at a later poll; a broken one is the caller's time-out.
            Err(PortError::Full | PortError::Line(_)) => {}
            // A pose that is no number is never sent: the caller's time-out names the pose.
            Err(_) => self.begin(Errand::Idle),
        }
    }
}

/// A pose relative to another in the controller's frame; the axes are the platen's.
fn offset(origin: Target, pose: RelativePose) -> Target {
    Target {
        x_m: origin.x_m + pose.x_m,
        y_m: origin.y_m + pose.y_m,
        theta_rad: origin.theta_rad + pose.theta_rad,
    }
}

fn same(a: Target, b: Target) -> bool {
    let close = |a: f32, b: f32| (a - b).abs() <= SAME_POSE;
    close(a.x_m, b.x_m) && close(a.y_m, b.y_m) && close(a.theta_rad, b.theta_rad)
}
