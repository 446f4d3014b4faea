//! The debug link from the host's bytes to the board's actions and back.

use courier_sensor::calibration::record::{self, Calibration, Instant, Method};
use courier_sensor::calibration::slots::{Place, SlotError};
use courier_sensor::calibration::{self, Evidence, Plan, Stage};
use courier_sensor::drivers::motion::{FaultCode, Target};
use courier_sensor::frame::Status;
use courier_sensor::geometry::Geometry;
use courier_sensor::link::client::Client;
use courier_sensor::link::framing::{self, Decoder};
use courier_sensor::link::message::*;
use courier_sensor::link::report::{Ending, Progress};
use courier_sensor::link::server::{Event, Server};
use courier_sensor::link::telemetry::{self, Block, Channels, StreamOrder};
use courier_sensor::model::{ErrorModel, Term, TermTable};
use proptest::prelude::*;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

fn hello() -> Hello {
    Hello {
        protocol: PROTOCOL,
        firmware: "0.1.0".try_into().unwrap(),
        board: "simulated".try_into().unwrap(),
        device: *b"board-000001",
        rate_hz: 20_000.0,
    }
}

/// The largest calibration that there can be.
fn fullest() -> Calibration {
    let mut calibration = Calibration::identity(Geometry::PAPER);
    let mut table = TermTable::default();
    for (own, lateral) in (1..=16).flat_map(|own| (-4..=4).map(move |lateral| (own, lateral))) {
        let _ = table.push(Term {
            own_order: own,
            lateral_order: lateral,
            ..Term::default()
        });
    }
    calibration.model = ErrorModel::zero(table);
    calibration
        .model
        .coefficients
        .iter_mut()
        .flatten()
        .flatten()
        .for_each(|k| *k = 999.0);
    calibration.made = Instant {
        unix_s: Some(u64::MAX),
        uptime_s: u32::MAX,
    };
    calibration.beacon = Some(record::Beacon {
        origin_teeth: [i32::MAX; 2],
        origin_m: [1.0; 2],
        sensor: [1.0; 16],
        segment_sd_m: 1.0e-6,
        displacement_sd_m: 1.0e-6,
    });
    calibration
}

fn actions() -> Vec<Action> {
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
        Action::Load(fullest()),
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
        Action::LastFault,
        Action::Restart,
    ]
}

