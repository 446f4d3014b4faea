//! The sensor head resonates where the frequency of passing teeth meets its own.

use crate::plant::{Instant, PlantEffect, SEGMENTS, Scene, SegmentPoint};
use crate::random::{ChaCha8Rng, uniform};
use crate::shape::segment_offsets;
use core::f64::consts::TAU;

/// Size: rms at resonance, pooled over the segments.
pub struct ToothResonance {
    sizes_m: [f64; SEGMENTS],
    frequency_hz: f64,
    width_hz: f64,
    last_s: f64,
    /// Amplitude and phase as a phasor that follows the excitation with the resonance's own time constant.
    phasor: [f64; 2],
}

impl ToothResonance {
    /// Between the tooth frequencies of 15 and 55 mm/s.
    pub fn draw(_scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        Box::new(Self {
            sizes_m: segment_offsets(rng, size_rms_m * 2.0_f64.sqrt()),
            frequency_hz: uniform(rng, 15.0, 55.0),
            width_hz: uniform(rng, 2.0, 8.0),
            last_s: f64::NEG_INFINITY,
            phasor: [0.0; 2],
        })
    }
}

impl PlantEffect for ToothResonance {
    fn scale(&mut self, factor: f64) {
        self.sizes_m = self.sizes_m.map(|size| size * factor);
    }

    fn displacement_m(&mut self, at: &Instant, _points: &[SegmentPoint; SEGMENTS]) -> [f64; SEGMENTS] {
        let velocity = at.velocity();
        let speed = velocity.x_m.hypot(velocity.y_m);
        let off = (speed / at.geometry.pitch_m - self.frequency_hz) / self.width_hz;
        // Steady response of a resonance to its excitation, relative to its peak: 1 / (1 + i off). At rest nothing excites it.
        let drive = (speed / (at.geometry.pitch_m * self.frequency_hz)).min(1.0) / (1.0 + off * off);
        let steady = [drive, -off * drive];
        let follow = 1.0 - (-TAU * self.width_hz * (at.time_s - self.last_s)).exp();
        self.last_s = at.time_s;
        self.phasor.iter_mut().zip(steady).for_each(|(p, s)| *p += follow * (s - *p));
        let phase = TAU * (at.pose.x_m + at.pose.y_m) / at.geometry.pitch_m;
        let wave = self.phasor[0] * phase.sin() + self.phasor[1] * phase.cos();
        self.sizes_m.map(|size| size * wave)
    }
}
