//! Why a command was not carried out, and what the slots hold: named, with the numbers, and with their text for a host.

use crate::calibration::record::RecordError;
use crate::calibration::slots::{Place, SlotError, SlotInfo, SlotState};
use crate::device::Device;
use crate::maps::MapStoreError;
use crate::maps::mark::MarkRefusal;
use crate::teeth::MapError;
use crate::update::install::UpdateRefusal;
use serde::{Deserialize, Serialize};

/// A number of an order that can be wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
#[allow(missing_docs)] // their texts say it
pub enum Field {
    #[error("number of poses")]
    Poses,
    #[error("number of held-out poses")]
    HeldOutPoses,
    #[error("travel in metres")]
    TravelM,
    #[error("angle in radians")]
    TurnRad,
    #[error("speed in m/s")]
    SpeedMPerS,
    #[error("x in metres")]
    XM,
    #[error("y in metres")]
    YM,
    #[error("theta in radians")]
    ThetaRad,
    #[error("deviation to reach in metres")]
    TargetDeviationM,
    #[error("decimation")]
    Decimation,
    #[error("number of samples")]
    Samples,
    #[error("channels")]
    Channels,
    #[error("slot")]
    Slot,
    #[error("time in seconds since 1970")]
    UnixS,
}

/// What a slot holds, on the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SlotReport {
    /// 0 or 1.
    pub slot: u8,
    /// Number of its record.
    pub sequence: Option<u32>,
    /// What it is.
    pub state: SlotContent,
}

/// State of a slot, on the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
pub enum SlotContent {
    /// The record in force after a restart.
    #[error("in force")]
    InForce,
    /// A valid older record.
    #[error("older")]
    Older,
    /// A record that was rolled back.
    #[error("rolled back")]
    RolledBack,
    /// No usable record.
    #[error("refused: {0}")]
    Refused(RecordRefusal),
}

/// Why a record is not used, on the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
pub enum RecordRefusal {
    /// Erased.
    #[error("empty")]
    Empty,
    /// Cut off or decayed.
    #[error("torn: its writing was cut off, or it decayed")]
    Torn,
    /// Does not read.
    #[error("the flash could not be read")]
    Unreadable,
    /// Of another firmware.
    #[error("layout version {0} is not known to the board's firmware")]
    UnknownVersion(u16),
    /// Numbers or terms that cannot be used.
    #[error("terms, coefficients or other numbers cannot be used")]
    Invalid,
    /// Of another board.
    #[error("it is of another board, {0}")]
    OtherDevice(Device),
    /// Does not fit.
    #[error("the record does not fit its slot")]
    TooLong,
}

impl From<RecordError> for RecordRefusal {
    fn from(error: RecordError) -> Self {
        match error {
            RecordError::Empty => Self::Empty,
            RecordError::Torn => Self::Torn,
            RecordError::Unreadable => Self::Unreadable,
            RecordError::UnknownVersion { version } => Self::UnknownVersion(version),
            RecordError::OtherDevice { device } => Self::OtherDevice(device),
            RecordError::Body | RecordError::Model(_) | RecordError::Range { .. } => Self::Invalid,
            RecordError::TooLong => Self::TooLong,
        }
    }
}

impl From<SlotInfo> for SlotReport {
    fn from(info: SlotInfo) -> Self {
        let state = match info.state {
            SlotState::InForce => SlotContent::InForce,
            SlotState::Older => SlotContent::Older,
            SlotState::RolledBack => SlotContent::RolledBack,
            SlotState::Refused(error) => SlotContent::Refused(error.into()),
        };
        Self {
            slot: info.slot,
            sequence: info.sequence,
            state,
        }
    }
}

