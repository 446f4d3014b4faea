//! Commands and replies of the debug link, protocol version [`PROTOCOL`].
//!
//! Three channels: log (defmt), telemetry ([`super::telemetry`]), and this pair. Every request has a number that its response repeats.
//! [`Command::Hello`] and [`Reply::Hello`] keep their layout in every version, so that both sides can always tell who is the newer.
//! A new command or field is a new protocol version.

use crate::calibration::Plan;
use crate::calibration::record::{self, Calibration, Instant, RecordError};
use crate::calibration::slots::{Place, SlotError, SlotInfo, SlotState};
use crate::drivers::motion::Target;
use crate::frame::{Pose, SEGMENTS};
use crate::link::framing::{self, FrameCounters};
use crate::link::report::Progress;
use crate::link::telemetry::StreamOrder;
use heapless::String;
use serde::{Deserialize, Serialize};

/// Version of this file's types.
pub const PROTOCOL: u16 = 1;
/// Longest frame of the command and reply channel: a whole calibration fits it.
pub const FRAME_BYTES: usize = framing::encoded_bytes(record::MAX_BYTES);
/// Channel numbers, in both directions of the target's memory: 0 up is the log.
pub const TELEMETRY_CHANNEL: usize = 1;
/// Replies up, commands down: channel 2 up and 0 down.
pub const REPLY_CHANNEL: usize = 2;
/// See [`REPLY_CHANNEL`].
pub const COMMAND_CHANNEL: usize = 0;

/// A numbered command.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Request {
    /// Repeated by the response; from 1.
    pub number: u16,
    /// What to do.
    pub command: Command,
}

/// A numbered reply.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Response {
    /// The request's; 0 for a frame that was no known request.
    pub number: u16,
    /// Its answer.
    pub reply: Reply,
}

/// What a host can say.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Command {
    /// First of all; answered by [`Reply::Hello`] whatever the versions. Same layout in every version.
    Hello {
        /// The host's [`PROTOCOL`].
        protocol: u16,
    },
    /// Anything else: only after a hello of the same version.
    Do(Action),
}

/// What the board can be asked to do; checked by [`Action::validate`] before it reaches the background.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
// One action exists at a time, on the background's stack; a box needs an allocator.
#[allow(clippy::large_enum_variant)]
pub enum Action {
    /// How are you? [`Reply::Status`].
    Status,
    /// Start a self-calibration. [`Reply::Done`] once it is under way, then [`Action::Progress`].
    Calibrate(CalibrateOrder),
    /// End it without a result.
    Abort,
    /// How far is it, or how did the last one end? [`Reply::Progress`].
    Progress,
    /// Move the courier, while no calibration does. [`Reply::Done`] once it is ordered; [`BoardStatus::moving`] tells when it is there.
    GoTo {
        /// Where to, in the motion controller's frame.
        target: Target,
        /// Highest speed, m/s, 0.001 to 1.5.
        speed_m_per_s: f32,
    },
    /// Coefficients, terms and geometry. [`Reply::Calibration`].
    Read(Source),
    /// Put these coefficients, terms and geometry in force; not stored until [`Action::Commit`].
    Load(Calibration),
    /// Store what is in force. [`Reply::Place`].
    Commit {
        /// Whether a later firmware's record may be overwritten.
        lose_unknown: bool,
    },
    /// Go back to the stored calibration before. [`Reply::Place`].
    RollBack,
    /// What the slots hold. [`Reply::Slots`].
    Slots,
    /// Start, change or end telemetry.
    Stream(StreamOrder),
    /// Raw counts of every sample from now on, for so many samples; they come as telemetry.
    Record {
        /// 1 or more.
        samples: u32,
    },
    /// Set the board's date.
    SetTime {
        /// Seconds since 1970 UTC.
        unix_s: u64,
    },
    /// Why did the board restart last? [`Reply::LastFault`].
    LastFault,
    /// Restart the board. [`Reply::Done`] is sent before.
    Restart,
}

/// Which calibration to read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Source {
    /// The one in force.
    InForce,
    /// One that is stored, 0 or 1.
    Slot(u8),
}

/// A self-calibration as ordered. [`CalibrateOrder::default`] is the paper's: 1000 random poses over ten pitches and ±0.5°.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CalibrateOrder {
    /// Platen sensor alone or jointly with the coordination sensor.
    pub method: record::Method,
    /// How poses are chosen.
    pub plan: Plan,
    /// Poses to fit at most, 50 to 10,000 (jointly: to 1000, what the buffer holds).
    pub poses: u16,
    /// Poses held out for the test, 8 to 1000.
    pub held_out_poses: u16,
    /// Random poses are drawn from this seed.
    pub seed: u64,
    /// Poses lie within so much of the start, metres, above 0 to 0.5.
    pub travel_m: f32,
    /// Largest angle, radians, above 0 to 0.06.
    pub turn_rad: f32,
    /// Highest speed between poses, m/s, above 0 to 1.5.
    pub speed_m_per_s: f32,
    /// Stop early when the worst predicted position deviation is below this, metres; 0: use all poses.
    pub target_deviation_m: f32,
    /// Store the result when it is accepted.
    pub commit: bool,
}

impl Default for CalibrateOrder {
    fn default() -> Self {
        Self {
            method: record::Method::Platen,
            plan: Plan::Random,
            poses: 1000,
            held_out_poses: 200,
            seed: 1,
            travel_m: 10.16e-3,
            turn_rad: 8.727e-3,
            speed_m_per_s: 0.2,
            target_deviation_m: 0.0,
            commit: true,
        }
    }
}

