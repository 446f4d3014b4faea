//! What the air gap may be over the places that a recording passes: a tilt, a bow, the angle, and waves over a mesh.

use super::sample::Sample;
use std::collections::HashMap;
use tooth_field::{CubicSpline, Lattice};

/// Expected size of a gap's logarithm by tilt and bow. A prior: the amplitude falls as exp(-2π gap / pitch), so that 50 µm of a
/// platen's flatness and tilt make 0.31.
const GAP_SIZE: f64 = 0.3;
/// The same by waves. A prior: a third of that, 16 µm over some teeth.
pub(super) const GAP_WAVE_SIZE: f64 = 0.1;

/// Mesh of cubic B-splines over the places that were passed, beside a tilt and a bow.
#[derive(Default)]
pub(super) struct Mesh {
    middle_m: [f64; 2],
    /// Distance of the knots; without a mesh zero.
    step_m: f64,
    knots: HashMap<[i32; 2], usize>,
}

/// Meshes that are tried, pitches: a gap is smooth over teeth. Zero: none. A prior: a segment averages over some six teeth, so
/// that a gap over it changes over as many; halves of that follow.
pub(super) const GAP_MESHES_PITCHES: [f64; 4] = [0.0, 6.0, 3.0, 1.5];
/// Most knots of a mesh. A bound on the work: a finer mesh that has more is not tried, and the coarser one stays.
const MOST_MESH_KNOTS: usize = 240;
/// Terms of a tilt, a bow, the angle and its square: a courier that turns tilts. A definition: 2, 3, 1, 1 and the constant.
const LOW_TERMS: usize = 8;
/// Length that those are counted in, m. By definition half of the ten pitches that the paper's calibration goes over, so that
/// terms are of order one.
const LENGTH_M: f64 = 5.0e-3;
/// Angle that those are counted in, rad. By definition about the largest of the paper's calibrations (1.5°).
const ANGLE_RAD: f64 = 0.02;

impl Mesh {
    /// None where there would be too many knots.
    pub(super) fn over(samples: &[Sample], step_m: f64) -> Option<Self> {
        let count = samples.len() as f64;
        let middle_m = [0, 1].map(|k| samples.iter().map(|s| s.place_m[k]).sum::<f64>() / count);
        let mut knots = HashMap::new();
        for sample in samples.iter().filter(|_| step_m > 0.0) {
            for (node, _) in around(sample.place_m, step_m) {
                let next = knots.len();
                knots.entry(node).or_insert(next);
            }
            if knots.len() > MOST_MESH_KNOTS {
                return None;
            }
        }
        Some(Self {
            middle_m,
            step_m,
            knots,
        })
    }

    pub(super) fn columns(&self) -> usize {
        LOW_TERMS + self.knots.len()
    }

    /// Columns and their entries at a sample, counted from `first`.
    pub(super) fn entries(&self, sample: &Sample, first: usize) -> Vec<(usize, f64)> {
        let [x, y] = [0, 1].map(|k| (sample.place_m[k] - self.middle_m[k]) / LENGTH_M);
        let turned = sample.theta_rad / ANGLE_RAD;
        let low = [1.0, x, y, x * x, x * y, y * y, turned, turned * turned];
        let mut list: Vec<(usize, f64)> = (first..).zip(low.map(|l| GAP_SIZE * l)).collect();
        if self.step_m > 0.0 {
            let known = |(node, weight)| {
                Some((
                    first + LOW_TERMS + self.knots.get(&node)?,
                    GAP_WAVE_SIZE * weight,
                ))
            };
            list.extend(around(sample.place_m, self.step_m).filter_map(known));
        }
        list
    }
}

/// The knots about a place with their weights.
fn around(place_m: [f64; 2], step_m: f64) -> impl Iterator<Item = ([i32; 2], f64)> {
    Lattice::of_teeth(CubicSpline).nodes(place_m.map(|p| p / step_m))
}
