//! `beacon_vibration`: the beacon or its mount vibrates at one or a few frequencies.

// --- plant side: where the beacon is ---

use crate::plant::{Instant, PlantEffect, Scene};
use crate::random::{ChaCha8Rng, index, log_uniform, normal, uniform};
use core::f64::consts::TAU;

/// One line of the vibration; its level swells slowly, as an excited resonance does.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Line {
    frequency_hz: f64,
    amplitude_m: [f64; 2],
    phase_rad: [f64; 2],
    swell_hz: f64,
    swell_phase_rad: f64,
}

/// Depth of the swell.
const SWELL: f64 = 0.3;

/// Plant side. Size: rms displacement of an axis, pooled over the two.
#[derive(Clone, Debug, PartialEq)]
pub struct BeaconVibration {
    lines: Vec<Line>,
}

impl BeaconVibration {
    /// One to three resonances of a mount, 15 to 150 Hz, of any direction.
    pub fn draw(_scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        let mut strength = 1.0;
        let count = 1 + index(rng, 3);
        let lines: Vec<Line> = (0..count)
            .map(|_| {
                strength *= 0.6;
                Line {
                    frequency_hz: log_uniform(rng, 15.0, 150.0),
                    amplitude_m: [(); 2].map(|()| strength * normal(rng)),
                    phase_rad: [(); 2].map(|()| uniform(rng, 0.0, TAU)),
                    swell_hz: uniform(rng, 0.1, 1.5),
                    swell_phase_rad: uniform(rng, 0.0, TAU),
                }
            })
            .collect();
        let power: f64 = lines.iter().flat_map(|line| line.amplitude_m).map(|a| 0.25 * a * a).sum();
        let rms = (power * (1.0 + 0.5 * SWELL * SWELL)).sqrt();
        let mut effect = Self { lines };
        effect.scale(size_rms_m / rms.max(1.0e-12));
        Box::new(effect)
    }
}

impl PlantEffect for BeaconVibration {
    fn scale(&mut self, factor: f64) {
        self.lines.iter_mut().for_each(|line| line.amplitude_m = line.amplitude_m.map(|a| a * factor));
    }

    fn beacon_m(&mut self, at: &Instant) -> [f64; 2] {
        core::array::from_fn(|axis| {
            let value = |line: &Line| {
                let swell = 1.0 + SWELL * (TAU * line.swell_hz * at.time_s + line.swell_phase_rad).sin();
                let wave = (TAU * line.frequency_hz * at.time_s + line.phase_rad[axis]).sin();
                line.amplitude_m[axis] * swell * wave
            };
            self.lines.iter().map(value).sum()
        })
    }
}

// --- sensor side: lines in the spectrum of g_x and g_y ---

/// What a sensor can know of it: shares nothing with the plant side above.
pub mod sensor_side {
    use core::f64::consts::TAU;
    use crate::sensor::{Regressor, SLOWEST_LINE_HZ, BasisInputs};

    pub use crate::sensor::SLOWEST_LINE_HZ as SLOWEST_HZ;

    /// Sensor side: sine and cosine at each line that were found, along x and y, by stretch.
    pub fn regressors(inputs: &BasisInputs) -> Vec<Regressor> {
        let mut list = Vec::new();
        for &hz in inputs.beacon_lines_hz.iter().filter(|hz| **hz >= SLOWEST_LINE_HZ) {
            for axis in 0..2 {
                let name = |part| format!("{hz:.3} Hz {part}, {}", ["x", "y"][axis]);
                list.push(Regressor::channel(
                    name("sine"),
                    "m",
                    4.0e-6,
                    1 + axis,
                    move |m| (TAU * hz * m.t_s).sin(),
                ));
                list.push(Regressor::channel(
                    name("cosine"),
                    "m",
                    4.0e-6,
                    1 + axis,
                    move |m| (TAU * hz * m.t_s).cos(),
                ));
            }
        }
        list
    }
}

// --- what is known of it ---

use crate::effect::{Card, Transfer, Confusable, Effect, Detection, Need, Quantity, Recordings};
use crate::sensor::{Regressor, BasisInputs};

/// The effect.
pub struct Definition;

/// Its card.
pub static CARD: Card = Card {
    name: "beacon_vibration",
    summary: "the beacon or its mount vibrates at one or a few frequencies",
    sizes: "4 µm a line: without data",
    telling_motion: "standing still under the beacon for a few seconds at the full sample rate",
    recordings: Recordings::Still,
    needs: &[Need::Beacon],
    detection: Detection::ByLines,
    follows: Quantity::Time,
    coordinate: "frequency",
    transfer: Transfer::Rephased,
    its_own: "how it swells and strays",
    carries_over: "frequencies and levels; phases are fitted anew in each stretch",
    confusable: &[
        Confusable { with: "excess_noise", parted_by: "a line that lies between two samples is noise: the full sample rate while standing still tells" },
    ],
    ..Card::PLAIN
};

impl Effect for Definition {
    fn card(&self) -> &'static Card {
        &CARD
    }

    fn draw(&self, scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        BeaconVibration::draw(scene, rng, size_rms_m)
    }

    fn shapes(&self, inputs: &BasisInputs) -> Vec<Regressor> {
        sensor_side::regressors(inputs)
    }
}
