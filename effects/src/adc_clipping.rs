//! `adc_clipping`: a quadrature channel saturates.

// --- plant side: limits at the converter ---

use crate::plant::{Channels, Instant, PlantEffect, SEGMENTS, Scene};
use crate::random::{ChaCha8Rng, index, uniform};
use core::f64::consts::TAU;

/// Plant side. Size: rms of the displacement over the phase, pooled over the segments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdcClipping {
    /// Which segments clip.
    pub hit: [bool; SEGMENTS],
    /// Rms of a clipping segment, radians of its phase.
    rms_rad: f64,
    /// Level, share of the amplitude.
    pub level: f64,
}

impl AdcClipping {
    /// One segment, two, or all: gain was set too high for them.
    pub fn draw(scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        let (first, second) = (index(rng, SEGMENTS), index(rng, SEGMENTS));
        let all = uniform(rng, 0.0, 1.0) < 0.25;
        let hit: [bool; SEGMENTS] = core::array::from_fn(|s| all || s == first || s == second);
        let hits = hit.iter().filter(|h| **h).count() as f64;
        let rms_rad = size_rms_m * scene.geometry.wavenumber() * (SEGMENTS as f64 / hits).sqrt();
        Box::new(Self { hit, rms_rad, level: level_of(rms_rad) })
    }
}

/// Level, as a share of the amplitude, at which clipping makes a phase error of an rms, radians. At least 0.3.
fn level_of(rms_rad: f64) -> f64 {
    let (mut low, mut high) = (0.3, 1.0);
    for _ in 0..40 {
        let level = 0.5 * (low + high);
        if error_rad(level) > rms_rad { low = level } else { high = level }
    }
    0.5 * (low + high)
}

/// Rms phase error of both channels clipped at a level.
fn error_rad(level: f64) -> f64 {
    // A quarter turn repeats.
    let steps = 2000;
    let power = (0..steps).map(|i| {
        let phase = TAU / 4.0 * (f64::from(i) + 0.5) / f64::from(steps);
        (phase.sin().min(level).atan2(phase.cos().min(level)) - phase).powi(2)
    });
    (power.sum::<f64>() / f64::from(steps)).sqrt()
}

impl PlantEffect for AdcClipping {
    fn scale(&mut self, factor: f64) {
        self.rms_rad *= factor;
        self.level = level_of(self.rms_rad);
    }

    fn analog(&mut self, _at: &Instant, channels: &mut Channels) {
        let limit = self.level * channels.amplitude_counts;
        for (pair, _) in channels.quadrature.iter_mut().zip(self.hit).filter(|(_, hit)| *hit) {
            pair.iter_mut().for_each(|value| *value = value.clamp(-limit, limit));
        }
    }
}
