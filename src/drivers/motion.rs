//! The serial line to the courier's motion controller: self-motions are asked for here, and where the courier says that it is.
//!
//! Frames as in [`crate::link::framing`], at most [`FRAME_BYTES`] long. Each request has a number which the reply repeats; a reply to an
//! older request is counted and dropped, so is nonsense. Nothing blocks: what the line does not take now goes out at the next
//! [`MotionPort::poll`]. Time-outs are the caller's: this file knows no time.

use crate::calibration::MotionEvent;
pub use crate::calibration::motion::{FaultCode, Refusal};
use crate::link::framing::{self, Decoder, FrameCounters};
use embedded_io::{ErrorKind, Read, ReadReady, Write, WriteReady};
use serde::{Deserialize, Serialize};

/// Longest frame in either direction: a go-to is 20 bytes of message.
pub const FRAME_BYTES: usize = framing::encoded_bytes(32);
/// Bytes taken from the line at one poll: 64 are 0.6 ms at 1 Mbaud.
const BYTES_A_POLL: usize = 64;

/// A motion goes on only while the controller hears of it: [`Command::GoTo`] or [`Command::GoOn`] at least so often, milliseconds.
/// Otherwise the controller comes to rest by itself and waits for the next command: its board has stopped working, or the line is broken.
/// The board is silent for 50 ms at most while a motion is under way, when it writes its flash, and repeats a lost frame after 10 ms.
pub const HEARTBEAT_LIMIT_MS: u32 = 200;

/// A planar pose as commanded, platen frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Target {
    /// Metres.
    pub x_m: f32,
    /// Metres.
    pub y_m: f32,
    /// Radians, counter-clockwise.
    pub theta_rad: f32,
}

/// What is asked of the motion controller.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Command {
    /// Go to a pose, no faster than the limit (m/s along the way, above 0).
    GoTo {
        /// Where to.
        target: Target,
        /// Highest speed, m/s.
        speed_m_per_s: f32,
    },
    /// Where are you?
    WhereAreYou,
    /// Come to rest where you are.
    Stop,
    /// Go on with the motion, and where are you? The heartbeat: see [`HEARTBEAT_LIMIT_MS`].
    GoOn,
}

/// How far a motion is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Phase {
    /// Under way.
    Moving,
    /// Arrived, still swinging.
    Settling,
    /// At rest.
    Settled,
}

/// What the controller answers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Reply {
    /// Open loop: the pose is where the drives were told to be, not where the courier is.
    State {
        /// Commanded pose at this moment.
        at: Target,
        /// Moving, settling or at rest.
        phase: Phase,
    },
    /// The command was not taken.
    Refused(Refusal),
    /// A fault stands; answers any command.
    Fault(FaultCode),
}

impl From<Reply> for MotionEvent {
    fn from(reply: Reply) -> Self {
        match reply {
            Reply::State {
                phase: Phase::Settled,
                ..
            } => Self::Settled,
            Reply::State { .. } => Self::Underway,
            Reply::Refused(refusal) => Self::Refused(refusal),
            Reply::Fault(fault) => Self::Fault(fault),
        }
    }
}

/// A numbered command on the wire.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Request {
    /// Repeated by the reply.
    pub number: u16,
    /// What to do.
    pub command: Command,
}

/// A numbered reply on the wire.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Response {
    /// The request's.
    pub number: u16,
    /// Its answer.
    pub reply: Reply,
}

/// Why the port cannot do what is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum PortError {
    /// The line itself failed.
    Line(ErrorKind),
    /// The previous command has not left yet.
    Full,
    /// A pose or speed that is not a finite number.
    NotFinite,
}

impl core::fmt::Display for PortError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Line(kind) => write!(f, "motion port: line failed ({kind:?})"),
            Self::Full => write!(f, "motion port: the previous command has not left yet"),
            Self::NotFinite => write!(f, "motion port: pose or speed is not a finite number"),
        }
    }
}

impl core::error::Error for PortError {}

/// What the line has brought so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PortCounters {
    /// Good and bad frames.
    pub frames: FrameCounters,
    /// Replies to another request than the last.
    pub stale: u32,
}