/// Why a command was not carried out. What was in force still is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[non_exhaustive]
pub enum Refusal {
    /// No hello of the same protocol version came before.
    #[error("say hello first: the board speaks link protocol {protocol}")]
    NotGreeted {
        /// The board's.
        protocol: u16,
    },
    /// A whole frame that is no command of this protocol version.
    #[error("unknown command")]
    Unknown,
    /// A number outside its range.
    #[error("{field} is {value}, wanted {low} to {high}")]
    Range {
        /// Which.
        field: Field,
        /// What was sent.
        value: f32,
        /// Smallest.
        low: f32,
        /// Largest.
        high: f32,
    },
    /// A calibration is under way.
    #[error("a calibration is under way: abort it first")]
    Busy,
    /// There is nothing to abort.
    #[error("nothing is under way")]
    NothingUnderWay,
    /// There is no calibration in force to read or to store.
    #[error("no calibration is in force")]
    NotCalibrated,
    /// What is in force is stored already.
    #[error("what is in force is already stored in slot {}, number {}", .0.slot, .0.sequence)]
    AlreadyStored(Place),
    /// The calibration sent cannot be used.
    #[error("the calibration cannot be used: {0}")]
    Calibration(RecordRefusal),
    /// The tooth map sent cannot be used.
    #[error("tooth map: {0}")]
    Map(MapError),
    /// The interrupt still has the tooth map: try again.
    #[error("the interrupt has not given the tooth map back yet: try again")]
    MapBusy,
    /// A slot operation failed.
    #[error("slots: {0}")]
    Slots(SlotRefusal),
    /// The interrupt has not taken the last set of coefficients yet: try again.
    #[error("the interrupt has not taken the last coefficients yet: try again")]
    SwapBusy,
    /// The calibration did not start.
    #[error("the calibration did not start: {0}")]
    Start(StartRefusal),
    /// The interrupt has no time for so many rows beyond equations (3) and (9).
    #[error(
        "error model: {found} further terms, wanted at most {most}: the sampling interrupt has no time for more"
    )]
    TooDear {
        /// Rows sent.
        found: u8,
        /// Rows that it has time for.
        most: u8,
    },
    /// Faults in a row.
    #[error("safe mode: it was left alone after faults in a row")]
    SafeMode,
    /// The interrupt has no time for a tooth map beside so many rows beyond equations (3) and (9).
    #[error(
        "tooth map: the error model in force has {found} further terms, wanted at most {most} beside a map: the sampling interrupt has \
         no time for both"
    )]
    MapTooDear {
        /// Rows in force.
        found: u8,
        /// Rows that it has time for beside a map.
        most: u8,
    },
    /// See [`UpdateRefusal`].
    #[error("{0}")]
    Update(UpdateRefusal),
    /// There is no candidate of the recalibration that is proposed.
    #[error("no candidate is proposed")]
    NoCandidate,
    /// There is no room for the setting behind the stored calibration, or the flash does not take it.
    #[error(
        "the setting is not kept: behind the stored calibration there is room for 16 changes, until another one is stored"
    )]
    ModeNotKept,
    /// Storing, reading or forgetting a tooth map failed.
    #[error("{0}")]
    MapStore(#[from] MapStoreError),
    /// A map was not put in force by a mark.
    #[error("{0}")]
    Mark(#[from] MarkRefusal),
}

/// Why a slot operation failed, on the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
#[non_exhaustive]
pub enum SlotRefusal {
    /// Nothing valid is stored.
    #[error("no slot holds a valid calibration")]
    NoneInForce,
    /// 0 and 1 exist.
    #[error("slot {0}: there are 0 and 1")]
    NoSuchSlot(u8),
    /// The record.
    #[error("record: {0}")]
    Record(RecordRefusal),
    /// A later firmware's record is in the way.
    #[error(
        "slot {slot} holds layout version {version} of another firmware: it is overwritten only when told to"
    )]
    WouldLoseUnknown {
        /// Where.
        slot: u8,
        /// Its version.
        version: u16,
    },
    /// Nothing to go back to.
    #[error("no older valid calibration to roll back to")]
    NothingOlder,
    /// The flash does not erase.
    #[error("slot {0} does not erase")]
    Erase(u8),
    /// The flash does not take data.
    #[error("slot {0} does not take data")]
    Write(u8),
    /// The flash does not keep data.
    #[error("slot {0}: what was read back is not what was written")]
    ReadBack(u8),
}

impl From<SlotError> for SlotRefusal {
    fn from(error: SlotError) -> Self {
        match error {
            SlotError::NoneInForce => Self::NoneInForce,
            SlotError::NoSuchSlot { slot } => Self::NoSuchSlot(slot),
            SlotError::Record(error) => Self::Record(error.into()),
            SlotError::WouldLoseUnknown { slot, version } => {
                Self::WouldLoseUnknown { slot, version }
            }
            SlotError::NothingOlder => Self::NothingOlder,
            SlotError::Erase { slot, .. } => Self::Erase(slot),
            SlotError::Write { slot, .. } => Self::Write(slot),
            SlotError::ReadBack { slot } => Self::ReadBack(slot),
        }
    }
}

impl From<SlotError> for Refusal {
    fn from(error: SlotError) -> Self {
        Self::Slots(error.into())
    }
}

/// Why a calibration did not start.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
#[non_exhaustive]
pub enum StartRefusal {
    /// A number of the board's own settings does not allow it.
    #[error("the board's settings do not allow it")]
    Settings,
    /// The error model in force has no term, or more, than a session can fit.
    #[error("the error model in force has terms that this session cannot fit")]
    Terms,
    /// The motion controller does not answer.
    #[error("the motion controller does not answer")]
    NoMotionController,
    /// No beacon is seen.
    #[error("no beacon is seen: a joint calibration needs one")]
    NoBeacon,
}
