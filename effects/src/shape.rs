//! Random smooth shapes, richer than any basis that a sensor-side model fits, scaled to a stated rms.

use crate::plant::SEGMENTS;
use crate::random::{ChaCha8Rng, log_uniform, normal, uniform};
use core::f64::consts::TAU;

/// A periodic function of a phase as a table; cubic between its points.
#[derive(Clone, Debug)]
pub struct Periodic {
    table: Vec<f64>,
}

/// Points a turn. As was measured, Catmull and Rom's cubic is then off by 2e-5 of the amplitude of order 4 and by 4e-4 of order
/// 12: that is the plant's shape, and exact to itself.
const POINTS: usize = 256;

impl Periodic {
    /// From weights of orders: each gets a random phase; zero mean, rms 1 (or zero if all weights are).
    pub fn draw(rng: &mut ChaCha8Rng, weights: &[(usize, f64)]) -> Self {
        let orders: Vec<_> = weights
            .iter()
            .map(|&(n, w)| (n as f64, w, uniform(rng, 0.0, TAU)))
            .collect();
        let value = |i: usize| {
            let phase = TAU * i as f64 / POINTS as f64;
            orders
                .iter()
                .map(|(n, w, at)| w * (n * phase + at).sin())
                .sum::<f64>()
        };
        let mut shape = Self {
            table: (0..POINTS).map(value).collect(),
        };
        shape.normalise();
        shape
    }

    fn normalise(&mut self) {
        let mean = self.table.iter().sum::<f64>() / self.table.len() as f64;
        self.table.iter_mut().for_each(|v| *v -= mean);
        let rms = root_mean_square(&self.table);
        if rms > 0.0 {
            self.table.iter_mut().for_each(|v| *v /= rms);
        }
    }

    /// Value at a phase in turns.
    #[must_use]
    pub fn at(&self, turns: f64) -> f64 {
        let place = (turns - turns.floor()) * POINTS as f64;
        let cell = place as usize;
        let point = |offset: usize| self.table[(cell + POINTS - 1 + offset) % POINTS];
        cubic(
            [point(0), point(1), point(2), point(3)],
            place - cell as f64,
        )
    }
}

/// Catmull-Rom cubic through four equally spaced points, between the middle two.
#[must_use]
pub fn cubic([a, b, c, d]: [f64; 4], t: f64) -> f64 {
    b + 0.5 * t * (c - a + t * (2.0 * a - 5.0 * b + 4.0 * c - d + t * (3.0 * (b - c) + d - a)))
}

/// Root of the mean square.
#[must_use]
pub fn root_mean_square(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

/// A sum of plane waves: a stationary random function of place or time with lengths within a range.
#[derive(Clone, Debug)]
pub struct Waves<const D: usize> {
    waves: Vec<([f64; D], f64, f64)>,
}

impl<const D: usize> Waves<D> {
    /// `count` waves of log-uniform wavelength and random direction; mean square 1 over a large domain.
    pub fn draw(rng: &mut ChaCha8Rng, count: usize, shortest: f64, longest: f64) -> Self {
        let mut waves: Vec<([f64; D], f64, f64)> = (0..count)
            .map(|_| {
                let direction: [f64; D] = core::array::from_fn(|_| normal(rng));
                let length = direction
                    .iter()
                    .map(|d| d * d)
                    .sum::<f64>()
                    .sqrt()
                    .max(1.0e-9);
                let number = TAU / log_uniform(rng, shortest, longest) / length;
                (
                    direction.map(|d| d * number),
                    normal(rng),
                    uniform(rng, 0.0, TAU),
                )
            })
            .collect();
        let power = waves
            .iter()
            .map(|(_, a, _)| 0.5 * a * a)
            .sum::<f64>()
            .sqrt();
        if power > 0.0 {
            waves.iter_mut().for_each(|wave| wave.1 /= power);
        }
        Self { waves }
    }

    /// Value at a place.
    #[must_use]
    pub fn at(&self, place: [f64; D]) -> f64 {
        let phase = |k: &[f64; D]| k.iter().zip(place).map(|(k, p)| k * p).sum::<f64>();
        self.waves
            .iter()
            .map(|(k, a, offset)| a * (phase(k) + offset).sin())
            .sum()
    }
}

/// A slow wander over a stretch of time: mean 0 and rms 1 over it.
#[derive(Clone, Debug)]
pub struct Wander {
    waves: Waves<1>,
    mean: f64,
    rms: f64,
}

impl Wander {
    /// Over `0..duration_s`, with periods from a seventh of it to once and a half.
    pub fn draw(rng: &mut ChaCha8Rng, duration_s: f64) -> Self {
        let waves = Waves::draw(rng, 6, duration_s / 7.0, 1.5 * duration_s);
        let values: Vec<f64> = (0..400)
            .map(|i| waves.at([duration_s * f64::from(i) / 400.0]))
            .collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let centred: Vec<f64> = values.iter().map(|v| v - mean).collect();
        Self {
            waves,
            mean,
            rms: root_mean_square(&centred).max(1.0e-9),
        }
    }

    /// Value at a time.
    #[must_use]
    pub fn at(&self, time_s: f64) -> f64 {
        (self.waves.at([time_s]) - self.mean) / self.rms
    }
}

/// Sizes of the four segments' shares of an effect: positive, unequal as built parts are, mean square `size` squared.
pub fn segment_sizes(rng: &mut ChaCha8Rng, size: f64) -> [f64; SEGMENTS] {
    let raw: [f64; SEGMENTS] = core::array::from_fn(|_| (0.5 * normal(rng)).exp());
    let rms = root_mean_square(&raw);
    raw.map(|r| size * r / rms)
}

/// As [`segment_sizes`], each with a random sign and magnitude: what an assembly tolerance does.
pub fn segment_offsets(rng: &mut ChaCha8Rng, size: f64) -> [f64; SEGMENTS] {
    let raw: [f64; SEGMENTS] = core::array::from_fn(|_| normal(rng));
    let rms = root_mean_square(&raw).max(1.0e-9);
    raw.map(|r| size * r / rms)
}
