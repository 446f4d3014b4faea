//! `angle_dependence`: the error's harmonics change with theta.
//!
//! A turned coil pair no longer lies along the teeth: parts of it see another phase, so every order shrinks and shifts.

// --- plant side: from the true pose to a displacement ---

use crate::plant::{Instant, PlantEffect, SEGMENTS, Scene, SegmentPoint};
use crate::random::{ChaCha8Rng, normal};
use crate::shape::{Periodic, segment_sizes};

/// Angle at which the size is stated: uniform within +-0.5 degrees. A definition: the angles of the paper's self-calibration
/// (3.1.2).
const REFERENCE_RAD: f64 = 0.5 * core::f64::consts::PI / 180.0;

/// Orders of the shapes, with relative weights.
const ORDERS: [(usize, f64); 5] = [(1, 1.0), (2, 0.7), (3, 0.2), (4, 0.35), (6, 0.15)];

/// Amplitude of the part that is even in theta, relative to the odd one.
const EVEN: f64 = 0.3;

/// Plant side. Size: rms over the own phase and angles uniform within +-0.5 degrees, pooled over the segments.
pub struct AngleDependence {
    shapes: [[Periodic; 2]; SEGMENTS],
    sizes_m: [f64; SEGMENTS],
}

impl AngleDependence {
    /// An odd and a smaller even part in theta, each with its own shape.
    pub fn draw(_scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        let mut shape = || {
            let weights = ORDERS.map(|(order, weight)| (order, weight * normal(rng).abs()));
            Periodic::draw(rng, &weights)
        };
        let shapes = core::array::from_fn(|_| [shape(), shape()]);
        // Mean squares of u and u^2 over uniform u in +-1 are 1/3 and 1/5; the two parts are uncorrelated.
        let rms = (1.0 / 3.0 + EVEN * EVEN / 5.0_f64).sqrt();
        Box::new(Self { shapes, sizes_m: segment_sizes(rng, size_rms_m / rms) })
    }
}

impl PlantEffect for AngleDependence {
    fn scale(&mut self, factor: f64) {
        self.sizes_m = self.sizes_m.map(|size| size * factor);
    }

    fn displacement_m(&mut self, at: &Instant, points: &[SegmentPoint; SEGMENTS]) -> [f64; SEGMENTS] {
        let angle = at.pose.theta_rad / REFERENCE_RAD;
        core::array::from_fn(|s| {
            let turns = points[s].own_m / at.geometry.pitch_m;
            let [odd, even] = &self.shapes[s];
            self.sizes_m[s] * (angle * odd.at(turns) + EVEN * angle * angle * even.at(turns))
        })
    }
}

// --- sensor side: harmonics times powers of the angle ---

/// What a sensor can know of it: shares nothing with the plant side above.
pub mod sensor_side {
    use crate::basis::legendre;
    use crate::identity::Factor;
    use crate::sensor::{Channel, Covariates, Regressor, BasisInputs};

    /// What is even in theta: a coil of some width that lies straight loses amplitude either way it is turned, as a sinc does, so this
    /// part may be the effect itself and no completion of the odd one.
    const EVEN_SIZE_M: f64 = 1.2e-6;

    /// Orders whose sinc is past its parabola within a degree or so.
    const CURVED: [usize; 3] = [1, 2, 4];
    /// Prior size of what is beyond it: it completes the parabola.
    const CURVED_SIZE_M: f64 = 0.6e-6;

    /// Degrees of a free bend over the range of the angle.
    const BENT: core::ops::RangeInclusive<usize> = 3..=6;
    /// Prior size of each: it completes the effect.
    const BENT_SIZE_M: f64 = 0.6e-6;

    /// The angle within the range of nearly all samples, -1 to 1; beyond it nothing goes on.
    fn within(m: &Covariates, [least, most]: [f64; 2]) -> f64 {
        let half = 0.5 * (most - least);
        if half > 0.0 {
            ((m.theta_rad - 0.5 * (least + most)) / half).clamp(-1.0, 1.0)
        } else {
            0.0
        }
    }

    /// Order of a quadrature angle. Derived from the pair's phase: channels that are off a right angle by ψ shift it by (ψ/2)(1 -
    /// cos 2φ).
    const QUADRATURE: usize = 2;

    /// What a channel that turns by a small angle shifts the pair by, over the cosine of order 2 that it makes: a sine that leads by ψ makes
    /// (ψ/2)(1 + cos 2φ), a cosine (ψ/2)(1 - cos 2φ).
    fn mean_shift(turns: Option<Channel>) -> f64 {
        match turns {
            None => 0.0,
            Some(Channel::Sine) => 1.0,
            Some(Channel::Cosine) => -1.0,
        }
    }

