//! Every fault wrapper around every part: what is wrong is named, what was in force stays, nothing waits for ever.

use courier_sensor::calibration::record::{Calibration, RecordError};
use courier_sensor::calibration::slots::{SlotError, SlotState, Slots};
use courier_sensor::drivers::ad7606c::ChipError;
use courier_sensor::drivers::converter::{Converter, ConverterError, Counts, Settings};
use courier_sensor::drivers::motion::{Command, MotionPort, PortError, Reply};
use courier_sensor::frame::{RawFrame, Status};
use courier_sensor::geometry::Geometry;
use effects::motion::Pose;
use embedded_hal::spi;
use hal_sim::wire::clock::Clock;
use hal_sim::wire::converter::{Busy, ConverterWire, Convst, Reset, Spi};
use hal_sim::wire::fault::{
    FaultyFlash, FaultyPin, FaultySerial, FaultySpi, FlashFault, Level, SerialFault, SpiFault,
    Switch, When,
};
use hal_sim::wire::flash::Flash;
use hal_sim::wire::motion::{ControllerConfig, Line, MotionWire};

type Pair =
    Converter<FaultySpi<Spi>, FaultySpi<Spi>, FaultyPin<Convst>, FaultyPin<Reset>, FaultyPin<Busy>>;

struct Board {
    clock: Clock,
    wire: ConverterWire,
    pair: Pair,
    spi: [Switch<SpiFault>; 2],
    convst: Switch<Level>,
    reset: Switch<Level>,
    busy: Switch<Level>,
}

/// A board whose inputs change from sample to sample.
fn board() -> Board {
    let clock = Clock::new();
    let mut sample = 0i16;
    let wire = ConverterWire::new(clock.clone(), move |_| {
        sample = sample.wrapping_add(1);
        [[sample; 8], [8000, 8000, 8000, 8000, 0, 0, 0, 0]]
    });
    let spi = [Switch::new(1), Switch::new(2)];
    let [convst, reset, busy] = [3, 4, 5].map(Switch::new);
    let chips = (
        FaultySpi::new(wire.spi(0), spi[0].clone()),
        FaultySpi::new(wire.spi(1), spi[1].clone()),
    );
    let pair = Converter::new(
        chips,
        FaultyPin::new(wire.convst(), convst.clone()),
        FaultyPin::new(wire.reset(), reset.clone()),
        FaultyPin::new(wire.busy(), busy.clone()),
        Settings::BOARD,
    );
    Board {
        clock,
        wire,
        pair,
        spi,
        convst,
        reset,
        busy,
    }
}

fn running() -> Board {
    let mut board = board();
    board.pair.initialise(&mut board.clock).unwrap();
    board
}

#[test]
fn dead_data_lines_are_named_at_start_up_and_in_service() {
    for chip in 0..2 {
        for level in [0x00, 0xFF] {
            let index = chip as u8;
            let mut board = board();
            board.spi[chip].set(SpiFault::Stuck(level), When::Always);
            let error = board.pair.initialise(&mut board.clock).unwrap_err();
            assert_eq!(
                error,
                ConverterError::Chip {
                    index,
                    error: ChipError::Absent { level }
                }
            );
            board.spi[chip].clear();
            board.pair.initialise(&mut board.clock).unwrap();
            board.spi[chip].set(SpiFault::Stuck(level), When::Always);
            let mut raw = RawFrame::default();
            let error = board.pair.sample(&mut raw).unwrap_err();
            assert_eq!(raw.fault, Status::CONVERTER_CRC);
            match (level, error) {
                (
                    0x00,
                    ConverterError::Chip {
                        error: ChipError::Silent,
                        index: named,
                    },
                ) => assert_eq!(named, index),
                (
                    0xFF,
                    ConverterError::Chip {
                        error: ChipError::FrameCrc { .. },
                        index: named,
                    },
                ) => assert_eq!(named, index),
                other => panic!("{other:?}"),
            }
        }
    }
}

