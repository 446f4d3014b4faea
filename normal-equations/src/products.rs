//! Products of columns over rows, as they come, chunk by chunk.

use crate::symmetric::Symmetric;
use nalgebra::{DMatrixView, DMatrixViewMut, Dyn};

/// Rows that products are formed of, one after the other, and which of their columns are not zero throughout. The memory is used
/// again for the next ones.
pub struct RowBuffer {
    width: usize,
    values: Vec<f64>,
    /// Where the values of the sample at hand begin.
    newest: usize,
    active: Vec<bool>,
    /// The active columns alone, and some of their products.
    packed: Vec<f64>,
    part: Vec<f64>,
}

/// A product by itself costs this many times one among those of whole matrices. Cost alone: either way the sums are the same but
/// for their last digit.
pub(crate) const SCATTERED: usize = 6;
/// Columns whose products are formed at once. Cost alone: its products stay in the processor's cache.
const PANEL: usize = 160;

impl RowBuffer {
    /// For some rows of so many columns.
    #[must_use]
    pub fn new(width: usize, rows: usize) -> Self {
        Self {
            width,
            values: Vec::with_capacity(width * rows),
            newest: 0,
            active: vec![false; width],
            packed: Vec::with_capacity(width * rows),
            part: Vec::with_capacity(width * width.min(PANEL)),
        }
    }

    /// Takes all rows out.
    pub fn clear(&mut self) {
        self.values.clear();
        self.newest = 0;
        self.active.fill(false);
    }

    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.values.len() / self.width
    }

    /// Appends rows of zeros, which [`Self::set`] then fills.
    pub fn extend(&mut self, rows: usize) {
        self.newest = self.values.len();
        self.values.resize(self.newest + rows * self.width, 0.0);
    }

    /// A column's values in the newest rows, times a factor. There are none where a sample has no channel.
    pub fn set(&mut self, column: usize, values: &[f64], scale: f64) {
        let Some(from) = self.values.get_mut(self.newest + column..) else {
            return;
        };
        self.active[column] = true;
        let slots = from.iter_mut().step_by(self.width);
        for (slot, value) in slots.zip(values) {
            *slot = value * scale;
        }
    }

    /// Adds to a column's values in the newest rows, where several entries are of one column.
    pub fn add(&mut self, column: usize, values: &[f64], scale: f64) {
        let Some(from) = self.values.get_mut(self.newest + column..) else {
            return;
        };
        self.active[column] = true;
        let slots = from.iter_mut().step_by(self.width);
        for (slot, value) in slots.zip(values) {
            *slot += value * scale;
        }
    }

    /// Adds the products of the columns.
    pub fn add_products(&mut self, gram: &mut Symmetric) {
        let rows = self.rows();
        let list: Vec<usize> = (0..self.width).filter(|c| self.active[*c]).collect();
        let width = list.len();
        let filled = |row: &[f64]| list.iter().filter(|c| row[**c] != 0.0).count();
        let pairs = self.values.chunks(self.width).map(|row| filled(row).pow(2));
        if SCATTERED * pairs.sum::<usize>() < rows * width * width {
            self.add_scattered(&list, gram);
            return;
        }
        self.packed.clear();
        for row in self.values.chunks(self.width) {
            self.packed.extend(list.iter().map(|c| row[*c]));
        }
        let upright = DMatrixView::from_slice(&self.packed, width, rows);
        let used = DMatrixView::<f64, Dyn, Dyn>::from_slice_with_strides_generic(
            &self.packed,
            Dyn(rows),
            Dyn(width),
            Dyn(width),
            Dyn(1),
        );
        for first in (0..width).step_by(PANEL) {
            let size = PANEL.min(width - first);
            // Rows from the panel's first on: the lower triangle and the panel's own square.
            let rest = width - first;
            self.part.resize(rest * size, 0.0);
            let mut part = DMatrixViewMut::from_slice(&mut self.part, rest, size);
            part.gemm(
                1.0,
                &upright.rows(first, rest),
                &used.columns(first, size),
                0.0,
            );
            for k in 0..size {
                let at = list[first + k];
                let column = gram.below_mut(at);
                for r in k..rest {
                    column[list[first + r] - at] += part[(r, k)];
                }
            }
        }
    }

    /// The same where each row has few columns, and other ones than most.
    fn add_scattered(&self, list: &[usize], gram: &mut Symmetric) {
        let mut filled: Vec<(usize, f64)> = Vec::with_capacity(list.len());
        for row in self.values.chunks(self.width) {
            filled.clear();
            let there = list.iter().map(|c| (*c, row[*c]));
            filled.extend(there.filter(|(_, value)| *value != 0.0));
            for (k, &(at, value)) in filled.iter().enumerate() {
                let column = gram.below_mut(at);
                for &(other, factor) in &filled[k..] {
                    column[other - at] += value * factor;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    #[test]
    fn rows_of_few_columns_add_what_rows_of_many_do() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let (mut once, mut packed) = (RowBuffer::new(60, 40), Symmetric::zeros(60));
        let mut wanted = Symmetric::zeros(60);
        for row in 0..40 {
            once.extend(1);
            let mut values = [0.0; 60];
            for c in [row % 57, row % 57 + 1, row % 57 + 2, 59] {
                values[c] = StandardNormal.sample(&mut rng);
                once.set(c, &values[c..=c], 2.0);
            }
            for a in 0..60 {
                for b in a..60 {
                    wanted.below_mut(a)[b - a] += 4.0 * values[a] * values[b];
                }
            }
        }
        once.add_products(&mut packed);
        for a in 0..60 {
            for b in 0..=a {
                assert!((packed[(a, b)] - wanted[(a, b)]).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn a_sample_without_rows_adds_nothing() {
        let mut rows = RowBuffer::new(3, 4);
        for (count, value) in [(2, 1.0), (0, 9.0), (1, 2.0)] {
            rows.extend(count);
            rows.set(1, &[value, value], 1.0);
            rows.add(2, &[value, value], 1.0);
            rows.add(2, &[value, value], 2.0);
        }
        let mut gram = Symmetric::zeros(3);
        rows.add_products(&mut gram);
        assert_eq!((rows.rows(), gram[(1, 1)], gram[(2, 1)]), (3, 6.0, 18.0));
    }
}