fn replies() -> Vec<Reply> {
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

fn serve(server: &mut Server, bytes: &[u8]) -> Vec<Event> {
    bytes.iter().filter_map(|&byte| server.feed(byte)).collect()
}

/// The action as it was sent, with the calibration that the server leaves in its buffer until the next byte.
fn whole(server: &Server, action: &Action<()>) -> Result<Action, Refusal> {
    if *action == Action::Load(()) {
        let mut calibration = Calibration::identity(Geometry::PAPER);
        return server
            .loaded(&mut calibration)
            .map(|()| Action::Load(calibration));
    }
    let mut bytes = [0; 64];
    let bytes = postcard::to_slice(action, &mut bytes).unwrap();
    Ok(postcard::from_bytes(bytes).unwrap())
}

fn greeted() -> (Server, Client) {
    let (mut server, mut client) = (Server::new(hello()), Client::new());
    let mut buffer = [0; FRAME_BYTES];
    let (number, bytes) = client.hello(&mut buffer).unwrap();
    let events = serve(&mut server, bytes);
    assert_eq!(
        events,
        [Event::Answer(Response {
            number,
            reply: Reply::Hello(hello())
        })]
    );
    (server, client)
}

#[test]
fn every_action_and_every_reply_survives_the_way() {
    let (mut server, mut client) = greeted();
    let mut buffer = [0; FRAME_BYTES];
    for action in actions() {
        let (number, bytes) = client.ask(action.clone(), &mut buffer).unwrap();
        match &serve(&mut server, bytes)[..] {
            [
                Event::Act {
                    number: taken,
                    action: head,
                },
            ] => {
                assert_eq!((*taken, whole(&server, head)), (number, Ok(action)));
            }
            other => panic!("{action:?}: {other:?}"),
        }
    }
    for reply in replies() {
        let response = Response { number: 5, reply };
        let bytes = framing::encode(&response, &mut buffer).unwrap();
        let got: Vec<Response> = bytes.iter().filter_map(|&byte| client.feed(byte)).collect();
        assert_eq!(got, [response]);
    }
}

#[test]
fn nothing_is_done_before_a_hello_of_the_same_version() {
    let (mut server, mut client) = (Server::new(hello()), Client::new());
    let mut buffer = [0; FRAME_BYTES];
    let not_greeted = |number| {
        let reply = Reply::Refused(Refusal::NotGreeted { protocol: PROTOCOL });
        [Event::Answer(Response { number, reply })]
    };
    let (number, bytes) = client.ask(Action::Restart, &mut buffer).unwrap();
    assert_eq!(serve(&mut server, bytes), not_greeted(number));
    for protocol in [PROTOCOL - 1, PROTOCOL + 1] {
        let request: Request = Request {
            number: 9,
            command: Command::Hello { protocol },
        };
        let bytes = framing::encode(&request, &mut buffer).unwrap();
        assert_eq!(
            serve(&mut server, bytes),
            [Event::Answer(Response {
                number: 9,
                reply: Reply::Hello(hello())
            })]
        );
        let (number, bytes) = client.ask(Action::Status, &mut buffer).unwrap();
        assert_eq!(serve(&mut server, bytes), not_greeted(number));
    }
}

#[test]
fn a_version_mismatch_says_which_side_to_update() {
    assert_eq!(check_versions(3, 3), Ok(()));
    let newer_board = check_versions(4, 3).unwrap_err().to_string();
    assert_eq!(
        newer_board,
        "the board speaks link protocol 4, this command 3: update this command"
    );
    let newer_host = check_versions(3, 4).unwrap_err().to_string();
    assert_eq!(
        newer_host,
        "the board speaks link protocol 3, this command 4: update the board's firmware"
    );
}

#[test]
fn numbers_out_of_range_are_refused_before_the_background_sees_them() {
    let order = CalibrateOrder::default();
    let orders = [
        (
            Action::Calibrate(CalibrateOrder { poses: 39, ..order }),
            "Poses is 39, wanted 40 to 20000",
        ),
        (
            Action::Calibrate(CalibrateOrder {
                method: Method::Joint,
                poses: 1001,
                ..order
            }),
            "Poses is 1001, wanted 50 to 1000",
        ),
        (
            Action::Calibrate(CalibrateOrder {
                travel_m: f32::NAN,
                ..order
            }),
            "TravelM is NaN, wanted 0.001 to 0.5",
        ),
        (
            Action::Calibrate(CalibrateOrder {
                turn_rad: -0.1,
                ..order
            }),
            "TurnRad is -0.1, wanted 0 to 0.06",
        ),
        (
            Action::Calibrate(CalibrateOrder {
                speed_m_per_s: f32::INFINITY,
                ..order
            }),
            "SpeedMPerS is inf, wanted 0.001 to 1.5",
        ),
        (Action::Read(Source::Slot(2)), "Slot is 2, wanted 0 to 1"),
        (
            Action::Record { samples: 0 },
            "Samples is 0, wanted 1 to 4294967300",
        ),
        (
            Action::Stream(StreamOrder {
                channels: 1,
                decimation: 0,
                samples: 0,
            }),
            "Decimation is 0, wanted 1 to 65535",
        ),
        (
            Action::Stream(StreamOrder {
                channels: 1 << 9,
                decimation: 1,
                samples: 0,
            }),
            "Channels is 512, wanted 0 to 511",
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

#[test]
fn half_frames_noise_and_the_largest_frame() {
    let (mut server, mut client) = greeted();
    let mut buffer = [0; FRAME_BYTES];
    let (_, largest) = client.ask(Action::Load(fullest()), &mut buffer).unwrap();
    let largest = largest.to_vec();
    println!("largest request: {} of {FRAME_BYTES} bytes", largest.len());
    for cut in [1, 2, largest.len() / 2, largest.len() - 2] {
        assert_eq!(serve(&mut server, &largest[..cut]), []);
        let events = serve(&mut server, &largest);
        assert!(
            matches!(events[..], [Event::Act { .. }]),
            "after {cut} bytes of a frame"
        );
    }
    // As long as the board takes, and longer.
    for length in [FRAME_BYTES, FRAME_BYTES + 1, 10 * FRAME_BYTES] {
        assert_eq!(serve(&mut server, &vec![1; length]), []);
        assert!(
            matches!(serve(&mut server, &largest)[..], [Event::Act { .. }]),
            "after {length} bytes"
        );
    }
    // Another program's whole frame, and a later protocol's command.
    let bytes = framing::encode(&(1u16, 1u8, 99u8), &mut buffer).unwrap();
    let unknown = Response {
        number: 0,
        reply: Reply::Refused(Refusal::Unknown),
    };
    assert_eq!(serve(&mut server, bytes), [Event::Answer(unknown)]);
    assert!(server.counters().bad() >= 7, "{:?}", server.counters());
}

/// Bytes of each fuzz test.
const FUZZ_BYTES: usize = 10_000_000;

#[test]
fn random_bytes_do_nothing_and_break_nothing() {
    let (mut server, mut client) = greeted();
    let mut board = Decoder::<{ telemetry::FRAME_BYTES }>::new();
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut chunk = [0; 1000];
    for _ in 0..FUZZ_BYTES / chunk.len() {
        rng.fill_bytes(&mut chunk);
        for &byte in &chunk {
            assert!(
                !matches!(server.feed(byte), Some(Event::Act { .. })),
                "a command out of noise"
            );
            client.feed(byte);
            if let Some(Ok(block)) = board.feed::<Block>(byte) {
                block.samples().for_each(drop);
            }
        }
    }
    assert!(server.counters().bad() as usize > FUZZ_BYTES / 1000);
    let mut buffer = [0; FRAME_BYTES];
    let (_, bytes) = client.ask(Action::Status, &mut buffer).unwrap();
    let last = serve(&mut server, bytes).pop();
    assert!(
        matches!(
            last,
            Some(Event::Act {
                action: Action::Status,
                ..
            })
        ),
        "and understands at once afterwards"
    );
}

#[test]
fn calibrations_that_cannot_be_used_are_refused() {
    let (mut server, mut client) = greeted();
    let mut buffer = [0; FRAME_BYTES];
    let mut bad = fullest();
    bad.model.coefficients[0][0][0] = f32::NAN;
    let (_, bytes) = client.ask(Action::Load(bad), &mut buffer).unwrap();
    let unusable = |server: &Server, events: &[Event]| match events {
        [
            Event::Act {
                action: Action::Load(()),
                ..
            },
        ] => {
            assert_eq!(
                whole(server, &Action::Load(())).unwrap_err().to_string(),
                "the calibration cannot be used: terms, coefficients or other numbers cannot be used"
            );
        }
        other => panic!("{other:?}"),
    };
    let events = serve(&mut server, bytes);
    unusable(&server, &events);
    // Cut short, and with bytes behind it.
    let load: Command = Command::Do(Action::Load(fullest()));
    let mut room = [0; FRAME_BYTES];
    let message = postcard::to_slice(&(7u16, load), &mut room)
        .unwrap()
        .to_vec();
    for length in [3, message.len() / 2, message.len() - 1, message.len() + 1] {
        let mut message = message.clone();
        message.resize(length, 0);
        let bytes = framing::encode(&Raw(&message), &mut buffer).unwrap();
        let events = serve(&mut server, bytes);
        unusable(&server, &events);
    }
}

/// Good frames with a few bytes changed: nearer to what would be taken than noise is.
#[test]
fn damaged_frames_never_become_another_command() {
    let (mut server, mut client) = greeted();
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let mut buffer = [0; FRAME_BYTES];
    let mut left = FUZZ_BYTES / 10;
    while left > 0 {
        for action in actions() {
            let (_, bytes) = client.ask(action.clone(), &mut buffer).unwrap();
            let mut bytes = bytes.to_vec();
            left = left.saturating_sub(bytes.len());
            for _ in 0..=rng.next_u32() % 4 {
                let place = rng.next_u32() as usize % bytes.len();
                bytes[place] ^= (rng.next_u32() % 255 + 1) as u8;
            }
            for event in serve(&mut server, &bytes) {
                // Changes may cancel, or fall on delimiters alone: then it is the command that was sent.
                let Event::Act { action: taken, .. } = event else {
                    continue;
                };
                assert_eq!(whole(&server, &taken), Ok(action.clone()));
            }
        }
    }
}

/// Whole frames with good CRC around random messages: what a program of another version could send.
#[test]
fn random_messages_in_good_frames_never_panic() {
    let (mut server, mut client) = greeted();
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let mut buffer = [0; FRAME_BYTES];
    for _ in 0..FUZZ_BYTES / 100 {
        let mut message = vec![0; rng.next_u32() as usize % 64];
        rng.fill_bytes(&mut message);
        if let Some(first) = message.get_mut(1) {
            *first %= 2;
        }
        if let Some(second) = message.get_mut(2) {
            *second %= 16;
        }
        let bytes = framing::encode(&Raw(&message), &mut buffer)
            .unwrap()
            .to_vec();
        for byte in bytes {
            if let Some(Event::Act { action, .. }) = server.feed(byte) {
                assert_eq!(action.validate(), Ok(()));
                let _ = server.loaded(&mut Calibration::identity(Geometry::PAPER));
            }
            client.feed(byte);
        }
    }
    assert!(server.counters().good > 0 && server.counters().unknown > 0);
}

/// Bytes that are the message themselves.
struct Raw<'a>(&'a [u8]);

impl serde::Serialize for Raw<'_> {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        use serde::ser::SerializeTuple;
        let mut tuple = serializer.serialize_tuple(self.0.len())?;
        self.0
            .iter()
            .try_for_each(|byte| tuple.serialize_element(byte))?;
        tuple.end()
    }
}

proptest! {
    #[test]
    fn any_message_round_trips_through_any_split(message in proptest::collection::vec(any::<u8>(), 0..500), noise in proptest::collection::vec(any::<u8>(), 0..50)) {
        let mut buffer = [0; 600];
        let bytes = framing::encode(&message, &mut buffer).unwrap();
        prop_assert!(bytes.len() <= framing::encoded_bytes(message.len() + 2));
        let mut decoder = Decoder::<600>::new();
        let noisy: Vec<u8> = noise.iter().chain(bytes).chain(bytes).copied().collect();
        let got: Vec<Vec<u8>> = noisy.iter().filter_map(|&byte| decoder.feed::<Vec<u8>>(byte)).filter_map(Result::ok).collect();
        prop_assert_eq!(&got[got.len() - 2..], &[message.clone(), message.clone()][..]);
    }
}
