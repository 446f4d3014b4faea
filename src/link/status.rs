//! State of the board, as a host sees it.

use crate::calibration::recalibration::Recalibration;
use crate::calibration::record::Instant;
use crate::calibration::rest_watch::RestVerdict;
use crate::calibration::slots::Place;
use crate::calibration::watch::Verdict;
use crate::frame::{Coordinate, Pose, SEGMENTS};
use crate::link::framing::FrameCounters;
use crate::link::health::Health;
use crate::link::refusal::Refusal;
use crate::maps::fit::ParityOfMap;
use crate::maps::homing::Unusable;
use crate::teeth::Grid;
use heapless::String;
use serde::{Deserialize, Serialize};

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

/// What has become of the stored tooth maps since the board's start, or since the calibration in force came.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum StoredMap {
    /// None is stored, or they are left alone as in safe mode.
    #[default]
    None,
    /// A host decides which map is in force.
    Ordered,
    /// Those that are stored belong to another calibration than the one in force.
    OtherCalibration {
        /// One of them.
        slot: u8,
    },
    /// A map waits for this.
    Waits(Unusable),
    /// A beacon is seen, and the teeth are being found.
    Looking,
    /// The beacon is not a whole number of teeth from where a map has it: it was moved, or it is another one.
    NotWhole {
        /// The map that comes nearest.
        slot: u8,
        /// What the board counts ahead of the map, along x and y.
        ahead: [Coordinate; 2],
    },
    /// A map was in force and did not fit the platen: it is another one, or the beacon was moved by whole teeth.
    OtherPlaten {
        /// The map.
        slot: u8,
        /// What told it.
        parity: ParityOfMap,
    },
    /// The map cannot be used.
    Refused {
        /// The map.
        slot: u8,
        /// Why.
        refusal: Refusal,
    },
    /// In force.
    InForce {
        /// The map.
        slot: u8,
        /// What the board counts ahead of the map, along x and y.
        ahead: [Coordinate; 2],
        /// Seconds from the board's start until it came in force.
        uptime_s: f32,
        /// Whether it fits the platen, as far as the courier has moved.
        parity: ParityOfMap,
    },
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
    /// Frames that were not taken up: the intake was too late for them, or a calibration that averages a pose had no place for them.
    pub dropped_frames: u32,
    /// Samples of the running stream, or the last one, that were taken up but not sent: the host was too late for them.
    pub lost_telemetry: u32,
    /// Status bits of the last frame.
    pub status: u32,
    /// Status bits that were seen since the last `Action::Status`.
    pub status_seen: u32,
    /// What the background is at.
    pub activity: Activity,
    /// Whether the courier is being moved.
    pub moving: bool,
    /// Calibration in force.
    pub in_force: InForce,
    /// Tooth map in force: its two fields' lattices.
    pub map: Option<[Grid; 2]>,
    /// What has become of the stored tooth maps.
    pub stored_map: StoredMap,
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
    /// Why no stored calibration came in force then; none if one did.
    pub boot: Option<Refusal>,
    /// Cycles of the processor that the longest sampling interrupt since start took, if the board counts them.
    pub isr_cycles_worst: Option<u32>,
    /// What the board has found out about itself.
    pub health: Health,
    /// Whether the calibration in force stays true.
    pub watch: Verdict,
    /// Whether its beacon's part does.
    pub beacon_watch: RestVerdict,
    /// Whether the parity g_p at rests is what it left.
    pub parity_watch: RestVerdict,
    /// Whether ordinary motion tells of a better one.
    pub recalibration: Recalibration,
}

/// Why the board started.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "board", derive(defmt::Format))] // a number in the log; its name is in the image's texts
pub enum ResetCause {
    /// The supply came, or it is not known.
    #[default]
    PowerOn,
    /// The reset pin or the debug probe.
    Pin,
    /// `Action::Restart`.
    Requested,
    /// The supply was too low.
    BrownOut,
    /// Interrupt or background made no progress.
    Watchdog,
    /// A panic; `Action::LastFault` tells where.
    Panic,
    /// A hard fault; `Action::LastFault` tells where.
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
