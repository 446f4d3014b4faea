//! Faults of every part on the running board, asked for and answered over its debug link: the reason is named, what was committed
//! stays in force, no sampling instant is missed, and afterwards all is as before.

use crate::bench::{Bench, marked, short, world};
use courier_sensor::calibration::Refusal as SessionRefusal;
use courier_sensor::calibration::record::Calibration;
use courier_sensor::drivers::motion::{FaultCode, Target};
use courier_sensor::frame::Status;
use courier_sensor::link::framing::Decoder;
use courier_sensor::link::message::{Action, InForce, Refusal, Reply, SlotContent, SlotRefusal};
use courier_sensor::link::report::Ending;
use courier_sensor::link::telemetry::{self, Block, Channels, StreamOrder};
use courier_sensor::model::{ErrorModel, Term, TermTable};
use courier_sensor::settings::Settings;
use courier_sensor::teeth::{Grid, MapHeader};
use courier_sensor::update::layout::SLOTS_START;
use effects::random::{ChaCha8Rng, SeedableRng, index, uniform};
use hal_sim::board::SharedFlash;
use hal_sim::wire::fault::{InputFault, When};
use hal_sim::wire::motion::Misbehaviour;

/// A board with a calibration in force that is stored.
fn stored(seed: u64) -> (Bench, SharedFlash, InForce) {
    let flash = SharedFlash::erased(seed);
    let mut bench = Bench::start(world(seed), flash.clone());
    assert!(matches!(bench.store(1), Reply::Place(_)));
    let in_force = bench.in_force();
    assert!(matches!(in_force, InForce::Stored(_)));
    (bench, flash, in_force)
}

/// The refusal that a session ends with.
fn refusal(bench: &mut Bench) -> SessionRefusal {
    match bench.ending(400_000) {
        Ending::Refused { refusal, .. } => refusal,
        other => panic!("{other:?}"),
    }
}

#[test]
fn each_fault_of_the_motion_controller_is_named_and_the_calibration_stays() {
    type Named = fn(&SessionRefusal) -> bool;
    let cases: [(Misbehaviour, Named); 5] = [
        (Misbehaviour::Silent, |r| {
            matches!(r, SessionRefusal::NotSettled { nonsense: 0, .. })
        }),
        (Misbehaviour::Nonsense, |r| {
            matches!(r, SessionRefusal::NotSettled { nonsense: 1.., .. })
        }),
        (Misbehaviour::NeverSettles, |r| {
            matches!(r, SessionRefusal::NotSettled { answers: 1.., .. })
        }),
        (Misbehaviour::Faulted(FaultCode::Stalled), |r| {
            matches!(
                r,
                SessionRefusal::MotionFault {
                    fault: FaultCode::Stalled,
                    ..
                }
            )
        }),
        (Misbehaviour::Sways(1.0e-3), |r| {
            matches!(r, SessionRefusal::NotStill { .. })
        }),
    ];
    for (misbehaviour, named) in cases {
        let (mut bench, _flash, before) = stored(1);
        assert_eq!(bench.ask(Action::Calibrate(short())), Reply::Done);
        bench.run(20_000);
        bench.board.world.motion.misbehave(misbehaviour);
        let refusal = refusal(&mut bench);
        assert!(named(&refusal), "{misbehaviour:?}: {refusal}");
        assert_eq!(bench.in_force(), before, "{misbehaviour:?}");
        assert_eq!(bench.mark(), Some(1));
        // And a session can be ordered again.
        bench.board.world.motion.misbehave(Misbehaviour::None);
        assert_eq!(bench.ask(Action::Calibrate(short())), Reply::Done);
    }
}

#[test]
fn each_fault_of_the_converters_ends_a_session_by_its_bit() {
    let cases = [
        (
            InputFault::Stuck {
                chip: 0,
                channel: 2,
                counts: 0,
            },
            Status::AMPLITUDE_LOW_2 | Status::FROZEN,
        ),
        (
            InputFault::Stuck {
                chip: 0,
                channel: 7,
                counts: i16::MAX,
            },
            Status::CLIPPED_4,
        ),
        (InputFault::Frozen, Status::FROZEN),
        (InputFault::Off, Status::FROZEN),
    ];
    for (fault, wanted) in cases {
        let (mut bench, _flash, before) = stored(2);
        assert_eq!(bench.ask(Action::Calibrate(short())), Reply::Done);
        bench.run(20_000);
        bench
            .board
            .world
            .converter
            .input_fault()
            .set(fault, When::Always);
        match refusal(&mut bench) {
            SessionRefusal::BadFrames { status, .. } => {
                assert!(status.intersects(wanted), "{fault:?}: {status:?}")
            }
            other => panic!("{fault:?}: {other}"),
        }
        assert_eq!(bench.in_force(), before, "{fault:?}");
    }
}