/// A number of an order that can be wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[allow(missing_docs)]
pub enum Field {
    Poses,
    HeldOutPoses,
    TravelM,
    TurnRad,
    SpeedMPerS,
    XM,
    YM,
    ThetaRad,
    TargetDeviationM,
    Decimation,
    Samples,
    Channels,
    Slot,
    UnixS,
}

/// What the board answers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
// As for `Action`.
#[allow(clippy::large_enum_variant)]
pub enum Reply {
    /// Who is there. Same layout in every version.
    Hello(Hello),
    /// Done, or under way.
    Done,
    /// Not done.
    Refused(Refusal),
    /// State of the board.
    Status(BoardStatus),
    /// State of the session.
    Progress(Progress),
    /// A calibration.
    Calibration(Calibration),
    /// Where the record in force now is.
    Place(Place),
    /// Both slots.
    Slots([SlotReport; 2]),
    /// The last fault, if there was one since it was last cleared.
    LastFault(Option<FaultReport>),
}

/// Who is there.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hello {
    /// The board's [`PROTOCOL`].
    pub protocol: u16,
    /// Firmware's version, as in Cargo.toml.
    pub firmware: String<24>,
    /// `g474`, `emulated` or `simulated`.
    pub board: String<16>,
    /// The board's own number.
    pub device: [u8; 12],
    /// Sampling rate, hertz.
    pub rate_hz: f32,
}

/// Which side is to be updated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum VersionMismatch {
    /// The board is newer.
    #[error("the board speaks link protocol {board}, this command {host}: update this command")]
    UpdateHost {
        /// Board's version.
        board: u16,
        /// Host's version.
        host: u16,
    },
    /// The host is newer.
    #[error(
        "the board speaks link protocol {board}, this command {host}: update the board's firmware"
    )]
    UpdateBoard {
        /// Board's version.
        board: u16,
        /// Host's version.
        host: u16,
    },
}

/// Checks that both sides speak the same version.
///
/// # Errors
/// [`VersionMismatch`] tells which side to update.
pub const fn check_versions(board: u16, host: u16) -> Result<(), VersionMismatch> {
    if board > host {
        Err(VersionMismatch::UpdateHost { board, host })
    } else if board < host {
        Err(VersionMismatch::UpdateBoard { board, host })
    } else {
        Ok(())
    }
}

/// What the background is at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Activity {
    /// Nothing.
    #[default]
    Idle,
    /// A calibration.
    Calibrating,
    /// Solving, at the end of a calibration.
    Solving,
}

/// Where the calibration in force is from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum InForce {
    /// There is none.
    #[default]
    None,
    /// Loaded or just made, not stored.
    Unsaved,
    /// Stored.
    Stored(Place),
}

/// State of the board.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BoardStatus {
    /// Uptime and, if set, date.
    pub time: Instant,
    /// Samples taken, modulo 2^32.
    pub samples: u32,
    /// Sampling instants missed.
    pub missed: u32,
    /// Frames that the background was too late for.
    pub dropped_frames: u32,
    /// Telemetry samples that the host was too late for.
    pub lost_telemetry: u32,
    /// Status bits of the last frame.
    pub status: u32,
    /// Status bits that were seen since the last [`Action::Status`].
    pub status_seen: u32,
    /// What the background is at.
    pub activity: Activity,
    /// Whether the courier is being moved.
    pub moving: bool,
    /// Calibration in force.
    pub in_force: InForce,
    /// Last frame's pose.
    pub pose: Pose,
    /// Last frame's parity, metres.
    pub parity_m: f32,
    /// Last frame's amplitudes, counts.
    pub amplitude_counts: [f32; SEGMENTS],
    /// Board temperature, degrees Celsius, if it is measured.
    pub temperature_c: Option<f32>,
    /// Frames from the host.
    pub link: FrameCounters,
    /// Frames from the motion controller.
    pub motion: FrameCounters,
    /// Why the board last started.
    pub reset: ResetCause,
}

/// Why the board started.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum ResetCause {
    /// The supply came, or it is not known.
    #[default]
    PowerOn,
    /// The reset pin or the debug probe.
    Pin,
    /// [`Action::Restart`].
    Requested,
    /// The supply was too low.
    BrownOut,
    /// Interrupt or background made no progress.
    Watchdog,
    /// A panic; [`Action::LastFault`] tells where.
    Panic,
    /// A hard fault; [`Action::LastFault`] tells where.
    HardFault,
}

/// What was kept over a reset.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FaultReport {
    /// Panic, hard fault, watchdog or brown-out.
    pub cause: ResetCause,
    /// Seconds since the start before.
    pub uptime_s: u32,
    /// Address of the instruction; 0 if not known.
    pub program_counter: u32,
    /// Where it would have returned to; 0 if not known.
    pub link_register: u32,
    /// The panic's place and text, as far as it fits.
    pub message: String<128>,
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
            RecordError::Body | RecordError::Model(_) | RecordError::NotFinite { .. } => {
                Self::Invalid
            }
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
    #[error("{field:?} is {value}, wanted {low} to {high}")]
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
    /// A slot operation failed.
    #[error("slots: {0}")]
    Slots(SlotRefusal),
    /// The interrupt has not taken the last set of coefficients yet: try again.
    #[error("the interrupt has not taken the last coefficients yet: try again")]
    SwapBusy,
    /// The calibration did not start.
    #[error("the calibration did not start: {0}")]
    Start(StartRefusal),
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
