//! One of every message.

use crate::common::fullest::fullest;
use courier_sensor::calibration::record::Method;
use courier_sensor::calibration::slots::{Place, SlotError};
use courier_sensor::calibration::{self, Evidence, Plan, Stage};
use courier_sensor::device::Device;
use courier_sensor::drivers::motion::{FaultCode, Target};
use courier_sensor::frame::{Coordinate, Status};
use courier_sensor::link::message::*;
use courier_sensor::link::report::{Ending, Progress};
use courier_sensor::link::telemetry::{Channels, StreamOrder};
use courier_sensor::maps::homing::Anchor;
use courier_sensor::maps::{MapInfo, MapSlot, MapSlotState, MapStoreError};
use courier_sensor::teeth::{Grid, MAX_WAVES, MapHeader, TRUST_WORDS, Wave};
use courier_sensor::update::install;
use courier_sensor::update::order::{PIECE_BYTES, UpdateOrder, UpdateStatus};
use courier_sensor::update::version::Version;

pub fn hello() -> Hello {
    Hello {
        protocol: PROTOCOL,
        firmware: "0.1.0".try_into().unwrap(),
        board: "simulated".try_into().unwrap(),
        device: Device(*b"board-000001"),
        rate_hz: 20_000.0,
    }
}

pub fn actions() -> Vec<Action> {
    vec![
        Action::Status,
        Action::Calibrate(CalibrateOrder {
            method: Method::Joint,
            plan: Plan::Optimal,
            ..CalibrateOrder::default()
        }),
        Action::Abort,
        Action::Progress,
        Action::GoTo {
            target: Target {
                x_m: 0.1,
                y_m: -0.1,
                theta_rad: 0.01,
            },
            speed_m_per_s: 0.2,
        },
        Action::Read(Source::InForce),
        Action::Read(Source::Slot(1)),
        Action::take_over(fullest()),
        Action::Commit { lose_unknown: true },
        Action::RollBack,
        Action::Slots,
        Action::Stream(StreamOrder {
            channels: Channels::RECORDING.bits(),
            decimation: 1,
            samples: 0,
        }),
        Action::Record { samples: 100_000 },
        Action::SetTime {
            unix_s: 1_700_000_000,
        },
        Action::MapStore {
            place: MapPlace {
                name: "sixteen-letters.".try_into().unwrap(),
                anchor: Anchor {
                    beacon_teeth: [-600, 601],
                    ..Anchor::default()
                },
                parity_m: 1.0e-6,
            },
            header: largest_header(),
        },
        Action::MapStoreNodes([-2047; MAP_NODES_A_COMMAND].into_iter().collect()),
        Action::MapStoreEnd,
        Action::MapSlot(3),
        Action::MapForget(0),
        Action::LastFault,
        Action::Restart,
        Action::Update(UpdateOrder::Piece {
            offset: 384,
            bytes: heapless::Vec::from_slice(&[0x5A; PIECE_BYTES]).unwrap(),
        }),
    ]
}

/// With as many waves and trust bits as there can be.
fn largest_header() -> MapHeader {
    let grid = Grid {
        first_teeth: [-300, 300],
        nodes: [20, 20],
    };
    let wave = Wave {
        own_order: 2,
        lateral_order: -1,
        coefficients_m: [[1.0e-6, -1.0e-6]; 4],
    };
    MapHeader {
        grids: [grid; 2],
        waves: [wave; MAX_WAVES].into_iter().collect(),
        trusted: [u32::MAX; TRUST_WORDS].into_iter().collect(),
    }
}

pub fn replies() -> Vec<Reply> {
    let place = Place {
        slot: 1,
        sequence: 7,
    };
    let slot = SlotReport {
        slot: 0,
        sequence: None,
        state: SlotContent::Refused(RecordRefusal::UnknownVersion(9)),
    };
    let refusal = calibration::Refusal::BadFrames {
        pose: 3,
        status: Status::CONVERTER_CRC | Status::SLIP_4,
        bad: 9,
        limit: 8,
    };
    let ended = |ending| Progress {
        stage: Stage::Finished,
        worst_deviation_m: f32::INFINITY,
        steps: [None; 5],
        ending: Some(ending),
        ..Progress::default()
    };
    let motion = calibration::Refusal::MotionFault {
        fault: FaultCode::Overload,
        pose: 3,
    };
    let (evidence, fault) = (Evidence::default(), "x".repeat(128));
    vec![
        Reply::Hello(hello()),
        Reply::Done,
        Reply::Status(BoardStatus::default()),
        Reply::Progress(ended(Ending::Accepted {
            evidence,
            stored: Some(place),
        })),
        Reply::Progress(ended(Ending::Refused { refusal, evidence })),
        Reply::Progress(ended(Ending::Refused {
            refusal: motion,
            evidence,
        })),
        Reply::Progress(ended(Ending::NotKept {
            evidence,
            refusal: Refusal::SwapBusy,
        })),
        Reply::Calibration(fullest()),
        Reply::Place(place),
        Reply::Slots([slot, slot]),
        Reply::LastFault(None),
        Reply::LastFault(Some(FaultReport {
            cause: ResetCause::Panic,
            uptime_s: 1,
            program_counter: u32::MAX,
            link_register: u32::MAX,
            message: fault.as_str().try_into().unwrap(),
        })),
        Reply::Update(UpdateStatus {
            running: Version::OWN,
            trial_left_s: Some(100),
            development_key: true,
            progress: install::Progress::Checking {
                done: 512,
                of: 200_000,
            },
        }),
        Reply::Refused(Refusal::Update(install::UpdateRefusal::Offset {
            found: 0,
            wanted: 384,
        })),
        Reply::Refused(Refusal::MapStore(MapStoreError::Full)),
        Reply::MapSlot(MapSlot {
            slot: 1,
            state: MapSlotState::Current,
            info: Some(MapInfo::default()),
            mark: Some([Coordinate::default(); 2]),
        }),
        Reply::Status(BoardStatus {
            stored_map: StoredMap::OtherPlaten {
                slot: 2,
                parity: Default::default(),
            },
            ..BoardStatus::default()
        }),
        Reply::Refused(Refusal::Busy),
        Reply::Refused(
            SlotError::WouldLoseUnknown {
                slot: 1,
                version: 2,
            }
            .into(),
        ),
        Reply::Refused(Refusal::Range {
            field: Field::Poses,
            value: 1.0,
            low: 50.0,
            high: 10_000.0,
        }),
        Reply::Refused(Refusal::Start(StartRefusal::NoBeacon)),
    ]
}
