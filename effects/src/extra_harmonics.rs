//! `extra_harmonics`: orders of the own tooth phase that equation (3) leaves out.
//!
//! Tooth shape, coil spacing and the drive's saturation make every order; equation (3) kept the four that one device showed.

// --- plant side: from the true pose to a displacement ---

use crate::plant::{Instant, PlantEffect, SEGMENTS, Scene, SegmentPoint};
use crate::random::{ChaCha8Rng, normal};
use crate::shape::{Periodic, segment_sizes};

/// Orders that are drawn, with their relative weights.
const ORDERS: [(usize, f64); 8] =
    [(3, 1.0), (5, 0.8), (7, 0.4), (8, 0.8), (9, 0.3), (10, 0.4), (12, 0.4), (16, 0.15)];

/// Plant side. Size: rms over the own phase, pooled over the segments.
pub struct ExtraHarmonics {
    shapes: [Periodic; SEGMENTS],
    sizes_m: [f64; SEGMENTS],
}

impl ExtraHarmonics {
    /// Every segment has its own shape.
    pub fn draw(_scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        let shapes = core::array::from_fn(|_| {
            let weights = ORDERS.map(|(order, weight)| (order, weight * normal(rng).abs()));
            Periodic::draw(rng, &weights)
        });
        Box::new(Self { shapes, sizes_m: segment_sizes(rng, size_rms_m) })
    }
}

impl PlantEffect for ExtraHarmonics {
    fn scale(&mut self, factor: f64) {
        self.sizes_m = self.sizes_m.map(|size| size * factor);
    }

    fn displacement_m(&mut self, at: &Instant, points: &[SegmentPoint; SEGMENTS]) -> [f64; SEGMENTS] {
        core::array::from_fn(|s| self.sizes_m[s] * self.shapes[s].at(points[s].own_m / at.geometry.pitch_m))
    }
}

// --- sensor side: orders of the own phase that equation (3) leaves out ---

/// What a sensor can know of it: shares nothing with the plant side above.
pub mod sensor_side {
    use crate::identity::Factor;
    use crate::sensor::{ORDERS, Regressor, BasisInputs};
    use courier_signal::equations::OWN_ORDERS;

    /// Prior size of an order, m: as much as the smallest that equation (3) keeps (orders 4 and 6 of the paper's device).
    const SIZE_M: f64 = 2.0e-6;
    /// Sensor side: free sine and cosine of each order, each segment by itself.
    pub fn regressors(inputs: &BasisInputs) -> Vec<Regressor> {
        let mut list = Vec::new();
        for s in (0..4).filter(|s| inputs.segments[*s]) {
            for order in (3..=ORDERS).filter(|n| !OWN_ORDERS.iter().any(|own| usize::from(*own) == *n)) {
                Regressor::free_harmonic(inputs, &mut list, (s, order), ("", "m", SIZE_M, Factor::One), |_| 1.0);
            }
        }
        list
    }
}

// --- what is known of it ---

use crate::effect::{Card, Confusable, Effect, Nature, Quantity};
use crate::identity::Identity;
use crate::sensor::{Regressor, BasisInputs};

/// The effect.
pub struct Definition;

/// Its card.
pub static CARD: Card = Card {
    name: "extra_harmonics",
    summary: "orders of the own tooth phase that equation (3) leaves out",
    sizes: "2 µm an order: third harmonics of 0.6 to 0.8 % of the signals make 1 to 1.3 µm of order 4 (ESS resolver)",
    telling_motion: "raw counts instead of positions: clipping and gap variation show in the amplitude, free harmonics do not",
    follows: Quantity::OwnPhase,
    coordinate: "own tooth phase",
    nature: Nature::Shape,
    either_phase: true,
    on_board: "the largest orders that there is room for",
    confusable: &[
        Confusable { with: "adc_clipping", parted_by: "a clip makes the orders 4, 8, 12 and 16: raw counts show whether the tops are flat" },
        Confusable { with: "gap_variation", parted_by: "an offset makes further orders of equation (3)'s: fly-bys over the platen with raw counts show whether they change with the amplitude" },
    ],
    ..Card::PLAIN
};

impl Effect for Definition {
    fn card(&self) -> &'static Card {
        &CARD
    }

    fn draw(&self, scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        ExtraHarmonics::draw(scene, rng, size_rms_m)
    }

    fn shapes(&self, inputs: &BasisInputs) -> Vec<Regressor> {
        sensor_side::regressors(inputs)
    }

    fn coordinate(&self, amount: &Regressor) -> String {
        match amount.identity {
            Some(Identity::Wave(wave)) => format!("{}, order {}", CARD.coordinate, wave.own_order),
            _ => CARD.coordinate.into(),
        }
    }
}
