//! The segments as a hypothesis sees them: a wiring, a scale of all lengths along the teeth, a scale of the span.

use crate::products::Products;
use crate::readings::Readings;
use crate::wiring::Wiring;
use nalgebra::DVector;

/// Rows that a relation needs.
const ROWS: usize = 30;

/// A hypothesis about the segments.
#[derive(Clone, Debug)]
pub(crate) struct View<'a> {
    /// Which wire carries which segment.
    pub wiring: &'a Wiring,
    /// Columns that were recorded.
    pub has: [bool; 4],
    /// Stated span, m.
    pub span_m: Option<f64>,
    /// Outputs over true lengths.
    pub lengths: f64,
    /// True span over the stated one.
    pub span: f64,
}

impl View<'_> {
    /// Weights of the columns that make x, y (m) or theta (rad) of the segments, in a vector of `width`; `None` if they were not recorded.
    pub fn response(&self, response: usize, width: usize) -> Option<DVector<f64>> {
        let there = |j: usize| self.has[self.wiring.column[j]];
        let weights = match response {
            0 | 1 => {
                let pair = [response, response + 2];
                let count = pair.iter().filter(|j| there(**j)).count();
                (count > 0).then(|| {
                    let mut weights = [0.0; 4];
                    let each = 1.0 / count as f64 / self.lengths;
                    pair.iter().filter(|j| there(**j)).for_each(|j| weights[*j] = each);
                    weights
                })?
            }
            _ => {
                let pairs: Vec<usize> = [0, 1].into_iter().filter(|j| there(*j) && there(j + 2)).collect();
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
        if rows.len() < ROWS {
            return None;
        }
        let over = |column: &&Vec<f64>| -> Vec<f64> {
            rows.iter()
                .map(|&i| column.get(i).copied().unwrap_or(0.0))
                .collect()
        };
        let columns: Vec<Vec<f64>> = columns.iter().map(over).collect();
        let turns: Vec<Vec<f64>> = (0..4)
            .filter(|s| self.has(*s))
            .map(|s| columns[s].iter().map(|p| p / self.pitch_m).collect())
            .collect();
        let group: Vec<usize> = rows.iter().map(|&i| self.group[i]).collect();
        Some(Products::new(&group, &columns, &turns))
    }
}