#[test]
fn a_busy_line_that_never_falls_is_given_up_after_its_bound() {
    let mut board = running();
    board.busy.set(Level(true), When::Always);
    let before = (board.busy.struck(), board.clock.now_ns());
    let error = board.pair.convert(&mut Counts::default()).unwrap_err();
    let polls = Settings::BOARD.busy_polls;
    assert_eq!(error, ConverterError::BusyStuck { polls });
    assert_eq!(error.status(), Status::CONVERTER_TIMEOUT);
    assert_eq!(board.busy.struck() - before.0, u64::from(polls));
    assert!(
        board.clock.now_ns() - before.1 < 110_000,
        "two periods at 20 kHz, and some"
    );
    board.busy.clear();
    board.pair.convert(&mut Counts::default()).unwrap();
}

#[test]
fn lines_that_do_not_move_are_found_at_start_up() {
    let mut with_busy_low = board();
    with_busy_low.busy.set(Level(false), When::Always);
    let error = with_busy_low
        .pair
        .initialise(&mut with_busy_low.clock)
        .unwrap_err();
    assert!(
        matches!(error, ConverterError::BusyNeverRose { .. }),
        "{error}"
    );
    let mut without_convst = board();
    without_convst.convst.set(Level(false), When::Always);
    let error = without_convst
        .pair
        .initialise(&mut without_convst.clock)
        .unwrap_err();
    assert!(
        matches!(error, ConverterError::BusyNeverRose { .. }),
        "{error}"
    );
    // Without RESET a chip that runs already keeps its CRC on and does not understand a start-up.
    let mut without_reset = running();
    without_reset.reset.set(Level(false), When::Always);
    let error = without_reset
        .pair
        .initialise(&mut without_reset.clock)
        .unwrap_err();
    assert!(
        matches!(error, ConverterError::Chip { index: 0, .. }),
        "{error}"
    );
}

#[test]
fn bit_errors_on_the_bus_never_pass_as_counts() {
    let mut board = running();
    board
        .spi
        .iter()
        .for_each(|switch| switch.set(SpiFault::Flips(2.0e-3), When::Always));
    let (mut good, mut bad) = (0, 0);
    let mut counts = Counts::default();
    for _ in 0..20_000 {
        match board.pair.convert(&mut counts) {
            Ok(()) => {
                good += 1;
                assert!(
                    counts[0].iter().all(|count| *count == counts[0][0]),
                    "{counts:?}"
                );
            }
            Err(ConverterError::Chip {
                error: ChipError::FrameCrc { .. },
                ..
            }) => bad += 1,
            Err(other) => panic!("{other}"),
        }
    }
    // 288 bits at 2e-3 each: 43.8 % of the readings hold an error; standard error 0.35 %.
    assert!(
        (0.425..0.451).contains(&(f64::from(bad) / 20_000.0)),
        "{good} good, {bad} bad"
    );
}

#[test]
fn a_bus_with_errors_configures_a_chip_rightly_or_not_at_all() {
    let mut board = board();
    let (mut started, mut refused) = (0, 0);
    for _ in 0..300 {
        board
            .spi
            .iter()
            .for_each(|switch| switch.set(SpiFault::Flips(1.0e-3), When::Always));
        let result = board.pair.initialise(&mut board.clock);
        board.spi.iter().for_each(Switch::clear);
        match result {
            Ok(()) => {
                started += 1;
                let mut counts = Counts::default();
                board.pair.convert(&mut counts).unwrap();
                assert_eq!(
                    counts[1],
                    [8000, 8000, 8000, 8000, 0, 0, 0, 64],
                    "range, offsets, data lines"
                );
            }
            Err(ConverterError::Chip { .. }) => refused += 1,
            Err(other) => panic!("{other}"),
        }
    }
    assert!(started > 0 && refused > 0, "{started} {refused}");
}

#[test]
fn a_frozen_reply_holds_its_crc_and_repeats_its_counts() {
    let mut board = running();
    let (mut first, mut second) = (Counts::default(), Counts::default());
    board.pair.convert(&mut first).unwrap();
    board.spi[0].set(SpiFault::Frozen, When::Always);
    board.pair.convert(&mut second).unwrap();
    assert_eq!(first[0], second[0], "what the step's FROZEN bit is for");
    board.spi[0].set(SpiFault::Bus, When::Next(1));
    let error = board.pair.convert(&mut second).unwrap_err();
    assert_eq!(
        error,
        ConverterError::Chip {
            index: 0,
            error: ChipError::Bus(spi::ErrorKind::Other)
        }
    );
}

