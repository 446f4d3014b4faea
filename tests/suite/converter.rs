//! The converter driver against the simulated chips, bit for bit.

use courier_sensor::drivers::ad7606c::{ChipError, Oversampling, Range, Script};
use courier_sensor::drivers::converter::{
    Converter, ConverterError, Counts, Settings, WITNESS_COUNTS, scripts,
};
use courier_sensor::frame::{RawFrame, Status};
use hal_sim::wire::clock::Clock;
use hal_sim::wire::converter::{Busy, ConverterWire, Convst, Reset, Spi};

type Pair = Converter<Spi, Spi, Convst, Reset, Busy>;

const QUADRATURE: [i16; 8] = [20000, -20000, 1, -1, i16::MAX, i16::MIN, 256, -256];
const ELECTRODES: [i16; 8] = [8000, 7000, 6000, 5000, 3, -3, 0, 0];

fn board(settings: Settings) -> (Clock, ConverterWire, Pair) {
    let clock = Clock::new();
    let wire = ConverterWire::new(clock.clone(), |_| [QUADRATURE, ELECTRODES]);
    let pair = Converter::new(
        (wire.spi(0), wire.spi(1)),
        wire.convst(),
        wire.reset(),
        wire.busy(),
        settings,
    );
    (clock, wire, pair)
}

#[test]
fn reads_what_stands_at_the_inputs() {
    let (mut clock, wire, mut pair) = board(Settings::BOARD);
    pair.initialise(&mut clock).unwrap();
    let before = wire.conversions();
    let mut raw = RawFrame::default();
    pair.sample(&mut raw).unwrap();
    assert_eq!(wire.conversions(), before + 1);
    assert_eq!(
        raw.quadrature_counts,
        [[20000, -20000], [1, -1], [i16::MAX, i16::MIN], [256, -256]]
    );
    assert_eq!(raw.electrode_counts, [8000, 7000, 6000, 5000]);
    assert_eq!(raw.fault, Status::empty());
    let mut counts = Counts::default();
    pair.convert(&mut counts).unwrap();
    assert_eq!(counts[1][7], i16::from(WITNESS_COUNTS));
}

#[test]
fn range_and_oversampling_reach_the_chips() {
    static SCRIPTS: [Script; 2] = scripts(Range::Bipolar10V, Oversampling::X8);
    let settings = Settings {
        scripts: &SCRIPTS,
        oversampling: Oversampling::X8,
        ..Settings::BOARD
    };
    let (mut clock, wire, mut pair) = board(settings);
    pair.initialise(&mut clock).unwrap();
    let mut counts = Counts::default();
    pair.start().unwrap();
    let started_ns = clock.now_ns();
    while pair.is_busy().unwrap() {}
    let took_us = (clock.now_ns() - started_ns) as f64 * 1e-3;
    assert!(
        (9.0..10.0).contains(&took_us),
        "eightfold oversampling takes {took_us} us"
    );
    pair.read(&mut counts).unwrap();
    assert_eq!(counts[0][0], 10000, "half the counts at twice the range");
    assert_eq!(counts[1][0], 4000);
    wire.with_chip(0, |chip| assert_eq!(chip.early_edges, 0));
}

#[test]
fn one_sample_fits_its_period() {
    let (mut clock, _wire, mut pair) = board(Settings::BOARD);
    pair.initialise(&mut clock).unwrap();
    let started_ns = clock.now_ns();
    pair.sample(&mut RawFrame::default()).unwrap();
    let took_us = (clock.now_ns() - started_ns) as f64 * 1e-3;
    // 288 clocks at 21.25 MHz are 13.6 us, one conversion at most 1 us.
    assert!((13.6..16.0).contains(&took_us), "{took_us} us");
}

#[test]
fn another_chip_is_refused_by_name() {
    for (index, id) in [(0, 0x14), (1, 0x14)] {
        let (mut clock, wire, mut pair) = board(Settings::BOARD);
        wire.with_chip(usize::from(index), |chip| {
            *chip = hal_sim::wire::ad7606c::Ad7606c::new(id)
        });
        let error = pair.initialise(&mut clock).unwrap_err();
        assert_eq!(
            error,
            ConverterError::Chip {
                index,
                error: ChipError::WrongId { id }
            }
        );
    }
}

#[test]
fn hardware_mode_wiring_is_told_at_once() {
    let (mut clock, wire, mut pair) = board(Settings::BOARD);
    wire.with_chip(1, |chip| chip.wire_hardware_mode());
    let error = pair.initialise(&mut clock).unwrap_err();
    assert!(
        matches!(error, ConverterError::Chip { index: 1, .. }),
        "{error}"
    );
}

#[test]
fn a_chip_that_lost_its_supply_is_noticed_and_set_again() {
    let (mut clock, wire, mut pair) = board(Settings::BOARD);
    pair.initialise(&mut clock).unwrap();
    let mut raw = RawFrame::default();
    pair.sample(&mut raw).unwrap();
    let kept = raw;
    wire.with_chip(0, |chip| chip.reset());
    let error = pair.sample(&mut raw).unwrap_err();
    assert!(
        matches!(
            error,
            ConverterError::Chip {
                index: 0,
                error: ChipError::FrameCrc { .. }
            }
        ),
        "{error}"
    );
    assert_eq!(raw.fault, Status::CONVERTER_CRC);
    assert_eq!(
        raw.quadrature_counts, kept.quadrature_counts,
        "the previous counts stand in"
    );
    pair.initialise(&mut clock).unwrap();
    pair.sample(&mut raw).unwrap();
    assert_eq!(raw, kept);
}
