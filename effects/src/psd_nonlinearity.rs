//! `psd_nonlinearity`: cubic, quadratic and cross terms of the coordination sensor.
//!
//! A lateral-effect diode's current divides linearly only near its centre; towards the electrodes the field bends.

// --- plant side: from the true deflection to the diode's ---

use crate::plant::{Geometry, Instant, PlantEffect, Scene};
use crate::random::{ChaCha8Rng, normal};
use crate::shape::root_mean_square;

/// Terms of one axis in its own deflection `u` and the other's `v`: powers and relative weight.
const TERMS: [(i32, i32, f64); 8] =
    [(3, 0, 1.0), (1, 2, 0.6), (2, 0, 0.25), (1, 1, 0.25), (0, 2, 0.2), (0, 3, 0.15), (5, 0, 0.2), (3, 2, 0.15)];

/// Range at which the size is stated, of full scale: the 8 mm sweeps. A definition: with ±4 mm of ±5 mm.
const RANGE: f64 = 0.8;

/// Plant side. Size: rms of an axis' displacement over the square of +-0.8 of full scale, pooled over the axes.
#[derive(Clone, Debug, PartialEq)]
pub struct PsdNonlinearity {
    /// Each axis' coefficients, in the order of the terms, of the normalised deflection.
    coefficients: [[f64; TERMS.len()]; 2],
}

impl PsdNonlinearity {
    /// All coefficients normal.
    pub fn draw(scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        let mut effect = Self { coefficients: [(); 2].map(|()| TERMS.map(|(_, _, weight)| weight * normal(rng))) };
        let rms = effect.rms_m(&scene.geometry);
        effect.scale(size_rms_m / rms);
        Box::new(effect)
    }

    /// From stated coefficients: cubic, then `u v^2`, `u^2`, `u v`, `v^2`, `v^3`, `u^5`, `u^3 v^2` of each axis.
    #[must_use]
    pub fn new(coefficients: [[f64; TERMS.len()]; 2]) -> Self {
        Self { coefficients }
    }

    fn rms_m(&self, geometry: &Geometry) -> f64 {
        let place = |i: i32| RANGE * (f64::from(i) / 20.0 - 1.0);
        let grid = (0..=40).flat_map(|i| (0..=40).map(move |j| [place(i), place(j)]));
        let values: Vec<f64> = grid.flat_map(|u| self.error(u)).collect();
        root_mean_square(&values) * geometry.height_m * geometry.tan_full_scale
    }

    fn error(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let axis = |coefficients: &[f64], u: f64, v: f64| {
            let terms = coefficients.iter().zip(TERMS);
            terms.map(|(c, (n, m, _))| c * u.powi(n) * v.powi(m)).sum::<f64>()
        };
        [axis(&self.coefficients[0], x, y), axis(&self.coefficients[1], y, x)]
    }
}

impl PlantEffect for PsdNonlinearity {
    fn scale(&mut self, factor: f64) {
        self.coefficients.iter_mut().flatten().for_each(|c| *c *= factor);
    }

    fn deflection(&mut self, _at: &Instant, normalised: &mut [f64; 2]) {
        let error = self.error(*normalised);
        normalised.iter_mut().zip(error).for_each(|(u, e)| *u += e);
    }
}

// --- sensor side: quadratic, cross and cubic terms of the deflection ---

/// What a sensor can know of it: shares nothing with the plant side above.
pub mod sensor_side {
    use crate::sensor::{Regressor, BasisInputs};

    /// Powers of the deflections along x and y. By definition all products of second and third degree.
    const POWERS: [[i32; 2]; 7] = [[3, 0], [0, 3], [2, 1], [1, 2], [2, 0], [1, 1], [0, 2]];
    /// The same of fourth and fifth degree: a diode bends the more the nearer to its edge.
    const HIGHER: [[i32; 2]; 7] = [[5, 0], [0, 5], [3, 2], [2, 3], [4, 0], [2, 2], [0, 4]];
    /// Highest degree of a diode of quadrants, along each axis alone. A prior: the light of one quadrant goes over to the next as an error function
    /// does, and an edge of its spot shows.
    const HIGHEST: i32 = 9;
    /// Prior sizes of the terms, m rms.
    const SIZE_M: f64 = 4.0e-6;
    /// See [`SIZE_M`].
    const HIGHER_M: f64 = 1.5e-6;
    /// By so many times a diode of quadrants bends more than one that divides its current. A prior: a cubic term of 17 % of the linear one
    /// at full scale (Golnabi) is 5 % rms, where the sizes above are a thousandth of 4 mm. Its higher terms are as large as the others: an error
    /// function's are.
    const QUADRANTS_BEND: f64 = 50.0;

    /// Sensor side: all terms of second to fifth degree in the two deflections, the higher ones small; of a diode of quadrants larger ones, and
    /// more.
    pub fn regressors(inputs: &BasisInputs) -> Vec<Regressor> {
        let mut list = Vec::new();
        let of_size = |powers: &[[i32; 2]], size_m: f64| -> Vec<([i32; 2], f64)> {
            powers.iter().map(|powers| (*powers, size_m)).collect()
        };
        let terms = if inputs.forms.bends_far {
            let alone = (6..=HIGHEST).flat_map(|degree| [[degree, 0], [0, degree]]);
            let all: Vec<_> = POWERS.iter().chain(&HIGHER).copied().chain(alone).collect();
            of_size(&all, QUADRANTS_BEND * SIZE_M)
        } else {
            [of_size(&POWERS, SIZE_M), of_size(&HIGHER, HIGHER_M)].concat()
        };
        for axis in 0..2 {
            for &([a, b], size_m) in &terms {
                let full = inputs.tan_full_scale;
                let name = format!("x^{a} y^{b} on {}", ["x", "y"][axis]);
                list.push(Regressor::reading(
                    name,
                    "of full scale",
                    size_m,
                    4 + axis,
                    move |m| full * m.deflection[0].powi(a) * m.deflection[1].powi(b),
                ));
            }
        }
        list
    }
}

// --- what is known of it ---

use crate::effect::{Card, Confusable, Effect, Need, Quantity};
use crate::sensor::{Regressor, BasisInputs};

/// The effect.
pub struct Definition;

/// Its card.
pub static CARD: Card = Card {
    name: "psd_nonlinearity",
    summary: "cubic, quadratic and cross terms of the coordination sensor",
    sizes: "4 µm for terms of second and third degree, 1.5 µm for higher ones. A diode that bends by more than such amounts could, as one of quadrants does, is told by amounts fifty times as large and to the ninth degree: a cubic term of up to 17 % of the linear one at full scale has been seen (Golnabi)",
    telling_motion: "fly-bys under the beacon along both axes to the edge of the diode",
    needs: &[Need::Beacon],
    follows: Quantity::Deflection,
    coordinate: "deflection of the coordination sensor",
    far: Some(|told| told.bends_far = true),
    carries_over: "its amounts, for the same beacon at the same height",
    confusable: &[
        Confusable { with: "tooth_variation", parted_by: "under a beacon the deflection is the place: two places under the beacon tell" },
        Confusable { with: "psd_misalignment", parted_by: "both go with the deflection: a bend is not straight; fly-bys to the edge of the diode tell" },
    ],
    ..Card::PLAIN
};

impl Effect for Definition {
    fn card(&self) -> &'static Card {
        &CARD
    }

    fn draw(&self, scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        PsdNonlinearity::draw(scene, rng, size_rms_m)
    }

    fn shapes(&self, inputs: &BasisInputs) -> Vec<Regressor> {
        sensor_side::regressors(inputs)
    }
}
