//! A simulated shaft that is spun by hand or motor: its true places, and what a pair or an encoder on it reads.

use encoder::Input;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use std::f64::consts::TAU;

pub const PITCH_M: f64 = 1.0e-3;
const RATE_HZ: f64 = 2000.0;
/// Steps of the integration between samples.
const STEPS: usize = 4;

/// A motion: spins one after the other.
#[derive(Clone, Debug)]
pub struct Spins {
    /// First speed of each, periods a second, negative backwards.
    pub speeds: Vec<f64>,
    /// How long each takes, s.
    pub seconds: f64,
    /// Rate at which the speed decays, 1/s; 0 for a motor.
    pub decay: f64,
    /// Change of the speed over a second by a torque that is white noise, periods a second.
    pub jitter: f64,
    /// A torque locked to the phase: order and size, periods/s².
    pub ripple: Vec<(u32, f64)>,
}

impl Spins {
    /// Six pushes by hand that coast, both ways, some faster than others.
    pub fn by_hand() -> Self {
        Self {
            speeds: vec![4.0, -4.0, 8.0, -8.0, 3.0, -6.0],
            seconds: 4.0,
            decay: 0.15,
            jitter: 0.02,
            ripple: Vec::new(),
        }
    }

    /// True times and places.
    pub fn places(&self, random: &mut ChaCha8Rng) -> (Vec<f64>, Vec<f64>) {
        let normal = Normal::new(0.0, 1.0).expect("a deviation");
        let step = 1.0 / RATE_HZ / STEPS as f64;
        let (mut t_s, mut places, mut place) = (Vec::new(), Vec::new(), 0.0);
        for speed in &self.speeds {
            let (mut speed, begin) = (*speed, t_s.last().map_or(0.0, |t: &f64| t + 1.0));
            for sample in 0..(self.seconds * RATE_HZ) as usize {
                t_s.push(begin + sample as f64 / RATE_HZ);
                places.push(place);
                for _ in 0..STEPS {
                    let ripple: f64 = self
                        .ripple
                        .iter()
                        .map(|(order, size)| size * (TAU * f64::from(*order) * place).sin())
                        .sum();
                    speed += step * (ripple - self.decay * speed)
                        + self.jitter * step.sqrt() * normal.sample(random);
                    place += step * speed;
                }
            }
        }
        (t_s, places)
    }
}

/// An encoder that reads only places: the true one less `error` of what it reads, rounded to `resolution` and noisy.
pub fn places_read(
    t_s: &[f64],
    places: &[f64],
    error: impl Fn(f64) -> f64,
    noise: f64,
    random: &mut ChaCha8Rng,
) -> Input {
    let normal = Normal::new(0.0, noise).expect("a deviation");
    let read = |place: &f64| {
        let mut read = *place;
        for _ in 0..20 {
            read = place - error(read);
        }
        read + normal.sample(random)
    };
    Input {
        t_s: t_s.to_vec(),
        place: places.iter().map(read).collect(),
        pitch_m: PITCH_M,
        ..Input::default()
    }
}

/// A pair: `signals` of a phase in turns, counts; noise of each.
pub fn pair_read(
    t_s: &[f64],
    places: &[f64],
    signals: impl Fn(f64) -> [f64; 2],
    noise: f64,
    random: &mut ChaCha8Rng,
) -> Input {
    let normal = Normal::new(0.0, noise).expect("a deviation");
    let counts: Vec<[f64; 2]> = places
        .iter()
        .map(|place| signals(*place).map(|x| (x + normal.sample(random)).round()))
        .collect();
    let near = |(counts, place): (&[f64; 2], &f64)| {
        let turns = counts[0].atan2(counts[1]) / TAU;
        turns + (place - turns).round()
    };
    Input {
        t_s: t_s.to_vec(),
        place: counts.iter().zip(places).map(near).collect(),
        counts,
        pitch_m: PITCH_M,
        ..Input::default()
    }
}

/// Root of the mean square about the mean, m, of what a calibration leaves.
pub fn left_m(found: impl Iterator<Item = f64>, truth: &[f64]) -> f64 {
    let errors: Vec<f64> = found
        .zip(truth)
        .map(|(found, truth)| found - truth)
        .collect();
    rms_about_mean(&errors) * PITCH_M
}

pub fn rms_about_mean(errors: &[f64]) -> f64 {
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    (errors
        .iter()
        .map(|error| (error - mean).powi(2))
        .sum::<f64>()
        / errors.len() as f64)
        .sqrt()
}

pub fn random(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}