#[test]
fn a_converter_that_lost_its_settings_comes_back_by_itself() {
    let (mut bench, _flash, _) = stored(3);
    bench.run(100);
    bench
        .board
        .world
        .converter
        .with_chip(0, |chip| chip.reset());
    let lost = (0..1000)
        .filter(|_| bench.board.sample().status.contains(Status::CONVERTER_CRC))
        .count();
    assert!((20..200).contains(&lost), "{lost}");
    assert!(
        bench.status().status_seen & Status::CONVERTER_CRC.bits() != 0,
        "and it can be read afterwards"
    );
    bench.run(10);
    assert_eq!(bench.status().status_seen & Status::CONVERTER_CRC.bits(), 0);
    assert_eq!(bench.status().missed, 0);
}

#[test]
fn instants_missed_are_in_the_frames_numbers_and_tell_of_the_teeth() {
    let period_ns = 50_000;
    for (instants, slips) in [(5, false), (200, true)] {
        let (mut bench, _flash, _) = stored(3);
        bench.run(100);
        let before = bench.board.sample().sequence;
        // A debugger halts the processor; the timer does not stand still.
        bench.board.world.clock.advance_ns(instants * period_ns);
        let frame = bench.board.sample();
        let passed = frame.sequence.wrapping_sub(before);
        assert!((instants..=instants + 1).contains(&u64::from(passed)));
        assert!(frame.status.contains(Status::OVERRUN));
        assert_eq!(bench.status().missed, passed - 1);
        let later = bench.board.sample().status;
        let told = Status::OVERRUN | Status::SLIP_1 | Status::SLIP_4;
        assert_eq!(later.intersects(told), slips, "{instants}: {later:?}");
        assert_eq!(later.contains(told), slips, "{instants}: {later:?}");
    }
}

/// Every row beyond equations (3) and (9) costs the interrupt some 125 cycles, and 1100 whatever their number. Of the 8500 between two
/// samples equation (9) and a reading take 1800, a tooth map 2300, and the background needs 2290.
#[test]
fn a_map_that_the_interrupt_has_no_time_for_is_refused() {
    let (mut bench, _flash, _) = stored(5);
    // What was begun beside few is not put in force beside more either.
    let refusal = Reply::Refused(Refusal::MapTooDear { found: 9, most: 8 });
    for (rows, reply) in [(8, Reply::Done), (9, refusal.clone())] {
        assert_eq!(
            bench.ask(Action::take_over(with_rows(rows, 8))),
            Reply::Done
        );
        bench.run(2);
        assert_eq!(bench.ask(Action::MapBegin(a_map())), reply);
    }
    assert_eq!(bench.ask(Action::MapApply), refusal);
}

/// At 30 kHz there are 5667 cycles between two samples: all that a table has room for is too much.
#[test]
fn rows_that_the_interrupt_has_no_time_for_are_refused() {
    let settings = Settings {
        rate_hz: 30_000.0,
        ..Settings::default()
    };
    let mut bench = Bench::start_with(world(5), SharedFlash::erased(5), settings);
    assert_eq!(bench.ask(Action::take_over(with_rows(3, 7))), Reply::Done);
    bench.run(2);
    let refusal = Refusal::TooDear { found: 4, most: 3 };
    assert_eq!(
        bench.ask(Action::take_over(with_rows(4, 8))),
        Reply::Refused(refusal)
    );
    bench.run(2);
    assert_eq!(bench.mark(), Some(7), "what was in force still is");
}

/// A calibration with equation (9) and so many rows besides.
fn with_rows(rows: usize, mark: u32) -> Calibration {
    let mut terms: Vec<Term> = TermTable::equation_9().iter().copied().collect();
    let orders = [3, 5, 7, 8, 9, 10, 11, 12, 13];
    terms.extend(orders.into_iter().take(rows).map(Term::own));
    let mut calibration = marked(mark);
    calibration.model = ErrorModel::zero(TermTable::new(&terms).unwrap());
    calibration
}

