//! Teeth under an aperture, as sums of splines: what the data tell of the splines they tell of the teeth.

use crate::blocks::{Block, KINDS, Weights};
use crate::cache::Cache;
use crate::form::Aperture;
use crate::key::Key;
use crate::splines::{Splines, log_evidence};
use nalgebra::{DMatrix, DVector};
use normal_equations::cholesky::Factor;
use std::ops::Range;
use tooth_field::{ApertureKernel, Kernel, cubic_b_spline};
use tooth_map::{FieldKernel, NODE_M};

/// Teeth that are under an aperture somewhere over the splines, as sums of these.
pub struct Teeth {
    /// Of each direction's field: along, those of which the data tell something.
    along: [Vec<i32>; 2],
    /// The first tooth across of each.
    first_across: [i32; 2],
    /// Of each kind: whole lines have one tooth across, and one spline.
    weights: [Weights; KINDS],
}

/// A tooth as a sum of splines: their weights from one of them on, all others being 0.
#[derive(Clone, Debug)]
struct Share {
    tooth: i32,
    from: usize,
    weights: Vec<f64>,
}

impl Share {
    /// The weight of one spline.
    fn weight(&self, spline: usize) -> f64 {
        let at = spline.checked_sub(self.from);
        at.and_then(|at| self.weights.get(at))
            .copied()
            .unwrap_or(0.0)
    }

    /// Numbers of the splines.
    fn splines(&self) -> Range<usize> {
        self.from..self.from + self.weights.len()
    }
}

/// What the data tell of teeth, in the tooth map's prior deviations: single ones first, then whole lines.
pub struct OfTeeth {
    /// Its lower triangle.
    precision: DMatrix<f64>,
    right: DVector<f64>,
    /// How many of them are single teeth.
    nodes: usize,
}

impl OfTeeth {
    /// Precision, of which the lower triangle is filled, and right side of the teeth, each in its own deviation under an aperture, with that of their prior. Cost: the square of their
    /// number.
    pub fn with_prior(&self, aperture: &Aperture) -> (DMatrix<f64>, DVector<f64>) {
        let deviations = self.deviations(aperture);
        let right = self.right.component_mul(&deviations);
        let mut precision = self.precision.clone();
        for (j, mut column) in precision.column_iter_mut().enumerate() {
            column.component_mul_assign(&deviations);
            column *= deviations[j];
            column[j] += 1.0;
        }
        (precision, right)
    }

    /// Logarithm of the evidence of an aperture; minus infinity where the teeth's precision is no positive matrix.
    pub fn log_evidence(&self, aperture: &Aperture) -> f64 {
        let (precision, right) = self.with_prior(aperture);
        log_evidence(precision, &right)
    }

    /// Deviations of the teeth under an aperture, in the tooth map's.
    fn deviations(&self, aperture: &Aperture) -> DVector<f64> {
        let [node, line] = aperture.deviations_m.map(|m| m / NODE_M);
        let of = |k, _| if k < self.nodes { node } else { line };
        DVector::from_fn(self.right.len(), of)
    }
}

/// A precision in blocks, and the same with teeth across, which half the aperture across and its edge determine.
pub struct Blocks {
    splines: Vec<Block>,
    across: Cache<[f64; 2], Vec<Block>>,
}

impl Blocks {
    /// Of some splines.
    pub fn of(splines: &Splines) -> Self {
        Self {
            splines: Block::all(&splines.precision, &splines.kinds()),
            across: Cache::new(),
        }
    }

    /// With teeth across under an aperture.
    fn across(&mut self, kernel: &ApertureKernel, weights: &[Weights; KINDS]) -> &[Block] {
        let each = self.splines.iter();
        let key = [kernel.half_pitches[1], kernel.edge];
        let make = || each.map(|block| block.across(weights)).collect();
        self.across.get(key, make)
    }
}

impl Teeth {
    /// Under an aperture.
    pub fn under(splines: &Splines, kernel: &ApertureKernel) -> Self {
        let windows = [0, 1].map(|k| in_splines(kernel, k, splines.per_pitch));
        let of = |d: usize, k: usize| {
            let (first, counts) = splines.rectangles[d];
            let half = kernel.half_pitches(k);
            shares(&windows[k], half, first[k], counts[k], splines.per_pitch)
        };
        let along = [0, 1].map(|d| {
            let mut teeth = of(d, 0);
            teeth.retain(|tooth| splines.told[d][tooth.splines()].contains(&true));
            teeth
        });
        let across = [0, 1].map(|d| of(d, 1));
        let told = splines.kinds();
        let weights = std::array::from_fn(|kind| {
            let (teeth, told) = (&along[kind % 2], &told[kind]);
            let weight = |spline: usize, tooth: usize| teeth[tooth].weight(told.along[spline]);
            let of_lines = || DMatrix::from_element(1, 1, 1.0);
            let of_nodes = || {
                let teeth = &across[kind];
                let weight = |tooth: usize, spline: usize| teeth[tooth].weight(spline);
                DMatrix::from_fn(teeth.len(), told.across, weight)
            };
            Weights {
                along: DMatrix::from_fn(told.along.len(), teeth.len(), weight),
                across: if kind < 2 { of_nodes() } else { of_lines() },
            }
        });
        Self {
            along: along.map(|teeth| teeth.iter().map(|share| share.tooth).collect()),
            first_across: across.map(|teeth| teeth.first().map_or(0, |share| share.tooth)),
            weights,
        }
    }

