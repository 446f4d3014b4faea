//! Half frames, noise, damaged frames, random messages: nothing breaks, and nothing is taken for a command.

use super::messages::actions;
use super::{Raw, greeted, serve, whole};
use crate::common::fullest::fullest;
use courier_sensor::calibration::record::Calibration;
use courier_sensor::geometry::Geometry;
use courier_sensor::link::framing::{self, Decoder};
use courier_sensor::link::message::*;
use courier_sensor::link::server::Event;
use courier_sensor::link::telemetry::{self, Block};
use proptest::prelude::*;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Bytes of each fuzz test.
const FUZZ_BYTES: usize = 10_000_000;

#[test]
fn half_frames_noise_and_the_largest_frame() {
    let (mut server, mut client) = greeted();
    let mut buffer = [0; FRAME_BYTES];
    let (_, largest) = client
        .ask(Action::take_over(fullest()), &mut buffer)
        .unwrap();
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