/// Two fields of 4 by 4 nodes.
fn a_map() -> MapHeader {
    let grid = Grid {
        first_teeth: [0; 2],
        nodes: [4; 2],
    };
    MapHeader {
        grids: [grid; 2],
        trusted: [u32::MAX; 1].into_iter().collect(),
        ..MapHeader::default()
    }
}

#[test]
fn power_cuts_in_a_commit_leave_the_old_calibration_or_the_new_one() {
    let (mut bench, flash, _) = stored(4);
    let before = flash.0.borrow().steps();
    assert!(matches!(bench.store(2), Reply::Place(_)));
    let steps = flash.0.borrow().steps() - before;
    let mut seen = [0; 2];
    // Every byte is tried in the library's own tests; here every 20th, with the board restarted each time.
    for (cut, old) in (0..=steps).step_by(20).chain([steps]).zip(2..) {
        assert_eq!(bench.ask(Action::take_over(marked(old + 1))), Reply::Done);
        bench.run(2);
        flash.0.borrow_mut().cut_after(cut);
        let reply = bench.ask(Action::Commit {
            lose_unknown: false,
        });
        flash.0.borrow_mut().power_up();
        let world = bench.board.stop();
        bench = Bench::start(world, flash.clone());
        let mark = bench.mark().expect("one is in force");
        assert!(
            mark == old || mark == old + 1,
            "cut {cut}: {mark} after {old}"
        );
        assert_eq!(
            mark == old + 1,
            matches!(reply, Reply::Place(_)),
            "cut {cut}: {reply:?}"
        );
        seen[usize::from(mark != old)] += 1;
        // Whatever was left, the next one starts from a known mark.
        if mark == old {
            assert!(matches!(bench.store(old + 1), Reply::Place(_)), "cut {cut}");
        }
    }
    assert!(seen[0] > 10 && seen[1] > 0, "{seen:?}");
}

#[test]
fn a_flash_that_does_not_erase_is_said_and_what_is_stored_stays() {
    let (mut bench, flash, before) = stored(5);
    flash.0.borrow_mut().wear_out();
    let refusal = Reply::Refused(Refusal::Slots(SlotRefusal::Erase(1)));
    assert_eq!(bench.store(2), refusal);
    assert_eq!(
        bench.in_force(),
        InForce::Unsaved,
        "in force until the restart"
    );
    let world = bench.board.stop();
    let mut bench = Bench::start(world, flash);
    assert_eq!(bench.in_force(), before);
}

#[test]
fn both_slots_torn_is_said_and_the_board_runs() {
    let (mut bench, flash, _) = stored(6);
    bench.store(2);
    for slot in 0..2 {
        flash
            .0
            .borrow_mut()
            .force(SLOTS_START as usize + slot * 2048 + 40, &[0x5A; 8]);
    }
    let world = bench.board.stop();
    let mut bench = Bench::start(world, flash);
    assert!(bench.board.sample().status.contains(Status::UNCALIBRATED));
    let Reply::Slots(slots) = bench.ask(Action::Slots) else {
        panic!()
    };
    for slot in slots {
        assert!(matches!(slot.state, SlotContent::Refused(_)), "{slot:?}");
        assert_eq!(
            slot.state.to_string(),
            "refused: torn: its writing was cut off, or it decayed"
        );
    }
    assert!(matches!(bench.store(3), Reply::Place(_)));
}

/// Blocks that the host has read so far.
fn drain(bench: &Bench, decoder: &mut Decoder<{ telemetry::FRAME_BYTES }>) -> Vec<Block> {
    let mut bytes = [0; 1 << 14];
    let taken = bench.board.link.read_telemetry(&mut bytes);
    bytes[..taken]
        .iter()
        .filter_map(|&byte| decoder.feed::<Block>(byte)?.ok())
        .collect()
}

