//! The link: a host that does not read, that starts anywhere, that sends anything.

use crate::rig::{Rig, amount, marked};
use courier_sensor::link::message::{Action, FRAME_BYTES, TELEMETRY_CHANNEL};
use courier_sensor::link::telemetry::Channels;
use effects::random::{ChaCha8Rng, SeedableRng, index, uniform};

#[test]
fn a_host_that_stops_reading_costs_telemetry_and_nothing_else() {
    let (mut rig, before) = Rig::stored(7);
    rig.link.stream(Channels::RECORDING, 1).expect("a stream");
    // Commands go in, nothing is read: replies fill their channel, telemetry its own.
    for _ in 0..200 {
        let request = rig.request(Action::Status);
        rig.link.wire().send(&request).expect("the board is there");
        rig.run(5);
    }
    rig.throw_replies();
    rig.run(20);
    rig.throw_replies();
    let (mut next, mut lost, mut samples) = (None, 0, 0_u32);
    for _ in 0..200 {
        rig.run(1);
        let told = rig.link.lost();
        let listened = rig.link.listen(|sample| {
            samples += 1;
            let gap = next.map_or(0, |next: u32| sample.sequence.wrapping_sub(next));
            next = Some(sample.sequence.wrapping_add(1));
            lost += gap;
            Ok(())
        });
        listened.expect("the board is there");
        assert!(rig.link.lost() >= told, "the count of losses only grows");
    }
    assert!(samples > 3000, "{samples}");
    assert!(
        lost > 0 && rig.link.lost() >= lost,
        "{lost} seen, {} told",
        rig.link.lost()
    );
    rig.assert_undisturbed();
    let status = rig.status();
    assert_eq!(status.in_force, before);
    assert!(status.lost_telemetry > 15_000, "{}", status.lost_telemetry);
}

#[test]
fn noise_half_frames_and_fuzzed_bytes_do_not_reach_the_board() {
    let (mut rig, before) = Rig::stored(8);
    // Ten times as many in `cargo xtask bench`, and on the simulated board at every change (`tests/suite/link/bytes.rs`).
    let total = amount("COURIER_FUZZ_BYTES", 1_000_000);
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let (mut sent, mut good) = (0, 0);
    while sent < total {
        let actions = [
            Action::Restart,
            Action::RollBack,
            Action::take_over(marked(9)),
        ];
        let request = rig.request(actions[index(&mut rng, 3)].clone());
        let mut noise: Vec<u8> = match index(&mut rng, 4) {
            // Half a frame.
            0 => request[..index(&mut rng, request.len() - 1)].to_vec(),
            // One from its middle on, its end spoilt.
            1 => request[request.len() / 2..request.len() - 2].to_vec(),
            // The largest frame there can be, and larger.
            2 => vec![1; FRAME_BYTES + index(&mut rng, 3)],
            _ => (0..index(&mut rng, 20_000))
                .map(|_| uniform(&mut rng, 0.0, 256.0) as u8)
                .collect(),
        };
        noise.push(0);
        sent += noise.len() as u64;
        rig.send(&noise);
        if good * total < sent * 20 {
            good += 1;
            assert_eq!(rig.status().in_force, before, "after {sent} bytes");
        }
    }
    // Taking the largest frame of nothing but short blocks apart costs 3.3 ms, two frames more than the queue holds: they
    // are counted, as ever.
    rig.assert_none_missed();
    let status = rig.status();
    assert_eq!(status.in_force, before);
    assert!(status.link.bad() > 20, "{:?}", status.link);
    assert_eq!(rig.mark(), Some(1));
    println!(
        "{sent} fuzzed bytes, {} broken frames: none did anything",
        status.link.bad()
    );
}

#[test]
fn a_host_that_starts_in_the_middle_of_a_frame_finds_its_way() {
    let (mut rig, before) = Rig::stored(10);
    rig.link.stream(Channels::RECORDING, 1).expect("a stream");
    let request = rig.request(Action::RollBack);
    for part in 1..request.len() {
        // The end of what somebody else said, a part of a telemetry block gone.
        rig.send(&request[part..]);
        let mut bytes = [0; 37];
        let wire = rig.link.wire();
        wire.receive(TELEMETRY_CHANNEL, &mut bytes)
            .expect("the board is there");
        let mut samples = 0;
        rig.run(5);
        let listened = rig.link.listen(|_| {
            samples += 1;
            Ok(())
        });
        listened.expect("the board is there");
        assert!(samples > 20, "{samples}");
    }
    rig.assert_undisturbed();
    assert_eq!(rig.status().in_force, before);
}
