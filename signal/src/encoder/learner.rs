//! On the device: circle and motion together, sample by sample, in fixed memory.

use super::circle::Circle;
use super::harmonics::{Harmonics, ORDERS};
use super::pair::Reading;
use super::stretch::{COLUMNS, Stretch};
use crate::lsq::{Estimator, SolveError, packed_len};

const PACKED: usize = packed_len(COLUMNS);
/// Periods of a stretch: with fewer the cubic of the motion takes most of order 1, with more it holds less well. Derived from
/// both: the correlation of a slope with order 1 is 0.78 over the number of periods.
pub const PERIODS: f32 = 2.0;
/// Samples a period that are entered. Derived from the highest order, 8, which then has eight.
const PER_PERIOD: f32 = 64.0;
/// A stretch that takes more samples than this is given up: the motion stands still, or nearly. A bound on the work: 52 s at 20
/// kHz, after which the next stretch begins.
const MOST_SAMPLES: u32 = 1 << 20;
/// Rows a stretch must have beyond its unknowns, for its noise to mean something. Derived from the degrees of freedom: the noise
/// is then known to 16 % (1/√(2 · 20)).
const LEAST_ROWS: u32 = 2 * (COLUMNS as u32 + 4);
/// Smallest noise that a stretch is believed to have, turns. Derived from f32's rounding of a place of two periods: 2^-22 is
/// 2.4e-7, and twice that.
const LEAST_NOISE_TURNS: f32 = 5.0e-7;

/// Learns one pair's errors from its own readings. About 5 KiB; 1.3 KiB more on the stack in [`Learner::enter`].
#[derive(Clone, Debug)]
pub struct Learner {
    /// What the radius tells.
    pub circle: Circle,
    stretch: Stretch,
    motion: Estimator<COLUMNS, PACKED>,
    samples: u32,
    start: Option<(i32, f32)>,
    entered: f32,
    stretches: u32,
}

/// What the motion tells of the angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Learned {
    /// To be added to the phase.
    pub harmonics: Harmonics,
    /// Standard deviations, turns, by the scatter of the stretches. A ripple of the true speed that is locked to the phase is in the
    /// harmonics, not in these: two speeds or more tell it.
    pub deviations: [[f32; 2]; ORDERS],
    /// Stretches it rests on.
    pub stretches: u32,
}

impl Default for Learner {
    fn default() -> Self {
        Self::new()
    }
}

impl Learner {
    /// Without a reading.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            circle: Circle::new(),
            stretch: Stretch::new(ORDERS),
            motion: Estimator::new(COLUMNS),
            samples: 0,
            start: None,
            entered: 0.0,
            stretches: 0,
        }
    }

    /// Takes a reading at regular instants, moving or not. Not in the interrupt: at 64 places of a period it enters two rows.
    pub fn enter(&mut self, reading: &Reading) {
        if reading.slipped || self.samples > MOST_SAMPLES {
            self.begin(reading);
            return;
        }
        let Some((periods, turns)) = self.start else {
            self.begin(reading);
            return;
        };
        self.samples += 1;
        let moved =
            reading.periods.wrapping_sub(periods) as f32 + (reading.unmodified_turns - turns);
        if (moved - self.entered).abs() < 1.0 / PER_PERIOD {
            return;
        }
        self.entered = moved;
        // Both refuse only what is not finite, which a reading never is.
        let _ = self.circle.enter(reading);
        let _ = self
            .stretch
            .enter(self.samples as f32 * TIME_UNIT, moved, reading.phase);
        if moved.abs() >= PERIODS {
            self.close();
            self.begin(reading);
        }
    }

    fn begin(&mut self, reading: &Reading) {
        self.stretch.reset();
        self.samples = 0;
        self.entered = 0.0;
        self.start = Some((reading.periods, reading.unmodified_turns));
    }

    /// Adds the stretch to the rest, weighted by its own noise.
    fn close(&mut self) {
        let Some(noise) = self.stretch.noise_turns() else {
            return;
        };
        if self.stretch.rows() < LEAST_ROWS {
            return;
        }
        let weight = 1.0 / noise.max(LEAST_NOISE_TURNS);
        for index in 0..COLUMNS {
            let (row, right) = self.stretch.equation(index);
            let _ = self
                .motion
                .rows
                .enter(&row.map(|x| x * weight), right * weight);
        }
        self.stretches += 1;
    }

    /// What the motion has told. Background only.
    ///
    /// # Errors
    /// No stretch is complete.
    pub fn solve(&mut self) -> Result<Learned, SolveError> {
        let solution = self.motion.solve_equilibrated()?;
        let pairs =
            |values: &[f32; COLUMNS]| core::array::from_fn(|n| [values[2 * n], values[2 * n + 1]]);
        Ok(Learned {
            harmonics: Harmonics {
                turns: pairs(&solution.values),
            },
            deviations: pairs(&solution.deviations),
            stretches: self.stretches,
        })
    }
}

