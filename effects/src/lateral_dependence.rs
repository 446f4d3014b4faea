//! `lateral_dependence`: a segment's output depends on the tooth phase across it.
//!
//! A coil pair is a few teeth wide; as it slides across the rows of posts its coupling changes with the pitch. Mostly the
//! first order of the lateral phase (equation 9), a second order, and products with the own phase, since the coupling is
//! that of single posts and not of lines.

// --- plant side: from the true pose to a displacement ---

use crate::plant::{Instant, PlantEffect, SEGMENTS, Scene, SegmentPoint};
use crate::random::{ChaCha8Rng, normal};

/// `(own order, lateral order, relative weight)`: what is drawn for each segment.
const ORDERS: [(f64, f64, f64); 6] = [
    (0.0, 1.0, 1.0),
    (0.0, 2.0, 0.35),
    (0.0, 3.0, 0.08),
    (1.0, 1.0, 0.15),
    (1.0, -1.0, 0.15),
    (2.0, 1.0, 0.08),
];

/// One wave over own and lateral phase: `amplitude * sin(own n + lateral m + offset)`, as sine and cosine parts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LateralWave {
    /// Order of the own tooth phase.
    pub own_order: f64,
    /// Order of the lateral tooth phase, signed.
    pub lateral_order: f64,
    /// Sine and cosine amplitudes, metres.
    pub amplitude_m: [f64; 2],
}

impl LateralWave {
    fn at(&self, wavenumber: f64, point: &SegmentPoint) -> f64 {
        let phase =
            wavenumber * (self.own_order * point.own_m + self.lateral_order * point.across_m);
        let (sine, cosine) = phase.sin_cos();
        self.amplitude_m[0] * sine + self.amplitude_m[1] * cosine
    }
}

/// Plant side. Size: rms over own and lateral phase, pooled over the four segments.
#[derive(Clone, Debug, PartialEq)]
pub struct LateralDependence {
    /// Each segment's waves.
    pub waves: [Vec<LateralWave>; SEGMENTS],
}

impl LateralDependence {
    /// Amplitudes of all orders are normal, so that segments differ as built ones do.
    pub fn draw(_scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        let waves = core::array::from_fn(|_| {
            let wave = |&(own_order, lateral_order, weight): &(f64, f64, f64)| LateralWave {
                own_order,
                lateral_order,
                amplitude_m: [weight * normal(rng), weight * normal(rng)],
            };
            ORDERS.iter().map(wave).collect()
        });
        let mut effect = Self { waves };
        let rms = effect.rms_m();
        effect.scale(size_rms_m / rms);
        Box::new(effect)
    }

    /// Rms over uniform phases, pooled over the segments: orders are orthogonal, so powers add.
    #[must_use]
    pub fn rms_m(&self) -> f64 {
        let power: f64 = self
            .waves
            .iter()
            .flatten()
            .flat_map(|wave| wave.amplitude_m)
            .map(|a| 0.5 * a * a)
            .sum();
        (power / SEGMENTS as f64).sqrt()
    }
}

impl PlantEffect for LateralDependence {
    fn scale(&mut self, factor: f64) {
        self.waves
            .iter_mut()
            .flatten()
            .for_each(|wave| wave.amplitude_m = wave.amplitude_m.map(|a| a * factor));
    }

    fn displacement_m(
        &mut self,
        at: &Instant,
        points: &[SegmentPoint; SEGMENTS],
    ) -> [f64; SEGMENTS] {
        let wavenumber = at.geometry.wavenumber();
        core::array::from_fn(|s| {
            self.waves[s]
                .iter()
                .map(|wave| wave.at(wavenumber, &points[s]))
                .sum()
        })
    }
}

// --- sensor side: regressors over the lateral phase ---

/// What a sensor can know of it: shares nothing with the plant side above.
pub mod sensor_side {
    use crate::identity::{Factor, Identity, Part, Wave};
    use crate::sensor::{Covariates, Regressor, BasisInputs};

