//! One pair's signal path: counts to a count of periods and a calibrated phase.

use super::harmonics::Harmonics;
use crate::lanes::Lanes;
use crate::math::{Constants, OCTANTS, Octants};
use crate::model::Unit;
use crate::quadrature::{CompiledPair, CounterLimits, Counters, PairCorrection, interpolate};
use crate::range::{OutOfRange, within};

/// What a sample is computed with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EncoderConfig {
    pair: CompiledPair,
    harmonics: Harmonics,
    limits: CounterLimits,
    constants: Constants,
    octants: Octants,
}

impl EncoderConfig {
    /// Checks the numbers and converts them.
    ///
    /// `slip_turns` (0.01 to 0.499) is the largest step from the phase that the speed foretells at which the count of periods is sure;
    /// `speed_filter` (above 0, at most 1) the share of the newest step in the speed.
    ///
    /// # Errors
    /// The first number that is out of range. Harmonics must not add up to more than half a turn.
    pub fn new(
        pair: &PairCorrection,
        harmonics: &Harmonics,
        slip_turns: f32,
        speed_filter: f32,
    ) -> Result<Self, OutOfRange> {
        pair.validate()?;
        within("harmonics", harmonics.bound_turns(), 0.0, 0.5)?;
        within("slip_turns", slip_turns, 0.01, 0.499)?;
        within("speed_filter", speed_filter, 1.0e-4, 1.0)?;
        Ok(Self {
            pair: PairCorrection::compile([pair, pair]),
            harmonics: *harmonics,
            limits: CounterLimits {
                slip: slip_turns,
                // Of the sum of both lanes, which are the same.
                speed_filter: 0.5 * speed_filter,
            },
            constants: Constants::VALUES,
            octants: OCTANTS,
        })
    }
}

/// One sample of one pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// Sine and cosine of the phase, the pair's correction applied.
    pub phase: Unit,
    /// Distance from the circle's centre, counts of the sine channel.
    pub amplitude_counts: f32,
    /// Whole periods gone by since the first sample.
    pub periods: i32,
    /// Phase within them before harmonics are added, -0.5 to 0.5.
    pub unmodified_turns: f32,
    /// The same with the harmonics' sum.
    pub calibrated_turns: f32,
    /// The count of periods is not sure: the step was too large.
    pub slipped: bool,
}

impl Reading {
    /// The whole place next to this one: taken as the shaft passes an index, it is where a turn begins.
    #[must_use]
    pub fn nearest_zero(&self) -> i32 {
        let further =
            i32::from(self.calibrated_turns > 0.5) - i32::from(self.calibrated_turns < -0.5);
        self.periods.wrapping_add(further)
    }

    /// Part of a turn of `periods` (1 to 2^24) that has gone by since the whole place `turn_start`, -0.5 / `periods` to 1.
    #[must_use]
    pub fn of_turn(&self, periods: u32, turn_start: i32) -> f32 {
        let periods = periods.clamp(1, 1 << 24) as i32;
        let whole = self.periods.wrapping_sub(turn_start).rem_euclid(periods);
        (whole as f32 + self.calibrated_turns) / periods as f32
    }
}

/// The signal path of one pair, and how far it has counted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Encoder {
    config: EncoderConfig,
    turns: f32,
    periods: i32,
    /// Filtered, turns a sample.
    speed_turns: f32,
    /// Of the first sample, then the configuration's.
    limits: CounterLimits,
}

impl Encoder {
    /// Before the first sample.
    #[must_use]
    pub const fn new(config: EncoderConfig) -> Self {
        Self {
            config,
            turns: 0.0,
            periods: 0,
            speed_turns: 0.0,
            limits: CounterLimits::FIRST,
        }
    }

    /// Other constants from the next sample on; the count of periods goes on.
    pub fn configure(&mut self, config: EncoderConfig) {
        self.config = config;
    }