#[test]
fn an_intermittent_fault_spoils_single_frames_only() {
    let mut board = running();
    board.spi[1].set(SpiFault::Stuck(0xFF), When::Sometimes(0.01));
    let mut raw = RawFrame::default();
    let bad = (0..10_000)
        .filter(|_| board.pair.sample(&mut raw).is_err())
        .count() as u64;
    assert_eq!(bad, board.spi[1].struck());
    assert!((60..140).contains(&bad), "{bad}");
}

fn motion() -> (Clock, Switch<SerialFault>, MotionPort<FaultySerial<Line>>) {
    let clock = Clock::new();
    let wire = MotionWire::new(clock.clone(), ControllerConfig::TYPICAL, Pose::default(), 1);
    let switch = Switch::new(9);
    let port = MotionPort::new(FaultySerial::new(wire.line(), switch.clone()));
    (clock, switch, port)
}

fn ask(
    clock: &Clock,
    port: &mut MotionPort<FaultySerial<Line>>,
) -> Result<Option<Reply>, PortError> {
    port.send(Command::WhereAreYou)?;
    for _ in 0..100 {
        clock.advance_ns(50_000);
        if let Some(reply) = port.poll()? {
            return Ok(Some(reply));
        }
    }
    Ok(None)
}

#[test]
fn a_bad_motion_line_loses_replies_and_invents_none() {
    let faults = [
        SerialFault::Flips(0.1),
        SerialFault::Dropped,
        SerialFault::Noise,
    ];
    for fault in faults {
        let (clock, switch, mut port) = motion();
        switch.set(fault, When::Sometimes(0.02));
        let replies = (0..1000).filter_map(|_| ask(&clock, &mut port).unwrap());
        let good = replies
            .inspect(|reply| assert!(matches!(reply, Reply::State { .. })))
            .count();
        assert!((100..990).contains(&good), "{fault:?}: {good} of 1000");
        switch.clear();
        ask(&clock, &mut port).unwrap();
        assert!(
            ask(&clock, &mut port).unwrap().is_some(),
            "{fault:?}: as before afterwards"
        );
    }
    let (clock, switch, mut port) = motion();
    switch.set(SerialFault::Line, When::Next(1));
    assert!(matches!(ask(&clock, &mut port), Err(PortError::Line(_))));
}

fn calibration(uptime_s: u32) -> Calibration {
    let mut calibration = Calibration::identity(Geometry::PAPER);
    calibration.made.uptime_s = uptime_s;
    calibration
}

#[test]
fn a_flash_at_fault_leaves_what_was_in_force() {
    let faults = [
        (FlashFault::EraseFails, "erase"),
        (FlashFault::EraseLies, "take data"),
        (FlashFault::WriteFails(0), "take data"),
        (FlashFault::WriteFails(64), "take data"),
    ];
    for (fault, wanted) in faults {
        let switch = Switch::new(1);
        let mut slots = Slots::new(FaultyFlash::new(Flash::new(2, 1), switch.clone()), 0);
        slots.commit(&calibration(1), false).unwrap();
        slots.commit(&calibration(2), false).unwrap();
        switch.set(fault, When::Always);
        let error = slots.commit(&calibration(3), false).unwrap_err();
        assert!(error.to_string().contains(wanted), "{fault:?}: {error}");
        assert_eq!(slots.load().unwrap().1, calibration(2), "{fault:?}");
        switch.clear();
        assert_eq!(slots.load().unwrap().1, calibration(2), "{fault:?}");
        slots.commit(&calibration(4), false).unwrap();
        assert_eq!(slots.load().unwrap().1, calibration(4), "{fault:?}");
    }
}

