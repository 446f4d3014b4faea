//! `psd_latency`: the coordination sensor is sampled earlier or later than the platen sensor.

// --- plant side: the time at which the diode is read ---

use crate::plant::{PlantEffect, Scene};
use crate::random::{ChaCha8Rng, sign};

/// Speed at which the size is stated: the sweeps' under the beacon. A definition: as a survey makes them.
const REFERENCE_M_S: f64 = 20.0e-3;

/// Plant side. Size: displacement within the delay at 20 mm/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PsdLatency {
    /// How much later than the platen sensor it is sampled, seconds; negative: earlier.
    pub delay_s: f64,
}

impl PsdLatency {
    /// Either sign.
    pub fn draw(_scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        Box::new(Self { delay_s: sign(rng) * size_rms_m / REFERENCE_M_S })
    }
}

impl PlantEffect for PsdLatency {
    fn scale(&mut self, factor: f64) {
        self.delay_s *= factor;
    }

    fn coordination_delay_s(&self) -> f64 {
        self.delay_s
    }
}

// --- sensor side: the deflection's rate ---

/// What a sensor can know of it: shares nothing with the plant side above.
pub mod sensor_side {
    use crate::sensor::{Regressor, BasisInputs};

    /// Sensor side: one delay, common to both axes, and how far one lags behind the other: no more than completes it, as their filters
    /// are alike.
    pub fn regressors(_survey: &BasisInputs) -> Vec<Regressor> {
        vec![
            Regressor::readings("delay against the platen sensor", "s", 5.0e-6, |m, out| {
                out[4] += m.tan_psi_rate[0];
                out[5] += m.tan_psi_rate[1];
            }),
            Regressor::readings("delay of x over y", "s", 1.0e-6, |m, out| {
                out[4] += 0.5 * m.tan_psi_rate[0];
                out[5] -= 0.5 * m.tan_psi_rate[1];
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
    name: "psd_latency",
    summary: "the coordination sensor is sampled earlier or later than the platen sensor",
    sizes: "5 µm at the recording's speeds for the delay of both axes, 1 µm for the difference of the two: their filters are alike",
    telling_motion: "fly-bys under the beacon at several speeds, along x and along y; a delay common to all four segments stays the same thing",
    needs: &[Need::Beacon, Need::Moving],
    follows: Quantity::Speed,
    coordinate: "speed",
    confusable: &[
        Confusable { with: "velocity_lag", parted_by: "a delay common to all four segments is the same thing; different ones show in the parity of every fly-by" },
    ],
    ..Card::PLAIN
};

impl Effect for Definition {
    fn card(&self) -> &'static Card {
        &CARD
    }

    fn draw(&self, scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        PsdLatency::draw(scene, rng, size_rms_m)
    }

    fn shapes(&self, inputs: &BasisInputs) -> Vec<Regressor> {
        sensor_side::regressors(inputs)
    }
}