    /// Sine and cosine in counts to a reading. Any input gives finite numbers. No branch on data. Cost: `cargo xtask bench`.
    #[inline(never)] // built for speed with this package, and not for size with the image
    pub fn step(&mut self, counts: [i16; 2]) -> Reading {
        let EncoderConfig {
            pair,
            harmonics,
            limits,
            constants,
            octants,
        } = &self.config;
        // Two equal lanes, of which the compiler computes one.
        let at = interpolate(constants, octants, &pair.first_twice(), [counts; 2]);
        let phase = Unit {
            sine: at.sine.0[0],
            cosine: at.cosine.0[0],
        };
        let turns = at.turns.0[0];
        // The first phase is less than half a period from zero: no period is counted.
        let old = Counters {
            turns: Lanes([self.turns; 2]),
            teeth: [self.periods; 2],
            speed_m_s: self.speed_turns,
        };
        let (new, slip) = old.advance(constants, &self.limits, Lanes([turns; 2]), 1.0);
        self.turns = turns;
        self.periods = new.teeth[0];
        self.speed_turns = new.speed_m_s;
        self.limits = *limits;
        Reading {
            phase,
            amplitude_counts: at.amplitude.0[0],
            periods: self.periods,
            unmodified_turns: turns,
            calibrated_turns: turns + harmonics.at(phase),
            slipped: slip[0] != 0,
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use core::f64::consts::TAU;

    fn counts(turns: f64, pair: &PairCorrection) -> [i16; 2] {
        let phase = TAU * turns;
        let cosine = f64::from(pair.gain) * (phase + f64::from(pair.angle_rad)).cos();
        let [s, c] = pair.offset_counts.map(f64::from);
        [s + 20_000.0 * phase.sin(), c + 20_000.0 * cosine].map(|x| x.round() as i16)
    }

    #[test]
    fn a_known_pair_gives_its_position_over_many_periods_and_back() {
        let pair = PairCorrection {
            offset_counts: [900.0, -400.0],
            gain: 1.1,
            angle_rad: 0.1,
        };
        let config = EncoderConfig::new(&pair, &Harmonics::default(), 0.2, 0.25).unwrap();
        let mut encoder = Encoder::new(config);
        let mut worst = 0.0_f64;
        for n in 0..20_000 {
            let turns = 30.0 * (f64::from(n) * TAU / 20_000.0).sin();
            let reading = encoder.step(counts(turns, &pair));
            assert!(!reading.slipped);
            let found = f64::from(reading.periods) + f64::from(reading.calibrated_turns);
            worst = worst.max((found - turns).abs());
        }
        // Rounding to whole counts: 0.71 of 18,000 radians at the most, and the phase's own 2.5e-7 turns.
        assert!(worst < 0.71 / 18_000.0 / TAU + 2.5e-7, "{worst:e}");
    }

    #[test]
    fn a_step_of_nearly_half_a_period_is_told() {
        let pair = PairCorrection::default();
        let config = EncoderConfig::new(&pair, &Harmonics::default(), 0.2, 0.25).unwrap();
        let mut encoder = Encoder::new(config);
        assert!(!encoder.step(counts(0.3, &pair)).slipped);
        assert!(!encoder.step(counts(0.31, &pair)).slipped);
        assert!(encoder.step(counts(0.7, &pair)).slipped);
    }

    #[test]
    fn numbers_out_of_range_are_refused_by_name() {
        let bad = PairCorrection {
            gain: f32::NAN,
            ..PairCorrection::default()
        };
        let none = Harmonics::default();
        let refused = |pair: &PairCorrection, harmonics: &Harmonics, slip| {
            EncoderConfig::new(pair, harmonics, slip, 0.25)
                .unwrap_err()
                .name
        };
        assert_eq!(refused(&bad, &none, 0.2), "gain");
        let large = Harmonics {
            turns: [[0.1; 2]; 8],
        };
        assert_eq!(
            refused(&PairCorrection::default(), &large, 0.2),
            "harmonics"
        );
        assert_eq!(
            refused(&PairCorrection::default(), &none, 0.5),
            "slip_turns"
        );
    }
}
