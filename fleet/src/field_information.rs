//! What one recording says of the field alone, all else eliminated: two such say together whether they are of the same teeth, and by how
//! many whole teeth their counts differ.

use crate::key::{Key, Platen};
use crate::state::State;
use crate::sums::Sums;
use nalgebra::{DMatrix, DVector};
use normal_equations::cholesky::Factor;

/// Precision and right side of the nodes and lines of both fields, without their priors, in deviations of these.
#[derive(Clone, Debug)]
pub struct FieldInformation {
    keys: Vec<Key>,
    precision: DMatrix<f64>,
    right: DVector<f64>,
    /// Logarithm of the evidence but for the field's part and what all hypotheses have in common.
    log_rest: f64,
}

impl FieldInformation {
    /// Of sums at a state, about a field of zero. None where they make no positive matrix.
    ///
    /// With P the precision that is left, r the right side and x the field of the state, the logarithm of the likelihood of a field f is
    /// r (f - x) - (f - x) P (f - x) / 2, and so (r + P x) f - f P f / 2 less r x + x P x / 2.
    #[must_use]
    pub fn of(platen: &Platen, sums: &Sums, state: &State) -> Option<Self> {
        let is_field = |key: &Key| matches!(key, Key::Node(..) | Key::Line(..));
        let places = |field: bool| -> Vec<usize> {
            let all = sums.columns.iter().enumerate();
            let those = all.filter(|(_, (key, _))| is_field(key) == field);
            those.map(|(k, _)| k).collect()
        };
        let (field, rest) = (places(true), places(false));
        let mut own = sums.gram.block(&rest, &rest);
        (0..rest.len()).for_each(|k| own[(k, k)] += 1.0);
        let right = DVector::from_fn(rest.len(), |k, _| {
            let (key, prior) = &sums.columns[rest[k]];
            sums.right[rest[k]] + (prior.mean - state.value(platen, key)) / prior.deviation
        });
        let factor = Factor::new(own)?;
        let log_determinant = factor.half_log_determinant();
        let half = factor.lower_inverse();
        let with = &half * sums.gram.block(&rest, &field);
        let forward = half * right;
        let of_field = DVector::from_fn(field.len(), |k, _| sums.right[field[k]]);
        let left = of_field - with.tr_mul(&forward);
        // Not tr_mul, which goes element by element.
        let precision = sums.gram.block(&field, &field) - with.transpose() * &with;
        let at = DVector::from_fn(field.len(), |k, _| {
            let (key, prior) = &sums.columns[field[k]];
            state.value(platen, key) / prior.deviation
        });
        let moved = &precision * &at;
        let log_moved = left.dot(&at) + 0.5 * at.dot(&moved);
        Some(Self {
            keys: field.iter().map(|k| sums.columns[*k].0.clone()).collect(),
            precision,
            right: left + moved,
            log_rest: 0.5 * forward.norm_squared() - log_determinant - log_moved,
        })
    }

    /// The unknowns that it is of.
    #[must_use]
    pub fn keys(&self) -> &[Key] {
        &self.keys
    }

    /// Precision of the field that the data leave, in deviations of the priors.
    #[must_use]
    pub fn precision(&self) -> &DMatrix<f64> {
        &self.precision
    }

    /// The precision times the field that the data ask for.
    #[must_use]
    pub fn right(&self) -> &DVector<f64> {
        &self.right
    }

    /// The same over teeth that are counted so many higher along x and y.
    #[must_use]
    pub fn shifted(mut self, teeth: [i32; 2]) -> Self {
        for key in &mut self.keys {
            match key {
                Key::Node(direction, [along, across]) => {
                    *along += teeth[usize::from(*direction)];
                    *across += teeth[1 - usize::from(*direction)];
                }
                Key::Line(direction, along) => *along += teeth[usize::from(*direction)],
                _ => (),
            }
        }
        self
    }

    /// Of both, over the same teeth.
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        let mut keys: Vec<Key> = self.keys.iter().chain(&other.keys).cloned().collect();
        keys.sort();
        keys.dedup();
        let mut precision = DMatrix::zeros(keys.len(), keys.len());
        let mut right = DVector::zeros(keys.len());
        for part in [self, other] {
            let place = |key: &Key| keys.binary_search(key).unwrap_or(0);
            let places: Vec<usize> = part.keys.iter().map(place).collect();
            for (j, column) in places.iter().enumerate() {
                right[*column] += part.right[j];
                for (i, row) in places.iter().enumerate() {
                    precision[(*row, *column)] += part.precision[(i, j)];
                }
            }
        }
        Self {
            keys,
            precision,
            right,
            log_rest: self.log_rest + other.log_rest,
        }
    }

    /// What is told about some of the unknowns: the others are integrated out under their priors. None where that is no positive matrix.
    #[must_use]
    pub fn of_those(self, is_kept: impl Fn(&Key) -> bool) -> Option<Self> {
        let (kept, rest): (Vec<usize>, Vec<usize>) =
            (0..self.keys.len()).partition(|k| is_kept(&self.keys[*k]));
        if rest.is_empty() {
            return Some(self);
        }
        let block = |rows: &[usize], columns: &[usize]| {
            self.precision.select_rows(rows).select_columns(columns)
        };
        let own = block(&rest, &rest) + DMatrix::identity(rest.len(), rest.len());
        let factor = Factor::new(own)?;
        let log_determinant = factor.half_log_determinant();
        let half = factor.lower_inverse();
        let with = &half * block(&rest, &kept);
        let forward = half * self.right.select_rows(&rest);
        // Not tr_mul, which goes element by element.
        let precision = block(&kept, &kept) - with.transpose() * &with;
        Some(Self {
            precision,
            right: self.right.select_rows(&kept) - with.tr_mul(&forward),
            log_rest: self.log_rest + 0.5 * forward.norm_squared() - log_determinant,
            keys: kept.into_iter().map(|k| self.keys[k].clone()).collect(),
        })
    }

    /// Of products, with nothing beside the field.
    #[cfg(test)]
    pub fn of_products(keys: Vec<Key>, precision: DMatrix<f64>, right: DVector<f64>) -> Self {
        Self {
            keys,
            precision,
            right,
            log_rest: 0.0,
        }
    }

    /// Logarithm of the evidence, but for what all hypotheses about the same poses have in common: of sums with unit normal priors it is
    /// half of what is explained, less half the logarithm of the determinant.
    #[must_use]
    pub fn log_evidence(&self) -> f64 {
        let mut precision = self.precision.clone();
        (0..self.keys.len()).for_each(|k| precision[(k, k)] += 1.0);
        let Some(factor) = Factor::new(precision) else {
            return f64::NEG_INFINITY;
        };
        let explained = self.right.dot(&factor.solve(&self.right));
        self.log_rest + 0.5 * explained - factor.half_log_determinant()
    }
}
