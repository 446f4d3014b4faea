//! One encoder on any board with an SPI: a converter of two channels, the signal path, and what the encoder learns of itself.
//!
//! All but `main` is `no_std` and is for any chip whose crate implements `embedded-hal` (`rp235x-hal`, `embassy-rp`, `embassy-stm32`). `main` runs it here, on a converter that is made up.

use courier_signal::encoder::{
    Encoder, EncoderConfig, Harmonics, Learner, Reading, TurnLearner, TurnTable,
};
use courier_signal::lsq::packed_len;
use courier_signal::quadrature::PairCorrection;
use embedded_hal::spi::{ErrorType, Operation, SpiDevice};

/// An MCP3202 (12 bits, two channels): Microchip's data sheet DS21034, section 6.1.
struct Converter<S>(S);

impl<S: SpiDevice> Converter<S> {
    /// Start bit; single-ended, channel, most significant bit first; counts about zero.
    fn channel(&mut self, channel: u8) -> Result<i16, S::Error> {
        let mut bytes = [0x01, 0xA0 | channel << 6, 0x00];
        self.0.transfer_in_place(&mut bytes)?;
        Ok(i16::from_be_bytes([bytes[1] & 0x0F, bytes[2]]) - 2048)
    }

    fn sample(&mut self) -> Result<[i16; 2], S::Error> {
        Ok([self.channel(0)?, self.channel(1)?])
    }
}

/// Periods of a turn of this shaft, and where one begins: as its index gives it, or any place for want of one.
const PERIODS: u32 = 8;
const TURN_START: i32 = 0;
/// Unknowns of 24 orders of the turn, three of the period: those of a stretch's motion, and two each.
const UNKNOWNS: usize = courier_signal::encoder::TURN_DRIFT + 2 * 24;

/// What lives in the interrupt, and what below it.
struct Shaft<S> {
    converter: Converter<S>,
    encoder: Encoder,
    /// Sixteen entries for each wave of the highest order.
    table: Option<TurnTable<384>>,
    learner: Learner,
    turns: TurnLearner<UNKNOWNS, { packed_len(UNKNOWNS) }>,
    pair: PairCorrection,
}

fn config(pair: &PairCorrection, harmonics: &Harmonics) -> Option<EncoderConfig> {
    // The largest step from the foretold phase at which periods are counted, turns, and the newest step's share in the speed.
    EncoderConfig::new(pair, harmonics, 0.2, 0.25).ok()
}

impl<S: SpiDevice> Shaft<S> {
    fn new(spi: S) -> Option<Self> {
        let pair = PairCorrection::default();
        Some(Self {
            converter: Converter(spi),
            encoder: Encoder::new(config(&pair, &Harmonics::default())?),
            table: None,
            learner: Learner::new(),
            turns: TurnLearner::new(PERIODS),
            pair,
        })
    }

    /// From a timer's interrupt.
    fn sample(&mut self) -> Result<Reading, S::Error> {
        Ok(self.encoder.step(self.converter.sample()?))
    }

    /// The same: the place since the start, periods.
    fn place(&self, reading: &Reading) -> f64 {
        let table = self.table.as_ref();
        let of_turn = table.map_or(0.0, |table| table.at(reading, TURN_START));
        f64::from(reading.periods) + f64::from(reading.calibrated_turns + of_turn)
    }

    /// In the background.
    fn learn(&mut self, reading: &Reading) {
        self.learner.enter(reading);
        self.turns.enter(reading, TURN_START);
    }

    /// While the shaft is spun: first the circle, a few times.
    fn make_round(&mut self) -> Option<()> {
        self.pair = self.learner.circle.solve().ok()?.correction(&self.pair);
        self.encoder
            .configure(config(&self.pair, &Harmonics::default())?);
        self.learner = Learner::new();
        Some(())
    }

    /// Then the angle.
    fn straighten(&mut self) -> Option<()> {
        let learned = self.learner.solve().ok()?;
        self.encoder
            .configure(config(&self.pair, &learned.harmonics)?);
        self.turns = TurnLearner::new(PERIODS);
        Some(())
    }

    /// Then what differs from period to period.
    fn follow_turn(&mut self) -> Option<()> {
        self.table = Some(TurnTable::new(&self.turns.solve().ok()?));
        Some(())
    }
}

/// A converter that answers for a shaft which turns evenly, with offsets, unequal gains, and a ring that is not centred.
struct MadeUp {
    reads: u32,
}

impl ErrorType for MadeUp {
    type Error = core::convert::Infallible;
}

impl SpiDevice for MadeUp {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Self::Error> {
        let place = place(self.reads / 2);
        let eccentric = 0.01 * (std::f64::consts::TAU * place / f64::from(PERIODS)).sin();
        let phase = std::f64::consts::TAU * (place + eccentric);
        let counts = [1_500.0 * phase.sin() + 80.0, 1_560.0 * phase.cos() - 40.0];
        for operation in operations {
            if let Operation::TransferInPlace([_, high, low]) = operation {
                let channel = usize::from(*high >> 6 & 1);
                let count = counts[channel].round() as i16 + 2048;
                [*high, *low] = count.to_be_bytes();
            }
        }
        self.reads += 1;
        Ok(())
    }
}

/// Where the shaft is at a sample, periods.
fn place(sample: u32) -> f64 {
    f64::from(sample) / 199.3
}

/// Turns for some periods; the largest error from one sample to all others, periods.
fn turn(shaft: &mut Shaft<MadeUp>, periods: u32) -> f64 {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for _ in 0..200 * periods {
        let truth = place(shaft.converter.0.reads / 2);
        let Ok(reading) = shaft.sample();
        shaft.learn(&reading);
        let error = shaft.place(&reading) - truth;
        (low, high) = (low.min(error), high.max(error));
    }
    high - low
}

fn main() {
    let mut shaft = Shaft::new(MadeUp { reads: 0 }).expect("constants in range");
    let before = turn(&mut shaft, 20);
    for _ in 0..4 {
        shaft.make_round().expect("a whole period");
        turn(&mut shaft, 20);
    }
    shaft.straighten().expect("ten stretches");
    let straight = turn(&mut shaft, 40);
    shaft.follow_turn().expect("more than two turns");
    let after = turn(&mut shaft, 20);
    println!("errors from {before:.5} to {straight:.5} and {after:.5} periods, peak to peak");
    // Half a count of each channel of 1,500, either way: 0.71 / 1,500 radians. Besides what the eccentricity does to orders 4 to 8 of the period.
    let rounding = 2.0 * 0.71 / 1_500.0 / std::f64::consts::TAU;
    assert!(before > 0.03 && straight > 0.02 && after < rounding + 1.0e-4);
}
