//! Commands and replies of the debug link, protocol version [`PROTOCOL`].
//!
//! Three channels: log (defmt), telemetry ([`super::telemetry`]), and this pair. Every request has a number that its response repeats.
//! [`Command::Hello`] and [`Reply::Hello`] keep their layout in every version, so that both sides can always tell who is the newer.
//! A new command or field is a new protocol version.

pub use super::health::{ConverterFault, ConverterTest, Health, MemoryTest};
pub use super::refusal::{
    Field, RecordRefusal, Refusal, SlotContent, SlotRefusal, SlotReport, StartRefusal,
};
pub use super::status::{Activity, BoardStatus, FaultReport, InForce, ResetCause, StoredMap};

use crate::calibration::Plan;
use crate::calibration::recalibration;
use crate::calibration::record::{self, Calibration};
use crate::calibration::slots::Place;
use crate::device::Device;
use crate::drivers::motion::Target;
use crate::event_log::page::Page;
use crate::frame::Coordinate;
use crate::link::framing;
use crate::link::report::Progress;
use crate::link::telemetry::StreamOrder;
use crate::maps::homing::Anchor;
use crate::maps::{MapSlot, Name};
use crate::teeth::MapHeader;
use crate::update::order::{UpdateOrder, UpdateStatus};
use heapless::{String, Vec};
use serde::{Deserialize, Serialize};

/// Version of this file's types.
pub const PROTOCOL: u16 = 15;
/// Longest frame of the command and reply channel: a whole calibration with its tags.
pub const FRAME_BYTES: usize = framing::encoded_bytes(record::BODY_BYTES + 8);
/// Nodes of a tooth map that one command carries.
pub const MAP_NODES_A_COMMAND: usize = 200;
/// Channel numbers, in both directions of the target's memory.
pub const LOG_CHANNEL: usize = 0;
/// See [`LOG_CHANNEL`].
pub const TELEMETRY_CHANNEL: usize = 1;
/// Replies up, commands down: channel 2 up and 0 down.
pub const REPLY_CHANNEL: usize = 2;
/// See [`REPLY_CHANNEL`].
pub const COMMAND_CHANNEL: usize = 0;

/// A numbered command.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Request<C = Calibration> {
    /// Repeated by the response; from 1.
    pub number: u16,
    /// What to do.
    pub command: Command<C>,
}

/// A numbered reply.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Response<C = Calibration> {
    /// The request's; 0 for a frame that was no known request.
    pub number: u16,
    /// Its answer.
    pub reply: Reply<C>,
}

/// What a host can say.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
// As for `Action`.
#[allow(clippy::large_enum_variant)]
pub enum Command<C = Calibration> {
    /// First of all; answered by [`Reply::Hello`] whatever the versions. Same layout in every version.
    Hello {
        /// The host's [`PROTOCOL`].
        protocol: u16,
    },
    /// Anything else: only after a hello of the same version.
    Do(Action<C>),
}

/// What the board can be asked to do; checked by [`Action::validate`] before it reaches the background.
///
/// `C` is the calibration. The board's end takes it as `()`, which decodes from no bytes: the calibration behind it is decoded
/// where it is to stay ([`super::server::Server::loaded`]), since its kilobyte would else pass through every stack frame of the decoder.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
// One action exists at a time, on the host's stack.
#[allow(clippy::large_enum_variant)]
pub enum Action<C = Calibration> {
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
    Load {
        /// Take over a calibration of another board, which is refused otherwise. From then on it is this board's, in its record too.
        other_device: bool,
        /// What to put in force. The last field: the board decodes it from where the rest ends.
        calibration: C,
    },
    /// Begin to load a tooth map; one in force is taken out of it.
    MapBegin(MapHeader),
    /// Its next nodes, nanometres.
    MapNodes(Vec<i16, MAP_NODES_A_COMMAND>),
    /// Put it in force, until another calibration or map comes, or the board restarts.
    MapApply,
    /// Take the tooth map out of force, and put none in force until another calibration or map comes, or the board restarts.
    MapDrop,
    /// Begin to store a tooth map with the error model in force, for the stored calibration.
    MapStore {
        /// Where it lies.
        place: MapPlace,
        /// What comes before its nodes.
        header: MapHeader,
    },
    /// Its next nodes, nanometres.
    MapStoreNodes(Vec<i16, MAP_NODES_A_COMMAND>),
    /// End it; the stored calibration is in force then, and the board looks for the map's beacon. [`Reply::MapSlot`].
    MapStoreEnd,
    /// What does a slot for maps hold, 0 to 3? [`Reply::MapSlot`].
    MapSlot(u8),
    /// Take a stored map out of use.
    MapForget(u8),
    /// The courier stands at a reference mark or an end stop: put the map in this slot in force by it.
    MapAtMark {
        /// The map.
        slot: u8,
        /// The mark's place in the map's count, along x and y.
        mark: [Coordinate; 2],
    },
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
    /// Take a new firmware in, or tell how that stands. [`Reply::Update`].
    Update(UpdateOrder),
    /// What does the log in flash hold, behind so many of its entries? [`Reply::KeptLog`].
    KeptLog {
        /// Entries that the host has.
        skip: u16,
    },
    /// What is to become of candidates of the recalibration while working. [`Reply::Place`] where one came in force.
    Recalibrate(recalibration::Order),
    /// Keep the place where the board's own reference mark was crossed last, beside the stored map in force: from then on that mark puts it
    /// in force at a start.
    MapKeepMark,
}

impl Action {
    /// [`Action::Load`] of a calibration of the board's own.
    pub const fn load(calibration: Calibration) -> Self {
        Self::Load {
            other_device: false,
            calibration,
        }
    }

    /// [`Action::Load`] of a calibration of any board, which becomes this one's.
    pub const fn take_over(calibration: Calibration) -> Self {
        Self::Load {
            other_device: true,
            calibration,
        }
    }
}

/// Where a tooth map lies, and what it left.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MapPlace {
    /// Name of the place: a map of the same name is replaced.
    pub name: Name,
    /// The beacon, in the tooth count of the map's recording.
    pub anchor: Anchor,
    /// g_p that was left with the map on held-out poses, their noise taken off, metres rms.
    pub parity_m: f32,
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
    /// Poses to fit at most, 49 to 20,000 (jointly: 50 to 1000, what the buffer holds): `super::order`.
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

/// What the board answers. The board's end sends calibrations from where they are, `C` a reference.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
// As for `Action`.
#[allow(clippy::large_enum_variant)]
pub enum Reply<C = Calibration> {
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
    Calibration(C),
    /// Where the record in force now is.
    Place(Place),
    /// Both slots.
    Slots([SlotReport; 2]),
    /// The last fault, if there was one since it was last cleared.
    LastFault(Option<FaultReport>),
    /// How an update stands.
    Update(UpdateStatus),
    /// A slot for tooth maps.
    MapSlot(MapSlot),
    /// A part of the log in flash.
    KeptLog(Page),
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
    pub device: Device,
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
