//! Bytes of every kind of entry. Where this test fails the layout has changed: `LAYOUT` is to be raised, and the bytes written anew.

use super::head;
use courier_sensor::calibration::Refusal as SessionRefusal;
use courier_sensor::calibration::recalibration::Proposal;
use courier_sensor::calibration::record::Method;
use courier_sensor::calibration::slots::Place;
use courier_sensor::calibration::watch::{Change, Standing};
use courier_sensor::event_log::entry::{
    ENTRY_BYTES, Ending, Event, Fault, LAYOUT, MapEvent, Read, decode, encode,
};
use courier_sensor::frame::Coordinate;
use courier_sensor::link::message::{InForce, Refusal, ResetCause};
use courier_sensor::update::version::Version;

const PLACE: Place = Place {
    slot: 1,
    sequence: 300,
};

fn events() -> Vec<(Event, &'static str)> {
    let version = Version {
        major: 0,
        minor: 1,
        patch: 2,
    };
    let fault = Fault {
        uptime_s: 3600,
        program_counter: 0x0800_4242,
        link_register: 0x0800_1111,
        message: "src/x.rs:7: no".try_into().unwrap(),
    };
    let change = Change {
        segment: 1,
        order: 2,
        or_segment: Some(3),
        size_m: 0.5,
        deviation_m: 0.25,
        since_s: 100,
        told_s: 200,
        warmer_k: 1.0,
        limit_m: 2.0,
        limit_in_s: Some(300),
    };
    let ahead = [Coordinate {
        teeth: 5,
        fraction_turns: 0.5,
    }; 2];
    let candidate = Proposal {
        moves_m: 0.5,
        deviation_m: 0.25,
        gain: 5.0,
        evidence: 1.0,
        segment: 1,
        order: 2,
        size_m: 0.5,
        windows: 200,
    };
    vec![
        (
            Event::Started {
                cause: ResetCause::Panic,
                faults_in_a_row: 2,
                firmware: version,
                in_force: InForce::Stored(PLACE),
                boot: Some(Refusal::SafeMode),
                fault: Some(fault),
            },
            "c801010180a4a7da06c8010005020001020201ac02010e01901cc284814091a280400e7372632f782e72733a373a206e6f",
        ),
        (Event::Status(1 << 19), "c801010180a4a7da06c80101808020"),
        (
            Event::CalibrationBegun(Method::Joint),
            "c801010180a4a7da06c8010201",
        ),
        (
            Event::CalibrationEnded {
                ending: Ending::Accepted(Some(PLACE)),
                held_out_m: [1.0, 0.5],
            },
            "c801010180a4a7da06c80103000101ac020000803f0000003f",
        ),
        (
            Event::CalibrationEnded {
                ending: Ending::Refused(SessionRefusal::Aborted),
                held_out_m: [0.0; 2],
            },
            "c801010180a4a7da06c8010302000000000000000000",
        ),
        (
            Event::InForce {
                now: InForce::Unsaved,
                rolled_back: true,
            },
            "c801010180a4a7da06c801040101",
        ),
        (
            Event::Map(MapEvent::InForce { slot: 3 }),
            "c801010180a4a7da06c801050003",
        ),
        (
            Event::Map(MapEvent::NotWhole { slot: 3, ahead }),
            "c801010180a4a7da06c8010501030a0000003f0a0000003f",
        ),
        (
            Event::Map(MapEvent::OtherPlaten {
                slot: 3,
                parity_m: [1.0, 0.5],
            }),
            "c801010180a4a7da06c8010502030000803f0000003f",
        ),
        (
            Event::Map(MapEvent::Refused {
                slot: 3,
                refusal: Refusal::MapBusy,
            }),
            "c801010180a4a7da06c80105040309",
        ),
        (
            Event::Watch {
                standing: Standing::Drifting,
                change: Some(change),
            },
            "c801010180a4a7da06c801060301010201030000003f0000803e64c8010000803f0000004001ac02",
        ),
        (Event::ImageTaken(version), "c801010180a4a7da06c80107000102"),
        (
            Event::ImageAccepted(version),
            "c801010180a4a7da06c80108000102",
        ),
        (
            Event::Proposed(candidate),
            "c801010180a4a7da06c801090000003f0000803e0000a0400000803f01020000003fc801",
        ),
        (
            Event::Recalibrated(InForce::Stored(PLACE)),
            "c801010180a4a7da06c8010a0201ac02",
        ),
    ]
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[test]
fn the_bytes_of_every_kind_of_entry() {
    for (event, wanted) in events() {
        let mut buffer = [0; ENTRY_BYTES];
        let bytes = encode(&head(200), &event, &mut buffer).expect("it fits");
        assert_eq!(bytes[0], LAYOUT);
        assert_eq!(decode(bytes), Some(Read::Known(head(200), event.clone())));
        assert_eq!(hex(&bytes[1..]), wanted, "{event:?}");
    }
}
