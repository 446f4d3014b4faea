//! What the server refuses before the background sees it.

use super::{Raw, greeted, serve, whole};
use crate::common::fullest::fullest;
use courier_sensor::calibration::record::Method;
use courier_sensor::link::framing;
use courier_sensor::link::message::*;
use courier_sensor::link::server::{Event, Server};
use courier_sensor::link::telemetry::StreamOrder;

#[test]
fn numbers_out_of_range_are_refused_before_the_background_sees_them() {
    let order = CalibrateOrder::default();
    let orders = [
        (
            Action::Calibrate(CalibrateOrder { poses: 48, ..order }),
            "number of poses is 48, wanted 49 to 20000",
        ),
        (
            Action::Calibrate(CalibrateOrder {
                method: Method::Joint,
                poses: 1001,
                ..order
            }),
            "number of poses is 1001, wanted 50 to 1000",
        ),
        (
            Action::Calibrate(CalibrateOrder {
                travel_m: f32::NAN,
                ..order
            }),
            "travel in metres is NaN, wanted 0.001 to 0.5",
        ),
        (
            Action::Calibrate(CalibrateOrder {
                turn_rad: -0.1,
                ..order
            }),
            "angle in radians is -0.1, wanted 0 to 0.06",
        ),
        (
            Action::Calibrate(CalibrateOrder {
                speed_m_per_s: f32::INFINITY,
                ..order
            }),
            "speed in m/s is inf, wanted 0.001 to 1.5",
        ),
        (Action::Read(Source::Slot(2)), "slot is 2, wanted 0 to 1"),
        (
            Action::Record { samples: 0 },
            "number of samples is 0, wanted 1 to 4294967300",
        ),
        (
            Action::Stream(StreamOrder {
                channels: 1,
                decimation: 0,
                samples: 0,
            }),
            "decimation is 0, wanted 1 to 65535",
        ),
        (
            Action::Stream(StreamOrder {
                channels: 1 << 9,
                decimation: 1,
                samples: 0,
            }),
            "channels is 512, wanted 0 to 511",
        ),
    ];
    let (mut server, mut client) = greeted();
    let mut buffer = [0; FRAME_BYTES];
    for (action, wanted) in orders {
        let (number, bytes) = client.ask(action, &mut buffer).unwrap();
        match &serve(&mut server, bytes)[..] {
            [
                Event::Answer(Response {
                    number: answered,
                    reply: Reply::Refused(refusal),
                }),
            ] => {
                assert_eq!((*answered, refusal.to_string().as_str()), (number, wanted));
            }
            other => panic!("{wanted}: {other:?}"),
        }
    }
}

const LOAD: Action<()> = Action::Load {
    other_device: true,
    calibration: (),
};

#[test]
fn calibrations_that_cannot_be_used_are_refused() {
    let (mut server, mut client) = greeted();
    let mut buffer = [0; FRAME_BYTES];
    let mut bad = fullest();
    bad.model.coefficients[0][0][0] = f32::NAN;
    let (_, bytes) = client.ask(Action::take_over(bad), &mut buffer).unwrap();
    let unusable = |server: &Server, events: &[Event]| match events {
        [
            Event::Act {
                action: Action::Load { .. },
                ..
            },
        ] => {
            assert_eq!(
                whole(server, &LOAD).unwrap_err().to_string(),
                "the calibration cannot be used: terms, coefficients or other numbers cannot be used"
            );
        }
        other => panic!("{other:?}"),
    };
    let events = serve(&mut server, bytes);
    unusable(&server, &events);
    // Cut short, and with bytes behind it.
    let load: Command = Command::Do(Action::take_over(fullest()));
    let mut room = [0; FRAME_BYTES];
    let message = postcard::to_slice(&(7u16, load), &mut room)
        .unwrap()
        .to_vec();
    for length in [4, message.len() / 2, message.len() - 1, message.len() + 1] {
        let mut message = message.clone();
        message.resize(length, 0);
        let bytes = framing::encode(&Raw(&message), &mut buffer).unwrap();
        let events = serve(&mut server, bytes);
        unusable(&server, &events);
    }
}