#[test]
fn a_flash_that_lies_is_found_out_by_reading_back() {
    let switch = Switch::new(1);
    let mut slots = Slots::new(FaultyFlash::new(Flash::new(2, 1), switch.clone()), 0);
    slots.commit(&calibration(1), false).unwrap();
    switch.set(FlashFault::WriteLies, When::Always);
    assert_eq!(
        slots.commit(&calibration(2), false),
        Err(SlotError::ReadBack { slot: 1 })
    );
    assert_eq!(slots.load().unwrap().1, calibration(1));
    switch.clear();
    slots.commit(&calibration(2), false).unwrap();
    switch.set(FlashFault::WriteLies, When::Always);
    assert_eq!(slots.roll_back(), Err(SlotError::ReadBack { slot: 1 }));
    assert_eq!(slots.load().unwrap().1, calibration(2));
}

#[test]
fn a_flash_that_does_not_read_is_said_and_never_guessed() {
    let switch = Switch::new(1);
    let mut slots = Slots::new(FaultyFlash::new(Flash::new(2, 1), switch.clone()), 0);
    slots.commit(&calibration(1), false).unwrap();
    switch.set(FlashFault::ReadFails, When::Always);
    assert_eq!(slots.load(), Err(SlotError::NoneInForce));
    assert_eq!(
        slots.list()[0].state,
        SlotState::Refused(RecordError::Unreadable)
    );
    switch.set(FlashFault::ReadFlips(1.0e-2), When::Always);
    assert_eq!(slots.load(), Err(SlotError::NoneInForce));
    switch.clear();
    assert_eq!(slots.load().unwrap().1, calibration(1));
}

/// Samples until the first good one, at most a second's.
fn back_in_service(board: &mut Board) -> Option<usize> {
    (0..20_000).find(|_| board.pair.convert(&mut Counts::default()).is_ok())
}

#[test]
fn a_chip_that_forgot_its_settings_is_set_again_in_service() {
    for chip in 0..2 {
        let mut board = running();
        board.wire.with_chip(chip, |chip| chip.reset());
        let mut longest_ns = 0;
        let mut bad = 0;
        let mut counts = Counts::default();
        loop {
            let before_ns = board.clock.now_ns();
            let result = board.pair.convert(&mut counts);
            longest_ns = longest_ns.max(board.clock.now_ns() - before_ns);
            match result {
                Ok(()) => break,
                Err(ConverterError::Chip { index, .. }) => assert_eq!(usize::from(index), chip),
                Err(other) => panic!("{other}"),
            }
            bad += 1;
            assert!(bad < 200, "chip {chip}");
        }
        assert!(
            longest_ns < 20_000,
            "no instant may cost more than its share: {longest_ns} ns"
        );
        assert!((20..120).contains(&bad), "chip {chip}: {bad} samples lost");
        board.pair.convert(&mut counts).unwrap();
        assert_eq!(
            counts[1],
            [8000, 8000, 8000, 8000, 0, 0, 0, 64],
            "set as before"
        );
    }
}

#[test]
fn converters_that_stay_away_are_tried_again_and_again() {
    let mut board = running();
    board.spi[1].set(SpiFault::Stuck(0xFF), When::Always);
    board.busy.set(Level(true), When::Next(5000));
    assert_eq!(back_in_service(&mut board), None);
    board.spi[1].clear();
    let lost = back_in_service(&mut board).unwrap();
    assert!(lost < 1200, "{lost} samples after the line came back");
}

#[test]
fn a_silent_busy_line_is_a_failure_like_any_other() {
    let mut board = running();
    let mut last = None;
    for _ in 0..150 {
        last = Some(board.pair.silent());
    }
    assert_eq!(last, Some(ConverterError::BusyStuck { polls: 0 }));
    assert!(back_in_service(&mut board).unwrap() < 120);
}

#[test]
fn single_failures_never_reset_the_chips() {
    let mut board = running();
    board.spi[0].set(SpiFault::Stuck(0xFF), When::Sometimes(0.3));
    for _ in 0..20_000 {
        let _ = board.pair.convert(&mut Counts::default());
    }
    board.wire.with_chip(0, |chip| {
        assert_eq!(chip.resets, 2, "power-up and start-up")
    });
}
