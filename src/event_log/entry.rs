//! One entry of the log: when, and what.
//!
//! ```text
//!  byte 0     1 ...                                                              ...
//!  | layout | number, start, uptime, time of day: postcard | event: postcard       |
//! ```
//! The head keeps its layout in every version, so that numbers go on over an update and back; an event is read only by a program that
//! knows its [`LAYOUT`].

use crate::calibration::Refusal as SessionRefusal;
use crate::calibration::recalibration::Proposal;
use crate::calibration::record::{Instant, Method};
use crate::calibration::rest_watch::RestChange;
use crate::calibration::slots::Place;
use crate::calibration::watch::{Change, Standing};
use crate::frame::Coordinate;
use crate::link::message::{InForce, Refusal, ResetCause};
use crate::update::version::Version;
use heapless::String;
use serde::{Deserialize, Serialize};

/// Version of [`Event`], with all that it holds. A change of any type in it is a new layout: `tests/suite/event_log/layout.rs` holds the
/// bytes of every kind.
pub const LAYOUT: u8 = 1;
/// Longest entry, bytes: a start after a panic with all its text takes 104.
pub const ENTRY_BYTES: usize = 128;
/// Bytes of a panic's text that are kept: its place is what comes first.
pub const MESSAGE_BYTES: usize = 56;

/// When an entry was written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Head {
    /// Counts entries, from 1. A gap is of entries that were overwritten or damaged.
    pub number: u32,
    /// Counts starts of the board of which anything was written, from 1.
    pub start: u32,
    /// By the board's own clock, seconds since that start; and the time of day, if a host had told it.
    pub time: Instant,
}

/// What happened.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Event {
    /// The board started.
    Started {
        /// Why.
        cause: ResetCause,
        /// Starts in a row that a fault caused.
        faults_in_a_row: u8,
        /// The firmware that runs.
        firmware: Version,
        /// The calibration in force since then, as far as one was stored.
        in_force: InForce,
        /// Why none came in force; none for a board that has none stored.
        boot: Option<Refusal>,
        /// The fault that ended the start before.
        fault: Option<Fault>,
    },
    /// Status bits that had not been seen since the start.
    Status(u32),
    /// A calibration was begun.
    CalibrationBegun(Method),
    /// It ended.
    CalibrationEnded {
        /// How.
        ending: Ending,
        /// Held-out residual by the calibration before and by its own, metres.
        held_out_m: [f32; 2],
    },
    /// Another calibration is in force, or none.
    InForce {
        /// Which.
        now: InForce,
        /// The one before was newer and was rolled back.
        rolled_back: bool,
    },
    /// A stored tooth map came in force, or could not.
    Map(MapEvent),
    /// The calibration in force stands otherwise than before.
    Watch {
        /// How.
        standing: Standing,
        /// What has changed.
        change: Option<Change>,
    },
    /// A new firmware was taken in; the next start tries it.
    ImageTaken(Version),
    /// The firmware that runs was accepted.
    ImageAccepted(Version),
    /// The recalibration while working proposes a candidate.
    Proposed(Proposal),
    /// A candidate came in force.
    Recalibrated(InForce),
    /// The beacon's part of the calibration in force stands otherwise than before.
    BeaconWatch {
        /// How.
        standing: Standing,
        /// What has changed.
        change: Option<RestChange>,
    },
    /// The parity g_p at rests stands otherwise than before.
    ParityWatch {
        /// How.
        standing: Standing,
        /// What has changed.
        change: Option<RestChange>,
    },
}

/// A fault as it was kept over the reset.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Fault {
    /// Seconds since the start before.
    pub uptime_s: u32,
    /// Address of the instruction; 0 if not known.
    pub program_counter: u32,
    /// Where it would have returned to; 0 if not known.
    pub link_register: u32,
    /// The beginning of a panic's place and text.
    pub message: String<MESSAGE_BYTES>,
}

/// How a calibration ended.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Ending {
    /// Accepted; stored if that was ordered.
    Accepted(Option<Place>),
    /// Accepted, but it could not be put in force or stored.
    NotKept,
    /// The one before is in force.
    Refused(SessionRefusal),
}

/// What became of a stored tooth map.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum MapEvent {
    /// In force.
    InForce {
        /// The map.
        slot: u8,
    },
    /// The beacon or the mark is not a whole number of teeth from where the map has it.
    NotWhole {
        /// The map that comes nearest.
        slot: u8,
        /// What the board counts ahead of the map.
        ahead: [Coordinate; 2],
    },
    /// It did not fit the platen.
    OtherPlaten {
        /// The map.
        slot: u8,
        /// g_p over the cells that were passed, and at most that was wanted, metres rms.
        parity_m: [f32; 2],
    },
    /// It belongs to another calibration than the one in force.
    OtherCalibration {
        /// The map.
        slot: u8,
    },
    /// It cannot be used.
    Refused {
        /// The map.
        slot: u8,
        /// Why.
        refusal: Refusal,
    },
}

impl MapEvent {
    /// The map's slot.
    #[must_use]
    pub const fn slot(&self) -> u8 {
        match self {
            Self::InForce { slot }
            | Self::NotWhole { slot, .. }
            | Self::OtherPlaten { slot, .. }
            | Self::OtherCalibration { slot }
            | Self::Refused { slot, .. } => *slot,
        }
    }
}

/// An entry as it is read: of another layout only the head.
#[derive(Clone, Debug, PartialEq)]
pub enum Read {
    /// Of this layout.
    Known(Head, Event),
    /// Of another one.
    Other {
        /// When.
        head: Head,
        /// Its layout.
        layout: u8,
    },
}

impl Read {
    /// When it was written.
    #[must_use]
    pub fn head(&self) -> &Head {
        match self {
            Self::Known(head, _) | Self::Other { head, .. } => head,
        }
    }
}

/// An entry's bytes; none if they were too many.
#[must_use]
pub fn encode<'b>(
    head: &Head,
    event: &Event,
    buffer: &'b mut [u8; ENTRY_BYTES],
) -> Option<&'b [u8]> {
    let (first, rest) = buffer.split_first_mut()?;
    *first = LAYOUT;
    // By the serializer of the link, whose code for these types is there.
    let used = crate::sink::write(&(head, event), rest)?.len();
    buffer.get(..=used)
}

/// The head of an entry, whatever its layout.
#[must_use]
pub fn head(bytes: &[u8]) -> Option<Head> {
    let (_, rest) = bytes.split_first()?;
    postcard::take_from_bytes(rest).ok().map(|(head, _)| head)
}

/// Reads an entry; none if it is none.
#[must_use]
pub fn decode(bytes: &[u8]) -> Option<Read> {
    let (layout, rest) = bytes.split_first()?;
    let (head, rest) = postcard::take_from_bytes::<Head>(rest).ok()?;
    if *layout != LAYOUT {
        let layout = *layout;
        return Some(Read::Other { head, layout });
    }
    let event = postcard::from_bytes(rest).ok()?;
    Some(Read::Known(head, event))
}
