//! The segments as a hypothesis sees them: a wiring, a scale of all lengths along the teeth, a scale of the span.

use crate::products::{self, Products};
use crate::readings::Readings;
use crate::wiring::Wiring;
use nalgebra::DVector;

/// What a relation of right readings leaves, rms, as a share of the pitch. Derived from effects of 20 noise floors (0.3 µm each),
/// which are left once the periodic errors of equation (3) are out: 6 µm of a millimetre.
pub(crate) const CLOSURE_TOLERANCE: f64 = 0.006;
/// What another wiring, or another way to read sine and cosine, leaves is far smaller from this ratio on.
pub(crate) const CLOSURE_RATIO: f64 = 3.0;
/// Rows that a relation needs.
/// Derived from an rms's scatter: of so many it is known to 13 %.
const FEWEST_ROWS: usize = 30;

/// A hypothesis about the segments.
#[derive(Clone, Debug)]
pub(crate) struct View<'a> {
    /// Which wire carries which segment.
    pub wiring: &'a Wiring,
    /// Columns that were recorded.
    pub has: [bool; 4],
    /// Stated span, m.
    pub span_m: Option<f64>,
    /// How inexact the segments are, by what they contradict one another, m.
    pub inexact_m: f64,
    /// True where outputs were logged as positions.
    pub logged: bool,
    /// True tooth pitch, m.
    pub tooth_m: f64,
    /// Outputs over true lengths.
    pub lengths: f64,
    /// True span over the stated one.
    pub span: f64,
}

impl View<'_> {
    /// How inexact the segments' angle is, rad, where readings have periodic errors of so many metres besides.
    pub fn angle_error_rad(&self, periodic_m: f64) -> f64 {
        self.span_m.map_or(f64::INFINITY, |span_m| {
            self.inexact_m.max(periodic_m) / (self.lengths * self.span * span_m)
        })
    }

    /// Weights of the segments that make x (0) or y (1), m: the mean of a pair, or the one segment of it that was recorded, less what
    /// half the span makes of the other pair's angle; by equation (5) segments j and j + 2 stand that far on either side of the middle.
    fn along(&self, axis: usize, there: impl Fn(usize) -> bool) -> Option<[f64; 4]> {
        let mut weights = [0.0; 4];
        let whole = 1.0 / self.lengths;
        match [there(axis), there(axis + 2)] {
            [false, false] => return None,
            [true, true] => (weights[axis], weights[axis + 2]) = (0.5 * whole, 0.5 * whole),
            [first, _] => {
                let (segment, side) = if first { (axis, 1.0) } else { (axis + 2, -1.0) };
                weights[segment] = whole;
                let other = 1 - axis;
                if there(other) && there(other + 2) {
                    weights[other] = -0.5 * side * whole;
                    weights[other + 2] = 0.5 * side * whole;
                }
            }
        }
        Some(weights)
    }

    /// Weights of the columns that make x, y (m) or theta (rad) of the segments, in a vector of `width`; `None` if they were not recorded.
    pub fn response(&self, response: usize, width: usize) -> Option<DVector<f64>> {
        let there = |j: usize| self.has[self.wiring.column[j]];
        let weights = match response {
            0 | 1 => self.along(response, there)?,
            _ => {
                let pairs: Vec<usize> = [0, 1]
                    .into_iter()
                    .filter(|j| there(*j) && there(j + 2))
                    .collect();
                let span_m = self.span_m?;
                let each = 1.0 / pairs.len() as f64 / (self.lengths * self.span * span_m);
                (!pairs.is_empty()).then(|| {
                    let mut weights = [0.0; 4];
                    for j in pairs {
                        weights[j] = each;
                        weights[j + 2] = -each;
                    }
                    weights
                })?
            }
        };
        let mut wide = DVector::zeros(width);
        for (column, weight) in self.wiring.combine(weights).into_iter().enumerate() {
            wide[column] = weight;
        }
        Some(wide)
    }
}

impl Readings {
    /// Products of columns over rows; the first four are the segments (empty where not recorded: a column of zeros). `None` with too few rows.
    pub fn products(&self, rows: &[usize], columns: &[&Vec<f64>]) -> Option<Products> {
        if rows.len() < FEWEST_ROWS {
            return None;
        }
        let columns: Vec<Vec<f64>> = columns.iter().map(|c| over(rows, c)).collect();
        let (group, turns) = self.phases(rows);
        Some(Products::new(&group, &columns, &turns))
    }

    /// What is left of a combination of the segments over rows once zeros and periodic errors are out: row and metres.
    pub fn residual(&self, rows: &[usize], weights: [f64; 4]) -> Vec<(usize, f64)> {
        if rows.len() < FEWEST_ROWS {
            return Vec::new();
        }
        let value = |&i: &usize| {
            (0..4)
                .map(|s| weights[s] * self.position_m[s][i])
                .sum::<f64>()
        };
        let column: Vec<f64> = rows.iter().map(value).collect();
        let (group, turns) = self.phases(rows);
        let residual = products::residual(&group, &column, &turns);
        rows.iter().copied().zip(residual).collect()
    }

    /// Group and tooth phases, in turns, of rows.
    fn phases(&self, rows: &[usize]) -> (Vec<usize>, Vec<Vec<f64>>) {
        let turns = (0..4)
            .filter(|s| self.has(*s))
            .map(|s| {
                rows.iter()
                    .map(|&i| self.position_m[s][i] / self.pitch_m)
                    .collect()
            })
            .collect();
        (rows.iter().map(|&i| self.group[i]).collect(), turns)
    }
}

/// A column over rows; zeros where it was not recorded.
fn over(rows: &[usize], column: &[f64]) -> Vec<f64> {
    rows.iter()
        .map(|&i| column.get(i).copied().unwrap_or(0.0))
        .collect()
}
