//! `psd_misalignment`: the diode is turned in its mount, or its axes differ in gain.

// --- plant side: from the true deflection to the diode's ---

use crate::plant::{Instant, PlantEffect, Scene};
use crate::random::{ChaCha8Rng, normal, uniform};

/// Range at which the size is stated, of full scale: the 8 mm sweeps. A definition: with ±4 mm of ±5 mm.
const RANGE: f64 = 0.8;

/// Plant side. Size: rms of an axis' displacement by the difference of gains over the square of +-0.8 of full scale, pooled over the
/// axes. A turn in the mount besides is no part of it: it cannot be told from the platen sensor's own zero of angle, and equation
/// (11)'s constants take it up whole, whatever its size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PsdMisalignment {
    /// Angle of the diode in its mount, radians.
    pub turn_rad: f64,
    /// Difference of the axes' gains: x has `1 + half`, y `1 - half` (what is common is the beacon's height).
    pub gain_difference: f64,
    /// Place of the diode's centre, normalised (what a constant of equation (11) absorbs).
    pub centre: [f64; 2],
}

impl PsdMisalignment {
    /// A difference of gains of either sign, beside a turn of any size up to some times as much in two of three draws.
    pub fn draw(scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        let full_m = scene.geometry.height_m * scene.geometry.tan_full_scale;
        // Rms over the square: range / sqrt(3) times half the difference.
        let half = size_rms_m / (full_m * RANGE / 3.0_f64.sqrt());
        let sign = if uniform(rng, -1.0, 1.0) < 0.0 { -1.0 } else { 1.0 };
        let turned = uniform(rng, 0.0, 3.0) < 2.0;
        let turn_rad = if turned { half * normal(rng) } else { 0.0 };
        let centre = [(); 2].map(|()| 0.002 * normal(rng));
        Box::new(Self { turn_rad, gain_difference: 2.0 * sign * half, centre })
    }
}

impl PlantEffect for PsdMisalignment {
    fn scale(&mut self, factor: f64) {
        self.turn_rad *= factor;
        self.gain_difference *= factor;
        self.centre = self.centre.map(|c| c * factor);
    }

    fn deflection(&mut self, _at: &Instant, normalised: &mut [f64; 2]) {
        let (sine, cosine) = self.turn_rad.sin_cos();
        let [x, y] = *normalised;
        let half = 0.5 * self.gain_difference;
        normalised[0] = (1.0 + half) * (cosine * x + sine * y) + self.centre[0];
        normalised[1] = (1.0 - half) * (cosine * y - sine * x) + self.centre[1];
    }
}

// --- sensor side: a turn of the diode and a difference of gain ---

/// What a sensor can know of it: shares nothing with the plant side above.
pub mod sensor_side {
    use crate::sensor::{Regressor, BasisInputs};

    /// Sensor side: three amounts. A pure turn is tied to the platen sensor's own zero of angle by the prior on the offsets. A
    /// diode that leans about a line between its axes, or whose axes are not quite square, gains along its diagonals: no more
    /// than completes the effect, since lines that are not square do as much on the platen.
    pub fn regressors(_survey: &BasisInputs) -> Vec<Regressor> {
        vec![
            Regressor::readings("gain of x over y", "1", 4.0e-6, |m, out| {
                out[4] += 0.5 * m.tan_psi[0];
                out[5] -= 0.5 * m.tan_psi[1];
            }),
            Regressor::readings("turn in the mount", "rad", 10.0e-6, |m, out| {
                out[4] -= m.tan_psi[1];
                out[5] += m.tan_psi[0];
            }),
            Regressor::readings("gain along the diagonals", "1", 2.0e-6, |m, out| {
                out[4] += 0.5 * m.tan_psi[1];
                out[5] += 0.5 * m.tan_psi[0];
            }),
        ]
    }
}

// --- what is known of it ---

use crate::effect::{Card, Confusable, Effect, Need, Quantity};
use crate::sensor::{Regressor, BasisInputs};

/// The effect.
pub struct Definition;

/// Its card.
pub static CARD: Card = Card {
    name: "psd_misalignment",
    summary: "the diode is turned in its mount, or its axes differ in gain",
    sizes: "4 µm for a difference of gains over the diode, 10 µm for a turn, 2 µm for what a diode that leans adds: without data",
    telling_motion: "a known distance by an independent reference along both axes: only it tells the diode's gain from the platen's pitch",
    needs: &[Need::Beacon],
    follows: Quantity::Deflection,
    coordinate: "deflection of the coordination sensor",
    confusable: &[
        Confusable { with: "axis_skew", parted_by: "a diode's gain is a platen's pitch: only a known distance by an independent reference along both axes tells them apart" },
    ],
    ..Card::PLAIN
};

impl Effect for Definition {
    fn card(&self) -> &'static Card {
        &CARD
    }

    fn draw(&self, scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        PsdMisalignment::draw(scene, rng, size_rms_m)
    }

    fn shapes(&self, inputs: &BasisInputs) -> Vec<Regressor> {
        sensor_side::regressors(inputs)
    }
}
