//! Faults at the inputs, through the converters on the wire, the driver and the signal path, to the frame's status bits.

use courier_sensor::drivers::converter::{
    Converter, ConverterError, Settings as ConverterSettings,
};
use courier_sensor::frame::{Frame, RawFrame, Status};
use courier_sensor::model::{ErrorModel, TermTable};
use courier_sensor::settings::Settings;
use courier_sensor::step::{StepConfig, StepState, step};
use hal_sim::wire::clock::Clock;
use hal_sim::wire::converter::{Busy, ConverterWire, Convst, Reset, Spi};
use hal_sim::wire::fault::{InputFault, Switch, When};

const PERIOD_NS: u64 = 50_000;

struct Board {
    clock: Clock,
    wire: ConverterWire,
    pair: Converter<Spi, Spi, Convst, Reset, Busy>,
    config: StepConfig,
    state: StepState,
    raw: RawFrame,
    fault: Switch<InputFault>,
}

/// A courier at 20 mm/s along x under a beacon, with a count or two of noise.
fn board() -> Board {
    let clock = Clock::new();
    let mut noise = 0u32;
    let wire = ConverterWire::new(clock.clone(), move |now_ns: u64| {
        let turns = now_ns as f64 * 1.0e-9 * 0.020 / 1.016e-3;
        let mut chips = [[0; 8]; 2];
        let mut dither = || {
            noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (noise >> 30) as i16 - 1
        };
        for segment in 0..4 {
            let phase = std::f64::consts::TAU * if segment % 2 == 0 { turns } else { 0.1 };
            chips[0][2 * segment] = (20_000.0 * phase.sin()) as i16 + dither();
            chips[0][2 * segment + 1] = (20_000.0 * phase.cos()) as i16 + dither();
        }
        chips[1][..4]
            .iter_mut()
            .for_each(|electrode| *electrode = 8000 + dither());
        chips
    });
    let mut pair = Converter::new(
        (wire.spi(0), wire.spi(1)),
        wire.convst(),
        wire.reset(),
        wire.busy(),
        ConverterSettings::BOARD,
    );
    pair.initialise(&mut clock.clone()).unwrap();
    let settings = Settings {
        model: Some(ErrorModel::zero(TermTable::equation_3())),
        ..Settings::default()
    };
    let (config, state) = (StepConfig::build(&settings).unwrap(), StepState::new());
    let fault = wire.input_fault();
    Board {
        clock,
        wire,
        pair,
        config,
        state,
        raw: RawFrame::default(),
        fault,
    }
}

impl Board {
    fn sample(&mut self) -> (Frame, Result<(), ConverterError>) {
        let next_ns = (self.clock.now_ns() / PERIOD_NS + 1) * PERIOD_NS;
        self.clock.advance_to_ns(next_ns);
        let result = self.pair.sample(&mut self.raw);
        (step(&self.config, &mut self.state, &self.raw), result)
    }

    /// Status bits seen in so many samples, all of which the driver read without an error.
    fn seen(&mut self, samples: usize) -> Status {
        (0..samples).fold(Status::empty(), |seen, _| {
            let (frame, result) = self.sample();
            result.unwrap();
            seen | frame.status
        })
    }
}

#[test]
fn without_a_fault_no_bit_is_set() {
    assert_eq!(board().seen(5000), Status::empty());
}

#[test]
fn each_fault_at_the_inputs_sets_its_bit() {
    let stuck = |chip, channel, counts| InputFault::Stuck {
        chip,
        channel,
        counts,
    };
    // A second's worth passes each channel's zero and peak many times.
    let cases = [
        (stuck(0, 0, 0), Status::AMPLITUDE_LOW_1),
        (stuck(0, 5, 0), Status::AMPLITUDE_LOW_3),
        (
            stuck(0, 0, i16::MAX),
            Status::CLIPPED_1 | Status::AMPLITUDE_HIGH_1,
        ),
        (stuck(0, 7, i16::MIN), Status::CLIPPED_4),
        (stuck(1, 2, i16::MAX), Status::BEACON_SATURATED),
        (InputFault::Frozen, Status::FROZEN),
        (InputFault::Off, Status::FROZEN),
    ];
    for (fault, wanted) in cases {
        let mut board = board();
        assert_eq!(board.seen(500), Status::empty());
        board.fault.set(fault, When::Always);
        let seen = board.seen(20_000);
        assert!(
            seen.contains(wanted),
            "{fault:?}: {seen:?}, wanted {wanted:?}"
        );
        assert!(board.fault.struck() >= 20_000);
    }
}

#[test]
fn one_wild_sample_sets_a_bit_and_costs_no_tooth() {
    let mut board = board();
    board.seen(500);
    let before = board.sample().0;
    board.fault.set(
        InputFault::Stuck {
            chip: 0,
            channel: 1,
            counts: i16::MIN,
        },
        When::Next(1),
    );
    assert!(
        board
            .sample()
            .0
            .status
            .intersects(Status::CLIPPED_1 | Status::SLIP_1)
    );
    let after = board.sample().0;
    let moved = after.segments[0]
        .unmodified
        .minus_turns(before.segments[0].unmodified);
    // Two periods at 20 mm/s are 0.002 turns.
    assert!((moved - 0.00197).abs() < 2.0e-4, "{moved}");
}

#[test]
fn a_supply_that_comes_and_goes_is_seen_and_recovered_from() {
    let mut board = board();
    board.seen(100);
    board.wire.with_chip(1, |chip| chip.reset());
    let (frame, result) = board.sample();
    assert!(
        matches!(result, Err(ConverterError::Chip { index: 1, .. })),
        "{result:?}"
    );
    assert!(frame.status.contains(Status::CONVERTER_CRC));
    board.fault.set(InputFault::Off, When::Always);
    let error = board.pair.initialise(&mut board.clock).unwrap_err();
    assert!(
        matches!(error, ConverterError::BusyNeverRose { .. }),
        "{error}"
    );
    board.fault.clear();
    board.pair.initialise(&mut board.clock).unwrap();
    assert!(!board.seen(100).contains(Status::CONVERTER_CRC));
}
