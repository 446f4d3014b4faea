//! Each pair's amplitude less what repeats with the own tooth phase.

use super::LinearizedRecording;
use super::covariates::multiples;
use crate::data::clip::tells_amplitude;
use std::collections::BTreeMap;

impl LinearizedRecording<'_> {
    /// Logarithm of the amplitude and its regressors over the unmodified phase, over which an offset is a pure first order: of its
    /// second power only a constant is left. A reading at a rail tells no amplitude.
    fn amplitude_row(
        &self,
        segment: usize,
        i: usize,
    ) -> Option<(nalgebra::SVector<f64, PATTERN_COLUMNS>, f64)> {
        let value = self.observations.amplitude_counts[segment][i].ln();
        let [sine, cosine] = *self.observations.pair_counts[segment].get(i)?;
        let phase = sine.atan2(cosine);
        let told = value.is_finite() && phase.is_finite();
        (told && tells_amplitude(self.observations, segment, i))
            .then(|| (self.pattern_orders(segment, phase), value))
    }

    /// Regressors of a pair's pattern. What is told of a pair with rails lies on arcs between them, which tell an ellipse and no more.
    fn pattern_orders(
        &self,
        segment: usize,
        phase: f64,
    ) -> nalgebra::SVector<f64, PATTERN_COLUMNS> {
        let mut orders = orders(phase);
        if self.observations.cut_figures[segment].is_some() {
            orders
                .rows_mut(ELLIPSE_COLUMNS, PATTERN_COLUMNS - ELLIPSE_COLUMNS)
                .fill(0.0);
        }
        orders
    }

    /// The pattern by what differs within a neighbourhood: the gap changes the amplitude from place to place, and a rest that shows
    /// one phase of one place is not to be taken for the pattern.
    pub(super) fn amplitude_pattern(&self, segment: usize) -> Vec<f64> {
        let n = self.observations.amplitude_counts[segment].len();
        let mut normal =
            nalgebra::SMatrix::<f64, PATTERN_COLUMNS, PATTERN_COLUMNS>::identity() * RIDGE;
        let mut right = nalgebra::SVector::<f64, PATTERN_COLUMNS>::zeros();
        let mut cells: BTreeMap<[i64; 2], Cell> = BTreeMap::new();
        for i in 0..n {
            let Some((x, y)) = self.amplitude_row(segment, i) else {
                continue;
            };
            normal += x * x.transpose();
            right += x * y;
            let cell = cells.entry(self.neighbourhood(i)).or_default();
            *cell = Cell {
                count: cell.count + 1.0,
                x: cell.x + x,
                y: cell.y + y,
            };
        }
        for cell in cells.values() {
            normal -= cell.x * cell.x.transpose() / cell.count;
            right -= cell.x * cell.y / cell.count;
        }
        let Some(mut pattern) = normal.cholesky().map(|factor| factor.solve(&right)) else {
            return Vec::new();
        };
        let means = cells.values().map(|c| (c.y - pattern.dot(&c.x)) / c.count);
        pattern[0] += means.sum::<f64>() / cells.len().max(1) as f64;
        if cells.is_empty() {
            return Vec::new();
        }
        pattern.iter().copied().collect()
    }

    /// A square over the platen.
    fn neighbourhood(&self, i: usize) -> [i64; 2] {
        let side_m = NEAR_PITCHES * self.observations.pitch_m;
        self.centre_m(i).map(|p| (p / side_m).floor() as i64)
    }

    /// What a pattern does not tell of it, one value a sample.
    pub(super) fn amplitude_excess(&self, segment: usize, pattern: &[f64]) -> Vec<f64> {
        if pattern.len() != PATTERN_COLUMNS {
            return Vec::new();
        }
        let n = self.observations.amplitude_counts[segment].len();
        let row = |i: usize| self.amplitude_row(segment, i);
        let pattern = vector(pattern);
        let left = |(x, y): (nalgebra::SVector<f64, PATTERN_COLUMNS>, f64)| y - x.dot(&pattern);
        (0..n).map(|i| row(i).map_or(0.0, left)).collect()
    }

    /// The same of a vector (sine, cosine) over the mean amplitude.
    pub(super) fn excess_of(&self, segment: usize, [sine, cosine]: [f64; 2]) -> f64 {
        let pattern = &self.normal.ln_amplitude[segment];
        let mean = pattern.first().copied().unwrap_or(0.0);
        let shape = orders(sine.atan2(cosine)).dot(&vector(pattern)) - mean;
        sine.hypot(cosine).ln() - shape
    }
}

fn vector(pattern: &[f64]) -> nalgebra::SVector<f64, PATTERN_COLUMNS> {
    nalgebra::SVector::from_column_slice(pattern)
}

/// Mean and orders up to eight of a phase.
fn orders(phase: f64) -> nalgebra::SVector<f64, PATTERN_COLUMNS> {
    let table = multiples::<9>(phase);
    let entry = |j: usize| {
        if j % 2 == 1 {
            table[j.div_ceil(2)].0
        } else {
            table[j / 2].1
        }
    };
    nalgebra::SVector::from_fn(|j, _| entry(j))
}

/// Regressors of an amplitude's pattern. A definition: a constant, and sine and cosine of eight orders.
const PATTERN_COLUMNS: usize = 17;
/// Those of them that an ellipse needs. Derived from its logarithm: with flaws of 0.02 its orders 1 and 2 are as large, 3 and 4 are
/// their squares, and 5 their cubes, below 1e-5.
const ELLIPSE_COLUMNS: usize = 9;
/// Side of a neighbourhood, pitches. Derived from a platen's flatness with waves of 15 to 90 mm, as `effects::gap_variation`
/// draws it: within a square of that side it varies by 0.13 of its rms.
const NEAR_PITCHES: f64 = 2.0;
/// Scatter of the amplitude within a neighbourhood over the pattern's own size, squared. A prior: a percent of scatter over some
/// four to five of the pattern's, as offsets and gains of such sizes make.
const RIDGE: f64 = 0.05;

/// Sums over a neighbourhood.
#[derive(Default)]
struct Cell {
    count: f64,
    x: nalgebra::SVector<f64, PATTERN_COLUMNS>,
    y: f64,
}
