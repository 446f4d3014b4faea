//! Mains frequency on one quadrature pair, stronger while the motors draw current.

use crate::plant::{Instant, PlantEffect, SEGMENTS, Scene, Signal};
use crate::random::{ChaCha8Rng, index, uniform};
use core::f64::consts::TAU;

/// Size: rms of the displacement at 50 mm/s, pooled over the segments.
pub struct MainsPickup {
    segment: usize,
    frequency_hz: f64,
    phases_rad: [f64; 2],
    amplitude: f64,
}

/// Speed at which the pickup has doubled, m/s.
const DOUBLING_M_S: f64 = 0.05;

impl MainsPickup {
    /// 50 or 60 Hz with the grid's error, on one pair.
    pub fn draw(scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        let grid_hz = if uniform(rng, 0.0, 1.0) < 0.5 { 50.0 } else { 60.0 };
        // Sine and cosine with independent phases: mean square a^2 / 2 of the phase; one pair of four, doubled at speed.
        let rms_rad = size_rms_m * scene.geometry.wavenumber();
        Box::new(Self {
            segment: index(rng, SEGMENTS),
            frequency_hz: grid_hz + uniform(rng, -0.05, 0.05),
            phases_rad: [(); 2].map(|()| uniform(rng, 0.0, TAU)),
            amplitude: rms_rad * 2.0 * 2.0_f64.sqrt() / 2.0,
        })
    }
}

impl PlantEffect for MainsPickup {
    fn scale(&mut self, factor: f64) {
        self.amplitude *= factor;
    }

    fn signal(&mut self, at: &Instant, signals: &mut [Signal; SEGMENTS]) {
        let velocity = at.velocity();
        let level = self.amplitude * (1.0 + velocity.x_m.hypot(velocity.y_m) / DOUBLING_M_S);
        let pickup = self.phases_rad.map(|phase| level * (TAU * self.frequency_hz * at.time_s + phase).sin());
        signals[self.segment].sine += pickup[0];
        signals[self.segment].cosine += pickup[1];
    }
}