/// Samples to the time in a stretch's rows: powers of it stay within what f32's squares hold, for any stretch. Derived from the
/// longest stretch, 2^20 samples: its cube is 2^30 in this unit, whose square an f32 holds.
const TIME_UNIT: f32 = 1.0 / 1024.0;

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::encoder::{Encoder, EncoderConfig};
    use crate::quadrature::PairCorrection;
    use core::f64::consts::TAU;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, Normal};

    const AMPLITUDE: f64 = 20_000.0;
    const NOISE: f64 = 10.0;

    /// A pair with a third harmonic of negative sequence (angle and radius of order 4), turned there and back ten times.
    fn run(
        seed: u64,
        pair: &PairCorrection,
        third: f64,
        learner: &mut Learner,
        config: EncoderConfig,
    ) {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let normal = Normal::new(0.0, NOISE).unwrap();
        let mut encoder = Encoder::new(config);
        for n in 0..60_000 {
            let turns = 25.0 * (f64::from(n) * TAU / 60_000.0).sin();
            let phase = TAU * turns;
            let sine = phase.sin() - third * (3.0 * phase).sin();
            let cosine = f64::from(pair.gain)
                * ((phase + f64::from(pair.angle_rad)).cos() + third * (3.0 * phase).cos());
            let values = [sine, cosine].map(|x| AMPLITUDE * x + normal.sample(&mut random));
            let counts = core::array::from_fn(|k| {
                (values[k] + f64::from(pair.offset_counts[k])).round() as i16
            });
            learner.enter(&encoder.step(counts));
        }
    }

    fn config(pair: &PairCorrection) -> EncoderConfig {
        EncoderConfig::new(pair, &Harmonics::default(), 0.2, 0.25).unwrap()
    }

    /// Offset, gain and angle by the circle, in three steps from nothing, as often within two deviations as they should be.
    #[test]
    fn the_circle_tells_offset_gain_and_angle() {
        let truth = PairCorrection {
            offset_counts: [700.0, -300.0],
            gain: 1.06,
            angle_rad: -0.08,
        };
        let mut found = PairCorrection::default();
        for step in 0..4 {
            let mut learner = Learner::new();
            run(step, &truth, 0.0, &mut learner, config(&found));
            let round = learner.circle.solve().unwrap();
            found = round.correction(&found);
        }
        // 50 periods of 64 readings, noise of 10 counts a channel: half a count on a centre is over two deviations.
        let deviation = NOISE * (2.0_f64 / (50.0 * 64.0)).sqrt();
        for k in 0..2 {
            assert!(
                f64::from(found.offset_counts[k] - truth.offset_counts[k]).abs() < 4.0 * deviation,
                "{found:?}"
            );
        }
        assert!(
            f64::from(found.gain - truth.gain).abs() < 4.0 * 2.0 * deviation / AMPLITUDE,
            "{found:?}"
        );
        assert!(
            f64::from(found.angle_rad - truth.angle_rad).abs() < 4.0 * 2.0 * deviation / AMPLITUDE,
            "{found:?}"
        );
    }

    /// The motion tells what the third harmonic does to the angle, and its deviations are right: over 200 seeds the mean square of
    /// the errors over them is one. 16 numbers a seed that share little: 3,200 squares scatter by 2.5 %, and the noise of a
    /// stretch is itself estimated.
    #[test]
    fn the_motion_tells_the_angle_and_how_well() {
        let pair = PairCorrection::default();
        let (mut squares, mut count) = (0.0, 0);
        for seed in 0..200 {
            let mut learner = Learner::new();
            run(seed, &pair, 0.01, &mut learner, config(&pair));
            let learned = learner.solve().unwrap();
            // 100 periods; a stretch that turns back inside takes more.
            assert!((40..=50).contains(&learned.stretches), "{learned:?}");
            for (n, (found, deviation)) in learned
                .harmonics
                .turns
                .iter()
                .zip(&learned.deviations)
                .enumerate()
            {
                // z_-3: the angle read is wrong by -0.01 sin 4 phi rad, in the phase read; the second order of it is 5e-5.
                let wanted = [if n == 3 { 0.01 / TAU } else { 0.0 }, 0.0];
                for part in 0..2 {
                    let error = f64::from(found[part]) - wanted[part];
                    if n != 7 {
                        squares += (error / f64::from(deviation[part])).powi(2);
                        count += 1;
                    }
                }
            }
        }
        let mean = squares / f64::from(count);
        assert!((0.85..1.15).contains(&mean), "{mean}");
    }

    #[test]
    fn standing_still_teaches_nothing_and_takes_no_memory() {
        let mut learner = Learner::new();
        let mut encoder = Encoder::new(config(&PairCorrection::default()));
        for _ in 0..10_000 {
            learner.enter(&encoder.step([100, 20_000]));
        }
        assert!(learner.solve().is_err());
        assert!(learner.circle.solve().is_err());
        assert!(core::mem::size_of::<Learner>() < 6 * 1024);
    }
}