    /// The likeliest displacements, m, with the deviations of teeth that an aperture has. None where the precision is no positive matrix.
    pub fn likeliest(&self, splines: &Splines, aperture: &Aperture) -> Option<Vec<(Key, f64)>> {
        let told = self.told(splines, &mut Blocks::of(splines), &aperture.kernel);
        let (precision, right) = told.with_prior(aperture);
        let amounts = Factor::new(precision)?.solve(&right);
        let amounts_m = amounts.component_mul(&told.deviations(aperture)) * NODE_M;
        Some(
            self.keys()
                .into_iter()
                .zip(amounts_m.iter().copied())
                .collect(),
        )
    }

    /// Names of the teeth, in the order of [`OfTeeth`].
    fn keys(&self) -> Vec<Key> {
        let (mut nodes, mut lines) = (Vec::new(), Vec::new());
        for (d, first) in self.first_across.into_iter().enumerate() {
            for tooth in &self.along[d] {
                let row = (first..).take(self.weights[d].across.nrows());
                nodes.extend(row.map(|j| Key::Node(d as u8, [*tooth, j])));
                lines.push(Key::Line(d as u8, *tooth));
            }
        }
        nodes.extend(lines);
        nodes
    }

    /// What the data tell of the teeth, which are those under this kernel, by the precision in blocks.
    pub fn told(&self, splines: &Splines, blocks: &mut Blocks, kernel: &ApertureKernel) -> OfTeeth {
        let counts = self
            .weights
            .each_ref()
            .map(|of| of.along.ncols() * of.across.nrows());
        let firsts = std::array::from_fn(|kind| counts[..kind].iter().sum());
        let count = counts.iter().sum();
        let mut precision = DMatrix::zeros(count, count);
        for block in blocks.across(kernel, &self.weights) {
            block.along(&self.weights, &firsts, &mut precision);
        }
        let mut right = Vec::with_capacity(count);
        for (of, told) in self.weights.iter().zip(splines.kinds()) {
            let teeth = &of.across * told.of(splines.right.as_slice()) * &of.along;
            right.extend(teeth.iter());
        }
        OfTeeth {
            precision,
            right: right.into(),
            nodes: counts[0] + counts[1],
        }
    }

    /// Covariance of the splines' coefficients before the data, where all of them are told.
    #[cfg(test)]
    pub fn covariance(&self, splines: &Splines, aperture: &Aperture) -> DMatrix<f64> {
        let count = splines.right.len();
        let [node, line] = aperture.deviations_m.map(|m| m / NODE_M);
        let mut covariance = DMatrix::zeros(count, count);
        for (kind, (of, told)) in self.weights.iter().zip(splines.kinds()).enumerate() {
            let root =
                of.along.kronecker(&of.across.transpose()) * if kind < 2 { node } else { line };
            let mut own =
                covariance.view_mut((told.first, told.first), (root.nrows(), root.nrows()));
            own.copy_from(&(&root * root.transpose()));
        }
        covariance
    }
}

/// The teeth that are read somewhere between the second spline and the last but one of some.
fn shares(window: &[f64], half: f64, first: i32, count: usize, per_pitch: i32) -> Vec<Share> {
    let reach = window.len() as i32 / 2;
    let pitches = |spline: i32| f64::from(spline) / f64::from(per_pitch);
    let lowest = (pitches(first + 1) - half).ceil() as i32;
    let highest = (pitches(first + count as i32 - 2) + half).floor() as i32;
    let teeth = if count == 0 {
        0..0
    } else {
        lowest..highest + 1
    };
    let share = |tooth: i32| {
        let begin = tooth * per_pitch - reach - first;
        let before = begin.min(0).unsigned_abs() as usize;
        let from = begin.max(0) as usize;
        let weights = window.iter().skip(before);
        Share {
            tooth,
            from,
            weights: weights.take(count.saturating_sub(from)).copied().collect(),
        }
    };
    teeth.map(share).collect()
}

