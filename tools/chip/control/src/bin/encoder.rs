//! One encoder at an STM32's own converter by embassy: sine at PA0, cosine at PA1. Compiled with the control, since that builds embassy's
//! drivers anyway; it is an example and is not run (docs/encoder.md).
#![no_std]
#![no_main]

use courier_signal::encoder::{Encoder, EncoderConfig, Harmonics, Learner};
use courier_signal::quadrature::PairCorrection;
use embassy_stm32::adc::{Adc, AdcConfig, SampleTime};
use panic_halt as _;

/// Readings between two looks at what was learned.
const READINGS: u32 = 100_000;

#[cortex_m_rt::entry]
fn main() -> ! {
    let chip = embassy_stm32::init(embassy_stm32::Config::default());
    let mut converter = Adc::new(chip.ADC1, AdcConfig::default());
    let (mut sine, mut cosine) = (chip.PA0, chip.PA1);
    let mut pair = PairCorrection::default();
    let none = Harmonics::default();
    let Ok(config) = EncoderConfig::new(&pair, &none, 0.2, 0.25) else {
        loop {}
    };
    let mut encoder = Encoder::new(config);
    let mut learner = Learner::new();
    loop {
        for _ in 0..READINGS {
            // Twelve bits about half the supply.
            let mut counts = [
                converter.blocking_read(&mut sine, SampleTime::CYCLES24_5),
                converter.blocking_read(&mut cosine, SampleTime::CYCLES24_5),
            ];
            counts.iter_mut().for_each(|count| *count &= 0x0FFF);
            let reading = encoder.step(counts.map(|count| count as i16 - 2048));
            learner.enter(&reading);
        }
        // While the shaft is spun: the circle first, and the angle's orders once that is round.
        let (round, learned) = (learner.circle.solve(), learner.solve());
        let mut harmonics = none;
        if let Ok(round) = round {
            let corrected = round.correction(&pair);
            let moved = [0, 1].map(|k| corrected.offset_counts[k] - pair.offset_counts[k]);
            if let (true, Ok(learned)) = (moved.iter().all(|moved| moved.abs() < 1.0), learned) {
                harmonics = learned.harmonics;
            }
            pair = corrected;
        }
        if let Ok(config) = EncoderConfig::new(&pair, &harmonics, 0.2, 0.25) {
            encoder.configure(config);
        }
        learner = Learner::new();
    }
}
