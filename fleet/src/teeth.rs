//! Teeth under an aperture, as sums of splines: what the data tell of the splines they tell of the teeth.

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
    along: [Vec<Share>; 2],
    /// Across: a row for each tooth, a column for each spline.
    across: [DMatrix<f64>; 2],
    /// The first tooth across of each.
    first_across: [i32; 2],
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

    /// The sum of amounts of all splines, by its weights.
    fn of(&self, amounts: &[f64]) -> f64 {
        let each = self.weights.iter().zip(&amounts[self.from..]);
        each.map(|(weight, amount)| weight * amount).sum()
    }
}

/// Adds so many times some amounts to a sum of as many.
fn add(sum: &mut [f64], times: f64, amounts: &[f64]) {
    let each = sum.iter_mut().zip(amounts);
    each.for_each(|(sum, amount)| *sum += times * amount);
}

/// What the data tell of teeth, in the tooth map's prior deviations: single ones first, then whole lines.
pub struct OfTeeth {
    precision: DMatrix<f64>,
    right: DVector<f64>,
    /// How many of them are single teeth.
    nodes: usize,
}

impl OfTeeth {
    /// Precision and right side of the teeth, each in its own deviation under an aperture, with that of their prior. Cost: the square of their
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

impl Teeth {
    /// Under an aperture.
    pub fn under(splines: &Splines, kernel: &ApertureKernel) -> Self {
        let windows = [0, 1].map(|k| in_splines(kernel, k, splines.per_pitch));
        let of = |d: usize, k: usize| {
            let (first, counts) = splines.rectangles[d];
            let half = kernel.half_pitches(k);
            shares(&windows[k], half, first[k], counts[k], splines.per_pitch)
        };
        let along = |d: usize| {
            let is_told = |tooth: &Share| splines.told[d][tooth.splines()].contains(&true);
            of(d, 0).into_iter().filter(is_told).collect()
        };
        let across = |d: usize| {
            let (teeth, count) = (of(d, 1), splines.rectangles[d].1[1]);
            let first = teeth.first().map_or(0, |share| share.tooth);
            let weight = |tooth: usize, spline: usize| teeth[tooth].weight(spline);
            (first, DMatrix::from_fn(teeth.len(), count, weight))
        };
        let [x, y] = [0, 1].map(across);
        Self {
            along: [0, 1].map(along),
            first_across: [x.0, y.0],
            across: [x.1, y.1],
        }
    }

    /// The likeliest displacements, m, with the deviations of teeth that an aperture has. None where the precision is no positive matrix.
    pub fn likeliest(&self, splines: &Splines, aperture: &Aperture) -> Option<Vec<(Key, f64)>> {
        let told = self.told(splines);
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
                let row = (first..).take(self.across[d].nrows());
                nodes.extend(row.map(|j| Key::Node(d as u8, [tooth.tooth, j])));
                lines.push(Key::Line(d as u8, tooth.tooth));
            }
        }
        nodes.extend(lines);
        nodes
    }

    /// What the data tell of the teeth. Cost: for each number of the splines' precision about as many products as a tooth is splines wide.
    pub fn told(&self, splines: &Splines) -> OfTeeth {
        let half = self.of_teeth(&splines.precision, splines);
        let mut right = DVector::zeros(half.nrows());
        self.of_column(splines.right.as_slice(), right.as_mut_slice(), splines);
        OfTeeth {
            precision: self.of_teeth(&half.transpose(), splines),
            right,
            nodes: self.nodes(),
        }
    }

    /// Number of single teeth.
    fn nodes(&self) -> usize {
        let each = self.along.iter().zip(&self.across);
        each.map(|(along, across)| along.len() * across.nrows())
            .sum()
    }

    /// Products of each tooth with columns over the splines.
    fn of_teeth(&self, columns: &DMatrix<f64>, splines: &Splines) -> DMatrix<f64> {
        let lines: usize = self.along.iter().map(Vec::len).sum();
        let mut all = DMatrix::zeros(self.nodes() + lines, columns.ncols());
        for (of, mut to) in columns.column_iter().zip(all.column_iter_mut()) {
            if of.iter().any(|amount| *amount != 0.0) {
                self.of_column(of.as_slice(), to.as_mut_slice(), splines);
            }
        }
        all
    }

    /// Products of each tooth with one column, into zeros.
    fn of_column(&self, of: &[f64], to: &mut [f64], splines: &Splines) {
        let (mut rest, mut to) = (of, to);
        for (d, (_, [n, m])) in splines.rectangles.iter().enumerate() {
            let nodes;
            (nodes, rest) = rest.split_at(n * m);
            let mut row = vec![0.0; *m];
            for tooth in &self.along[d] {
                row.fill(0.0);
                let told = tooth.splines().zip(&tooth.weights);
                for (spline, weight) in told.filter(|(spline, _)| splines.told[d][*spline]) {
                    add(&mut row, *weight, &nodes[spline * m..][..*m]);
                }
                let teeth;
                (teeth, to) = to.split_at_mut(self.across[d].nrows());
                for (amount, weights) in row.iter().zip(self.across[d].column_iter()) {
                    add(teeth, *amount, weights.as_slice());
                }
            }
        }
        let mut to = to.iter_mut();
        for (along, (_, [n, _])) in self.along.iter().zip(&splines.rectangles) {
            let lines;
            (lines, rest) = rest.split_at(*n);
            for (tooth, to) in along.iter().zip(&mut to) {
                *to = tooth.of(lines);
            }
        }
    }

    /// Covariance of the splines' coefficients before the data.
    #[cfg(test)]
    pub fn covariance(&self, splines: &Splines, aperture: &Aperture) -> DMatrix<f64> {
        let count = splines.right.len();
        let root = self.of_teeth(&DMatrix::identity(count, count), splines);
        let deviations = self.told(splines).deviations(aperture);
        root.transpose() * DMatrix::from_diagonal(&deviations.map(|d| d * d)) * root
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
        let told = teeth.told(&splines).precision;
        assert_eq!(told.ncols(), keys.len());
        for (j, of) in dense.iter().enumerate() {
            let column = &splines.precision * of;
            for (i, by) in dense.iter().enumerate() {
                let wanted = by.dot(&column);
                assert!((told[(i, j)] - wanted).abs() < 1e-10, "{i} {j}");
            }
        }
        // Between the ends there are teeth of which nothing is told.
        let middle = |key: &Key| matches!(key, Key::Line(0, 9));
        assert!(!keys.iter().any(middle) && keys.contains(&Key::Line(0, 2)));
    }
}