/// The splines that come nearest in the mean square to what a tooth adds to readings, about the one that stands at the tooth.
fn in_splines(kernel: &ApertureKernel, direction: usize, per_pitch: i32) -> Vec<f64> {
    /// Places between two splines at which products are summed. As was measured, twice as many change a coefficient of the narrowest box by 2e-4 of
    /// the largest half a pitch apart, and by 4e-3 a pitch apart; of a bell by 1e-5.
    const PLACES: i32 = 16;
    /// Splines on either side of the window's. Derived from how coefficients fall off beside it, by 0.27 from one to the next.
    const BESIDE: i32 = 4;
    let share = FieldKernel::Aperture(*kernel);
    let per = f64::from(per_pitch);
    let reach = (kernel.half_pitches(direction) * per).ceil() as i32 + BESIDE;
    let at = |k: i32| (f64::from(k) + 0.5) / f64::from(PLACES);
    let product = |of: i32, with: &dyn Fn(f64) -> f64| -> f64 {
        let places = -2 * PLACES..2 * PLACES;
        let each = places.map(|k| cubic_b_spline(at(k)) * with(at(k) + f64::from(of)));
        each.sum::<f64>()
    };
    let count = 2 * reach as usize + 1;
    let with_splines: Vec<f64> = (0..4).map(|of| product(of, &cubic_b_spline)).collect();
    let own = DMatrix::from_fn(count, count, |i, j| {
        with_splines.get(i.abs_diff(j)).copied().unwrap_or(0.0)
    });
    let right = (-reach..=reach).map(|of| product(of, &|x| share.weight(direction, x / per)));
    let right = DVector::from_iterator(count, right);
    Factor::new(own).map_or_else(Vec::new, |factor| factor.solve(&right).data.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What splines lack of a tooth, as a share of it: half a pitch apart less than 1 %, a pitch apart some percent.
    #[test]
    fn splines_come_near_to_a_tooth() {
        let kernel = ApertureKernel {
            half_pitches: [3.05, 2.5],
            edge: 0.98,
        };
        for (per_pitch, most) in [(2, 0.008), (1, 0.03)] {
            let window = in_splines(&kernel, 0, per_pitch);
            let reach = window.len() as f64 / 2.0 - 0.5;
            let [mut lacking, mut whole] = [0.0, 0.0];
            for k in -400..=400 {
                let place = f64::from(k) * 0.01;
                let at = place * f64::from(per_pitch);
                let each = window.iter().enumerate();
                let found: f64 = each
                    .map(|(m, c)| c * cubic_b_spline(at + reach - m as f64))
                    .sum();
                let wanted = FieldKernel::Aperture(kernel).weight(0, place);
                lacking += (found - wanted).powi(2);
                whole += wanted * wanted;
            }
            let share = (lacking / whole).sqrt();
            assert!(share < most && share > 0.1 * most, "{per_pitch}: {share}");
        }
    }

    /// What is told of teeth is what dense sums over their splines give, where the data tell two ends of a rectangle and nothing between.
    #[test]
    fn teeth_are_sums_of_the_splines_that_are_told() {
        let kernel = ApertureKernel {
            half_pitches: [1.2, 1.6],
            edge: 0.7,
        };
        let (first, counts) = ([-3, 5], [40, 7]);
        let mut splines = Splines::over([(first, counts), ([0; 2], [0; 2])], 2);
        let is_told = |i: usize| !(8..34).contains(&i);
        splines.told[0] = (0..counts[0]).map(is_told).collect();
        let nodes = counts[0] * counts[1];
        let along_of = |k: usize| if k < nodes { k / counts[1] } else { k - nodes };
        let count = splines.right.len();
        splines.precision = DMatrix::from_fn(count, count, |i, j| {
            let both = is_told(along_of(i)) && is_told(along_of(j));
            let number = (i * j + i + j) as f64;
            if both { number.sin() } else { 0.0 }
        });
        let windows = [0, 1].map(|k| in_splines(&kernel, k, 2));
        let weight = |k: usize, tooth: i32, spline: usize| {
            let away = first[k] + spline as i32 - 2 * tooth + windows[k].len() as i32 / 2;
            let away = usize::try_from(away).ok();
            away.and_then(|away| windows[k].get(away))
                .copied()
                .unwrap_or(0.0)
        };
        let dense = |key: &Key| {
            DVector::from_fn(count, |k, _| match key {
                Key::Node(0, [i, j]) if k < nodes => {
                    weight(0, *i, k / counts[1]) * weight(1, *j, k % counts[1])
                }
                Key::Line(0, i) if k >= nodes => weight(0, *i, k - nodes),
                _ => 0.0,
            })
        };
        let teeth = Teeth::under(&splines, &kernel);
        let keys = teeth.keys();
        let dense: Vec<DVector<f64>> = keys.iter().map(dense).collect();
        let told = teeth.told(&splines, &mut Blocks::of(&splines), &kernel);
        let told = told.precision;
        assert_eq!(told.ncols(), keys.len());
        for (j, of) in dense.iter().enumerate() {
            let column = &splines.precision * of;
            for (i, by) in dense.iter().enumerate().skip(j) {
                let wanted = by.dot(&column);
                assert!((told[(i, j)] - wanted).abs() < 1e-10, "{i} {j}");
            }
        }
        // Between the ends there are teeth of which nothing is told.
        let middle = |key: &Key| matches!(key, Key::Line(0, 9));
        assert!(!keys.iter().any(middle) && keys.contains(&Key::Line(0, 2)));
    }
}