/// Our end of the line.
#[derive(Debug)]
pub struct MotionPort<S> {
    line: S,
    decoder: Decoder<FRAME_BYTES>,
    outgoing: [u8; FRAME_BYTES],
    unsent: core::ops::Range<usize>,
    number: u16,
    awaiting: bool,
    stale: u32,
}

impl<S: Read + ReadReady + Write + WriteReady> MotionPort<S> {
    /// Takes the line; nothing is sent.
    pub const fn new(line: S) -> Self {
        Self {
            line,
            decoder: Decoder::new(),
            outgoing: [0; FRAME_BYTES],
            unsent: 0..0,
            number: 0,
            awaiting: false,
            stale: 0,
        }
    }

    /// Queues a command and sends what the line takes; returns its number. A reply to an earlier one no longer counts.
    ///
    /// # Errors
    /// [`PortError`]; nothing is sent then.
    pub fn send(&mut self, command: Command) -> Result<u16, PortError> {
        if !self.unsent.is_empty() {
            return Err(PortError::Full);
        }
        if !is_finite(&command) {
            return Err(PortError::NotFinite);
        }
        let number = self.number.wrapping_add(1);
        let bytes = framing::encode(&Request { number, command }, &mut self.outgoing)
            .map_err(|_| PortError::Full)?;
        self.unsent = 0..bytes.len();
        self.number = number;
        self.awaiting = true;
        self.flush()?;
        Ok(number)
    }

    /// Whether the last command has no reply yet.
    pub const fn is_awaiting(&self) -> bool {
        self.awaiting
    }

    /// Sends what is left, reads at most 64 bytes, and returns the last command's reply when it has come.
    ///
    /// # Errors
    /// [`PortError::Line`].
    pub fn poll(&mut self) -> Result<Option<Reply>, PortError> {
        self.flush()?;
        for _ in 0..BYTES_A_POLL {
            if !self.line.read_ready().map_err(line)? {
                break;
            }
            let mut byte = [0];
            if self.line.read(&mut byte).map_err(line)? == 0 {
                break;
            }
            if let Some(Ok(response)) = self.decoder.feed::<Response>(byte[0])
                && let Some(reply) = self.accept(response)
            {
                return Ok(Some(reply));
            }
        }
        Ok(None)
    }

    /// What the line has brought so far.
    pub const fn counters(&self) -> PortCounters {
        PortCounters {
            frames: self.decoder.counters(),
            stale: self.stale,
        }
    }

    fn accept(&mut self, response: Response) -> Option<Reply> {
        if self.awaiting && response.number == self.number && reply_is_finite(&response.reply) {
            self.awaiting = false;
            Some(response.reply)
        } else {
            self.stale = self.stale.saturating_add(1);
            None
        }
    }

    fn flush(&mut self) -> Result<(), PortError> {
        while let Some(bytes) = self
            .outgoing
            .get(self.unsent.clone())
            .filter(|bytes| !bytes.is_empty())
        {
            if !self.line.write_ready().map_err(line)? {
                break;
            }
            let taken = self.line.write(bytes).map_err(line)?;
            if taken == 0 {
                break;
            }
            self.unsent.start = (self.unsent.start + taken).min(self.unsent.end);
        }
        Ok(())
    }
}

fn line(error: impl embedded_io::Error) -> PortError {
    PortError::Line(error.kind())
}

fn target_is_finite(target: &Target) -> bool {
    target.x_m.is_finite() && target.y_m.is_finite() && target.theta_rad.is_finite()
}

fn is_finite(command: &Command) -> bool {
    match command {
        Command::GoTo {
            target,
            speed_m_per_s,
        } => target_is_finite(target) && speed_m_per_s.is_finite(),
        Command::WhereAreYou | Command::Stop | Command::GoOn => true,
    }
}

fn reply_is_finite(reply: &Reply) -> bool {
    match reply {
        Reply::State { at, .. } => target_is_finite(at),
        Reply::Refused(_) | Reply::Fault(_) => true,
    }
}
