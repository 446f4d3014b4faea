//! The converters' bus and lines.

use courier_sensor::drivers::ad7606c::ChipError;
use courier_sensor::drivers::converter::{Converter, ConverterError, Counts, Settings};
use courier_sensor::frame::{RawFrame, Status};
use embedded_hal::spi;
use hal_sim::wire::clock::Clock;
use hal_sim::wire::converter::{Busy, ConverterWire, Convst, Reset, Spi};
use hal_sim::wire::fault::{FaultyPin, FaultySpi, Level, SpiFault, Switch, When};

pub type Pair =
    Converter<FaultySpi<Spi>, FaultySpi<Spi>, FaultyPin<Convst>, FaultyPin<Reset>, FaultyPin<Busy>>;

pub struct Board {
    pub clock: Clock,
    pub wire: ConverterWire,
    pub pair: Pair,
    pub spi: [Switch<SpiFault>; 2],
    convst: Switch<Level>,
    reset: Switch<Level>,
    pub busy: Switch<Level>,
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

/// A board after start-up.
pub fn running() -> Board {
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

/// The self-test converts sixteenfold; chips that were left so would give good-looking frames, late ones.
#[test]
fn chips_whose_self_test_failed_are_set_anew_before_their_readings_count() {
    let mut board = board();
    board.busy.set(Level(false), When::Always);
    board.pair.initialise(&mut board.clock).unwrap_err();
    board.busy.clear();
    let mut counts = Counts::default();
    let failed = (0..200)
        .take_while(|_| board.pair.convert(&mut counts).is_err())
        .count();
    assert!((1..200).contains(&failed), "{failed} readings failed");
    board.pair.start().unwrap();
    let started_ns = board.clock.now_ns();
    while board.pair.is_busy().unwrap() {}
    let took_ns = board.clock.now_ns() - started_ns;
    assert!(took_ns < 2_000, "a conversion takes {took_ns} ns");
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