    /// Orders across, and the prior size of each, m: some 2.7 µm rms beside the platen's teeth bring a
    /// simulated courier to the paper's residuals (section 3.1.2); the higher orders fall as a coil some teeth wide averages them.
    const ACROSS: [(usize, f64); 3] = [(1, 4.0e-6), (2, 2.0e-6), (3, 0.5e-6)];
    /// Prior size of a product, m: a sixth of the first order's.
    const MIXED_SIZE_M: f64 = 0.7e-6;
    /// Orders along and across of products: what an output's slope over the tooth makes of order 1. Derived from the product: a
    /// wave across (equation 9) times waves of orders 1 and 2 along makes the sums and differences of both phases.
    const MIXED: [(usize, i32); 4] = [(1, 1), (1, -1), (2, 1), (2, -1)];
    /// Those of the higher orders across.
    const MORE: [(usize, i32); 6] = [(1, 2), (1, -2), (1, 3), (1, -3), (2, 2), (2, -2)];

    /// Sensor side: equation (9) with orders 1 to 3 across, and products of low orders along and across; where that leaves a gap, of more.
    pub fn regressors(inputs: &BasisInputs) -> Vec<Regressor> {
        let mut list = Vec::new();
        for s in (0..4).filter(|s| inputs.segments[*s]) {
            for (order, size_m) in ACROSS {
                for part in Part::BOTH {
                    let name = format!("order {order} {}, segment {}", part.name(), s + 1);
                    let value = move |m: &Covariates| part.of(m.lateral[s][order]);
                    let one = Regressor::reading(name, "m", size_m, s, value);
                    list.push(one.identified(wave(s, 0, order as i32, part)));
                }
            }
            let more = MORE.into_iter().filter(|_| inputs.forms.lateral_mixes);
            for (own, across) in MIXED.into_iter().chain(more) {
                let sign = f64::from(across.signum());
                let order = across.unsigned_abs() as usize;
                let product = move |m: &Covariates| {
                    let ((a, b), (c, d)) = (m.own[s][own], m.lateral[s][order]);
                    (a * d + sign * b * c, b * d - sign * a * c)
                };
                for part in Part::BOTH {
                    let name = format!("own order {own}, lateral order {across} {}, segment {}", part.name(), s + 1);
                    let value = move |m: &Covariates| part.of(product(m));
                    let one = Regressor::reading(name, "m", MIXED_SIZE_M, s, value);
                    list.push(one.identified(wave(s, own, across, part)));
                }
            }
        }
        list
    }

    fn wave(segment: usize, own_order: usize, lateral_order: i32, part: Part) -> Identity {
        Identity::Wave(Wave { segment, own_order, lateral_order, part, factor: Factor::One })
    }
}

// --- what is known of it ---

use crate::effect::{Card, Confusable, Effect, Form, Need, Quantity};
use crate::identity::Identity;
use crate::sensor::{Regressor, BasisInputs};

/// The effect.
pub struct Definition;

/// Its card.
pub static CARD: Card = Card {
    name: "lateral_dependence",
    summary: "a segment's output depends on the tooth phase across it",
    sizes: "4, 2 and 0.5 µm for the orders 1, 2 and 3 across, 0.7 µm for products of orders: with some 2.7 µm rms beside the platen's teeth a simulated courier comes to the residuals of the paper's section 3.1.2",
    telling_motion: "random poses under a beacon with the angle over ±1.5°, which part the tooth phase across a segment from that along its neighbours",
    needs: &[Need::Across],
    follows: Quantity::AcrossPhase,
    coordinate: "lateral tooth phase",
    forms: &[Form::new("products of more orders along and across", |told| told.lateral_mixes = true)],
    on_board: "all orders, as terms of the tooth phases along and across",
    confusable: &[
        Confusable { with: "tooth_variation", parted_by: "both are patterns across the teeth: what comes back at other teeth of the same phase is the segment's; poses over other teeth tell" },
        Confusable { with: "extra_harmonics", parted_by: "along one line of teeth the phase across hardly changes: poses at all phases across tell" },
    ],
    ..Card::PLAIN
};

impl Effect for Definition {
    fn card(&self) -> &'static Card {
        &CARD
    }

    fn draw(&self, scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        LateralDependence::draw(scene, rng, size_rms_m)
    }

    fn shapes(&self, inputs: &BasisInputs) -> Vec<Regressor> {
        sensor_side::regressors(inputs)
    }

    fn coordinate(&self, amount: &Regressor) -> String {
        match amount.identity {
            Some(Identity::Wave(wave)) if wave.own_order > 0 => "own and lateral tooth phase".into(),
            Some(Identity::Wave(wave)) => format!("{}, order {}", CARD.coordinate, wave.lateral_order),
            _ => CARD.coordinate.into(),
        }
    }
}