    /// Cosine of that order times a power of the angle, with the mean shift that comes with it.
    fn turning(inputs: &BasisInputs, segment: usize, label: (&str, &'static str, f64), power: i32) -> Regressor {
        let (unmodified, mean) = (inputs.unmodified, mean_shift(inputs.forms.turns_with_theta));
        let name = format!("{}quadrature angle, segment {}", label.0, segment + 1);
        Regressor::reading(name, label.1, label.2, segment, move |m| {
            let table = if unmodified { &m.raw } else { &m.own };
            m.theta_rad.powi(power) * (table[segment][QUADRATURE].1 + mean)
        })
    }

    /// Sensor side: each low order times theta and theta squared, the strongest times its fourth power besides. Where that leaves a gap they
    /// may bend over the angle as they please, or one channel of each pair turns against the other.
    pub fn regressors(inputs: &BasisInputs) -> Vec<Regressor> {
        let mut list = Vec::new();
        for s in (0..4).filter(|s| inputs.segments[*s]) {
            for order in [1, 2, 3, 4, 6] {
                let size_m = if order < 3 { 2.5e-6 } else { 1.5e-6 };
                let powers = [("theta times ", "m/rad", size_m), ("theta squared times ", "m/rad²", EVEN_SIZE_M)];
                for ((text, unit, size_m), power) in powers.into_iter().zip(1..) {
                    let label = (text, unit, size_m, Factor::Angle(power));
                    Regressor::free_harmonic(inputs, &mut list, (s, order), label, move |m| m.theta_rad.powi(power));
                    if order == QUADRATURE && inputs.forms.turns_with_theta.is_some() {
                        list.pop();
                        list.push(turning(inputs, s, (text, unit, size_m), power));
                    }
                }
                let range = inputs.thetas_rad;
                for degree in BENT.filter(|_| inputs.forms.bends_with_theta) {
                    Regressor::free_harmonic(
                        inputs,
                        &mut list,
                        (s, order),
                        (format!("degree {degree} of theta times ").as_str(), "m", BENT_SIZE_M),
                        move |m| legendre(degree, within(m, range)),
                    );
                }
                if !CURVED.contains(&order) {
                    continue;
                }
                Regressor::free_harmonic(
                    inputs,
                    &mut list,
                    (s, order),
                    ("theta to the fourth times ", "m/rad⁴", CURVED_SIZE_M, Factor::Angle(4)),
                    |m| m.theta_rad.powi(4),
                );
            }
        }
        list
    }
}

// --- what is known of it ---

use crate::effect::{Card, Confusable, Effect, Form, Subsumption, KnownBy, Need, Quantity, Recordings};
use crate::sensor::{Channel, Regressor, BasisInputs};

/// The effect.
pub struct Definition;

/// Its card.
pub static CARD: Card = Card {
    name: "angle_dependence",
    summary: "the error's harmonics change with theta",
    sizes: "2.5 µm for the orders 1 and 2 at the angles of a self-calibration, 1.5 µm for higher ones, half of that for what is even in the angle: without data; the paper leaves the dependence on the angle out (section 3.1.1)",
    telling_motion: "random still poses with the angle over ±1.5°",
    recordings: Recordings::Turned,
    needs: &[Need::Turning],
    follows: Quantity::Angle,
    coordinate: "theta and own tooth phase",
    either_phase: true,
    forms: &[
        Form::new("the cosine turns against the sine with the angle", |told| told.turns_with_theta = Some(Channel::Cosine)),
        Form::new("the sine turns against the cosine with the angle", |told| told.turns_with_theta = Some(Channel::Sine)),
        Form::new("harmonics bend over the angle as they please", |told| told.bends_with_theta = true),
    ],
    // A channel that turns against the other with the angle shifts its pair as a span that is wrong does, by as much as the harmonic
    // that it makes, and changes the amplitude as a gap that tilts does.
    subsumes: &[
        Subsumption { other: "span_error", tell: TURNS, known_by: KnownBy::Fit },
        Subsumption { other: "gap_variation", tell: TURNS, known_by: KnownBy::Fit },
    ],
    on_board: "powers 1 and 2 of the angle; the fourth as the parabola that is nearest",
    confusable: &[
        Confusable { with: "span_error", parted_by: "both grow with the angle: harmonics that change come back at every tooth, an arm does not; slow turns at one place tell" },
        Confusable { with: "gap_variation", parted_by: "a gap that tilts goes with the angle: raw counts show whether the amplitude changes with it" },
    ],
    ..Card::PLAIN
};

/// Either channel turns against the other.
const TURNS: &[fn(&mut BasisInputs)] = &[
    |inputs| inputs.forms.turns_with_theta = Some(Channel::Sine),
    |inputs| inputs.forms.turns_with_theta = Some(Channel::Cosine),
];

impl Effect for Definition {
    fn card(&self) -> &'static Card {
        &CARD
    }

    fn draw(&self, scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        AngleDependence::draw(scene, rng, size_rms_m)
    }

    fn shapes(&self, inputs: &BasisInputs) -> Vec<Regressor> {
        sensor_side::regressors(inputs)
    }
}
