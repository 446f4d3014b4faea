//! What a board says of itself: whose a calibration is, and how its self-test went.

use crate::bench::{Bench, marked, world};
use courier_sensor::device::Device;
use courier_sensor::drivers::motion::Target;
use courier_sensor::frame::Status;
use courier_sensor::health::{Trouble, troubles};
use courier_sensor::link::message::{
    Action, ConverterFault, ConverterTest, InForce, RecordRefusal, Refusal, Reply, SlotContent,
    SlotRefusal,
};
use effects::motion::Motion;
use hal_sim::board::SharedFlash;
use hal_sim::wire::ad7606c::Ad7606c;
use hal_sim::world::World;

/// A calibration that another board made.
fn of_another(mark: u32) -> courier_sensor::calibration::record::Calibration {
    let mut calibration = marked(mark);
    calibration.device = OTHER;
    calibration
}

const OTHER: Device = Device(*b"other-000001");

/// A world whose board is the other one.
fn other_world() -> World {
    let mut world = world(2);
    world.number = OTHER;
    world
}

#[test]
fn a_calibration_of_another_board_is_taken_over_by_order_alone() {
    let flash = SharedFlash::erased(1);
    let mut bench = Bench::start(world(1), flash.clone());
    let refusal = Refusal::Calibration(RecordRefusal::OtherDevice(OTHER));
    let load = Action::load(of_another(1));
    assert_eq!(bench.ask(load), Reply::Refused(refusal));
    assert_eq!(bench.in_force(), InForce::None);
    assert_eq!(bench.ask(Action::take_over(of_another(1))), Reply::Done);
    bench.run(2);
    let commit = Action::Commit {
        lose_unknown: false,
    };
    assert!(matches!(bench.ask(commit), Reply::Place(_)));
    // It is this board's now, over a restart too.
    let world = bench.board.stop();
    let own = world.number;
    let mut bench = Bench::start(world, flash);
    assert_eq!(bench.mark(), Some(1));
    assert_eq!(bench.board.background.keeper().device(), own);
    assert_eq!(bench.status().boot, None);
}

#[test]
fn a_slot_that_another_board_wrote_is_refused_at_the_start_and_the_own_one_counts() {
    let flash = SharedFlash::erased(1);
    let mut bench = Bench::start(world(1), flash.clone());
    assert!(matches!(bench.store(1), Reply::Place(_)));
    let first = bench.board.background.keeper().device();
    // The same flash under another board's number.
    let mut bench = Bench::start(other_world(), flash.clone());
    let other = RecordRefusal::OtherDevice(first);
    let status = bench.status();
    assert_eq!(status.in_force, InForce::None);
    assert_eq!(
        status.boot,
        Some(Refusal::Slots(SlotRefusal::Record(other)))
    );
    let Reply::Slots([slot, _]) = bench.ask(Action::Slots) else {
        panic!("wanted both slots")
    };
    assert_eq!(slot.state, SlotContent::Refused(other));
    // What it stores counts on from the other's number, and is what comes in force.
    let Reply::Place(place) = bench.store(2) else {
        panic!("wanted it stored")
    };
    assert_eq!(place.sequence, 2);
    let mut bench = Bench::start(other_world(), flash.clone());
    assert_eq!((bench.mark(), bench.status().boot), (Some(2), None));
    let mut bench = Bench::start(world(1), flash);
    assert_eq!((bench.mark(), bench.status().boot), (Some(1), None));
}

#[test]
fn a_failed_self_test_of_the_converters_stays_until_one_passes() {
    let flash = SharedFlash::erased(1);
    let courier = world(1);
    // Strapped to hardware mode: its registers do not answer until it is wired right.
    courier
        .converter
        .with_chip(1, |chip| chip.wire_hardware_mode());
    let mut bench = Bench::start(courier, flash.clone());
    let failed = ConverterTest::Failed(ConverterFault::Chip(1));
    bench.run(2000);
    let status = bench.status();
    assert_eq!(status.health.converters, failed);
    let found = troubles(&status.health);
    assert_eq!(found[..], [Trouble::Converters(ConverterFault::Chip(1))]);
    let mut bench = Bench::start(world(1), flash);
    assert_eq!(bench.status().health.converters, ConverterTest::Passed);
}

/// The review's fault 7: good frames after a failed self-test did not say that it had failed.
#[test]
fn good_frames_after_a_failed_self_test_do_not_hide_it() {
    let courier = world(1);
    let converter = courier.converter.clone();
    // A chip that does not name itself as it should, and is replaced by one that does.
    converter.with_chip(1, |chip| *chip = Ad7606c::new(0));
    let mut bench = Bench::start(courier, SharedFlash::erased(1));
    converter.with_chip(1, |chip| *chip = Ad7606c::default());
    bench.run(2000);
    bench.status();
    bench.run(100);
    let status = bench.status();
    let trouble = Status::CONVERTER_CRC | Status::CONVERTER_TIMEOUT;
    assert_eq!(status.status & trouble.bits(), 0, "frames are good");
    let failed = ConverterTest::Failed(ConverterFault::Chip(1));
    assert_eq!(status.health.converters, failed);
}

/// The review's fault 11: what a board set in motion does not outlive its work.
#[test]
fn a_board_that_stops_working_leaves_the_courier_at_rest() {
    let mut bench = Bench::start(world(10), SharedFlash::erased(10));
    let far = Action::GoTo {
        target: Target {
            x_m: 0.3,
            ..Target::default()
        },
        speed_m_per_s: 0.2,
    };
    assert_eq!(bench.ask(far), Reply::Done);
    bench.run(10_000);
    // Nothing of the board runs for a second; the courier's own time goes on.
    let world = &bench.board.world;
    world.clock.advance_ns(1_000_000_000);
    let place = || world.motion.motion().pose(world.clock.now_s()).x_m;
    let stopped = place();
    assert!((0.005..0.25).contains(&stopped), "{stopped}");
    world.clock.advance_ns(500_000_000);
    assert!((place() - stopped).abs() < 1.0e-6, "{stopped} {}", place());
}