#[test]
fn a_host_that_stops_reading_costs_telemetry_and_nothing_else() {
    let (mut bench, _flash, _) = stored(7);
    let order = StreamOrder {
        channels: Channels::RECORDING.bits(),
        decimation: 1,
        samples: 0,
    };
    assert_eq!(bench.ask(Action::Stream(order)), Reply::Done);
    let mut decoder = Decoder::new();
    drain(&bench, &mut decoder);
    // Commands go in, nothing is read: replies fill their channel, telemetry its own.
    for _ in 0..200 {
        let status = bench.request(Action::Status);
        bench.board.link.write_commands(&status);
        bench.run(100);
    }
    let (mut samples, mut blocks) = (0, drain(&bench, &mut decoder));
    while bench.take_reply().is_some() {}
    for _ in 0..200 {
        bench.run(10);
        while bench.take_reply().is_some() {}
        blocks.extend(drain(&bench, &mut decoder));
    }
    let status = bench.status();
    assert_eq!(status.missed, 0, "no sampling instant was missed");
    assert_eq!(
        status.dropped_frames, 0,
        "and no frame on its way to the background"
    );
    assert!(status.lost_telemetry > 15_000, "{}", status.lost_telemetry);
    for pair in blocks.windows(2) {
        let [before, after] = pair else {
            unreachable!()
        };
        let (here, lost) = (before.samples().count() as u32, after.lost - before.lost);
        assert_eq!(
            after.first,
            before.first + here + lost,
            "every sample is there or counted"
        );
        samples += here;
    }
    assert!(samples > 1000, "{samples}");
}

#[test]
fn noise_half_frames_and_fuzzed_bytes_do_not_reach_the_board() {
    let (mut bench, _flash, before) = stored(8);
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let total = 1_000_000;
    let mut sent = 0;
    while sent < total {
        let request = bench.request(
            [
                Action::Restart,
                Action::RollBack,
                Action::take_over(marked(9)),
            ][index(&mut rng, 3)]
            .clone(),
        );
        let noise: Vec<u8> = match index(&mut rng, 3) {
            // Half a frame.
            0 => request[..index(&mut rng, request.len() - 1)].to_vec(),
            // One from its middle on, its end spoilt.
            1 => request[request.len() / 2..request.len() - 2].to_vec(),
            _ => (0..index(&mut rng, 4000))
                .map(|_| uniform(&mut rng, 0.0, 256.0) as u8)
                .collect(),
        };
        sent += noise.len() + 1;
        bench.send(&noise);
        bench.send(&[0]);
        while bench.take_reply().is_some() {}
    }
    bench.run(100);
    while bench.take_reply().is_some() {}
    let status = bench.status();
    assert_eq!(status.in_force, before);
    assert_eq!(status.missed, 0);
    assert!(status.link.bad() > 20, "{:?}", status.link);
    assert!(!bench.board.wants_restart());
}

#[test]
fn a_restart_under_stream_and_session_starts_from_what_is_stored() {
    let (mut bench, flash, before) = stored(9);
    let order = StreamOrder {
        channels: Channels::POSE.bits(),
        decimation: 10,
        samples: 0,
    };
    assert_eq!(bench.ask(Action::Stream(order)), Reply::Done);
    assert_eq!(bench.ask(Action::Calibrate(short())), Reply::Done);
    bench.run(30_000);
    assert_eq!(bench.ask(Action::Restart), Reply::Done);
    assert!(bench.board.wants_restart());
    let world = bench.board.stop();
    let mut bench = Bench::start(world, flash);
    assert_eq!(bench.in_force(), before);
    assert_eq!(
        bench.ask(Action::Abort),
        Reply::Refused(Refusal::NothingUnderWay)
    );
    bench.run(1000);
    assert!(
        drain(&bench, &mut Decoder::new()).is_empty(),
        "no stream until it is asked for"
    );
}

#[test]
fn a_restart_in_the_middle_of_a_motion_stops_the_courier() {
    let (mut bench, flash, _) = stored(10);
    let far = Action::GoTo {
        target: Target {
            x_m: 0.3,
            ..Target::default()
        },
        speed_m_per_s: 0.2,
    };
    assert_eq!(bench.ask(far), Reply::Done);
    bench.run(10_000);
    let world = bench.board.stop();
    let mut bench = Bench::start(world, flash);
    bench.run(20_000);
    let stopped = bench.board.world.truth().pose.x_m;
    assert!((0.01..0.25).contains(&stopped), "{stopped}");
    bench.run(2000);
    let later = bench.board.world.truth().pose.x_m;
    assert!((later - stopped).abs() < 1.0e-6, "{stopped} {later}");
}
