//! Symmetric matrices at half the memory: products of columns are the largest things that an estimation holds.

use nalgebra::{DMatrix, DVectorView};
use serde::{Deserialize, Serialize};
use std::ops::{AddAssign, Index, IndexMut, Range, SubAssign};

/// The lower triangle alone, column by column. In a file it is the list of these numbers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<f64>", into = "Vec<f64>")]
pub struct Symmetric {
    order: usize,
    values: Vec<f64>,
}

impl From<Symmetric> for Vec<f64> {
    fn from(matrix: Symmetric) -> Self {
        matrix.values
    }
}

impl TryFrom<Vec<f64>> for Symmetric {
    type Error = String;

    /// Of a triangle's numbers.
    fn try_from(values: Vec<f64>) -> Result<Self, String> {
        let order = ((2.0 * values.len() as f64).sqrt()) as usize;
        if order * (order + 1) / 2 == values.len() {
            return Ok(Self { order, values });
        }
        Err(format!(
            "found {} numbers, wanted those of a triangle: 1, 3, 6, 10, …",
            values.len()
        ))
    }
}

impl Symmetric {
    /// Nothing but zeros.
    #[must_use]
    pub fn zeros(order: usize) -> Self {
        Self {
            order,
            values: vec![0.0; order * (order + 1) / 2],
        }
    }

    /// Number of rows, and of columns.
    #[must_use]
    pub fn order(&self) -> usize {
        self.order
    }

    /// A column's elements from the diagonal on down.
    #[inline]
    pub fn below_mut(&mut self, column: usize) -> &mut [f64] {
        let start = self.start(column);
        &mut self.values[start..start + self.order - column]
    }

    /// A column's elements from the diagonal on down.
    #[must_use]
    #[inline]
    pub fn below(&self, column: usize) -> &[f64] {
        let start = self.start(column);
        &self.values[start..start + self.order - column]
    }

    /// Some rows and columns.
    #[must_use]
    pub fn block(&self, rows: &[usize], columns: &[usize]) -> DMatrix<f64> {
        DMatrix::from_fn(rows.len(), columns.len(), |a, b| {
            self[(rows[a], columns[b])]
        })
    }

    /// The quadratic form of amounts of some columns, those of all others being zero. Cost: half the square of their number.
    #[must_use]
    pub fn quadratic(&self, coefficients: impl IntoIterator<Item = (usize, f64)>) -> f64 {
        let mut coefficients: Vec<(usize, f64)> = coefficients.into_iter().collect();
        coefficients.sort_unstable_by_key(|(column, _)| *column);
        let (columns, values): (Vec<usize>, Vec<f64>) = coefficients.into_iter().unzip();
        let runs = consecutive(&columns);
        let mut sum = 0.0;
        for (at, run) in runs.iter().enumerate() {
            for k in run.clone() {
                let below = &self.values[self.start(columns[k])..];
                let part = |rows: Range<usize>| {
                    let first = columns[rows.start] - columns[k];
                    dot(&below[first..first + rows.len()], &values[rows])
                };
                let own = if k + 1 < run.end {
                    part(k + 1..run.end)
                } else {
                    0.0
                };
                let others: f64 = runs[at + 1..].iter().cloned().map(part).sum();
                sum += values[k] * (below[0] * values[k] + 2.0 * (own + others));
            }
        }
        sum
    }

    /// The matrix of which row and column `k` are those of number `place[k]` here. Cost: one look at each element.
    #[must_use]
    pub fn reordered(&self, place: &[usize]) -> Self {
        let mut out = Self::zeros(place.len());
        for (column, at) in place.iter().enumerate() {
            let slots = out.below_mut(column).iter_mut().zip(&place[column..]);
            slots.for_each(|(slot, row)| *slot = self[(*row, *at)]);
        }
        out
    }

    /// All elements zero again.
    pub fn clear(&mut self) {
        self.values.fill(0.0);
    }

    /// Takes the unit of a row and its column to be so many times smaller.
    pub fn rescale(&mut self, at: usize, factor: f64) {
        for k in 0..self.order {
            self[(at, k)] *= factor;
        }
        self[(at, at)] *= factor;
    }

    /// Divides all elements.
    pub fn divide(&mut self, by: f64) {
        self.values.iter_mut().for_each(|value| *value /= by);
    }

    /// Where a column's diagonal element is.
    #[inline]
    fn start(&self, column: usize) -> usize {
        column * (2 * self.order + 1 - column) / 2
    }

    #[inline]
    fn position(&self, (row, column): (usize, usize)) -> usize {
        let (high, low) = (row.max(column), row.min(column));
        self.start(low) + high - low
    }
}

/// Places of a list whose numbers follow one another.
pub(crate) fn consecutive(list: &[usize]) -> Vec<Range<usize>> {
    let mut runs: Vec<Range<usize>> = Vec::new();
    for (k, number) in list.iter().enumerate() {
        match runs.last_mut() {
            Some(run) if list[run.end - 1] + 1 == *number => run.end = k + 1,
            _ => runs.push(k..k + 1),
        }
    }
    runs
}

/// Product of two vectors. Several sums side by side: one alone would wait for every addition.
#[must_use]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    DVectorView::from_slice(a, a.len()).dot(&DVectorView::from_slice(b, b.len()))
}

impl Index<(usize, usize)> for Symmetric {
    type Output = f64;

    #[inline]
    fn index(&self, at: (usize, usize)) -> &f64 {
        &self.values[self.position(at)]
    }
}

impl IndexMut<(usize, usize)> for Symmetric {
    #[inline]
    fn index_mut(&mut self, at: (usize, usize)) -> &mut f64 {
        let position = self.position(at);
        &mut self.values[position]
    }
}

impl AddAssign<&Self> for Symmetric {
    fn add_assign(&mut self, other: &Self) {
        let pairs = self.values.iter_mut().zip(&other.values);
        pairs.for_each(|(sum, value)| *sum += value);
    }
}

impl SubAssign<&Self> for Symmetric {
    fn sub_assign(&mut self, other: &Self) {
        let pairs = self.values.iter_mut().zip(&other.values);
        pairs.for_each(|(rest, value)| *rest -= value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DVector;

    fn filled(order: usize) -> (Symmetric, DMatrix<f64>) {
        let mut packed = Symmetric::zeros(order);
        let mut whole = DMatrix::zeros(order, order);
        for column in 0..order {
            for (k, slot) in packed.below_mut(column).iter_mut().enumerate() {
                let value = (1 + column * order + k) as f64;
                *slot = value;
                whole[(column + k, column)] = value;
                whole[(column, column + k)] = value;
            }
        }
        (packed, whole)
    }

    #[test]
    fn every_element_is_where_the_whole_matrix_has_it() {
        for order in 1..7 {
            let (packed, whole) = filled(order);
            let all: Vec<usize> = (0..order).collect();
            assert_eq!(packed.block(&all, &all), whole);
        }
    }

    #[test]
    fn a_triangle_is_known_by_its_numbers() {
        for order in 0..7 {
            let (packed, _) = filled(order);
            let values: Vec<f64> = packed.clone().into();
            assert_eq!(Symmetric::try_from(values), Ok(packed));
        }
        assert!(
            Symmetric::try_from(vec![1.0; 4])
                .unwrap_err()
                .contains("4 numbers")
        );
    }

    #[test]
    fn the_quadratic_form_of_some_columns_is_that_of_the_whole_matrix() {
        let (packed, whole) = filled(7);
        for list in [vec![3], vec![0, 1, 2], vec![5, 2, 6, 3], vec![6, 4, 0, 2]] {
            let coefficients = list.iter().map(|c| (*c, 1.5 - *c as f64));
            let mut vector = DVector::zeros(7);
            coefficients.clone().for_each(|(c, a)| vector[c] = a);
            let wanted = vector.dot(&(&whole * &vector));
            let found = packed.quadratic(coefficients);
            assert!((found - wanted).abs() < 1e-12 * wanted.abs(), "{list:?}");
        }
        assert_eq!(packed.quadratic([]), 0.0);
    }

    #[test]
    fn rows_and_columns_are_reordered_together() {
        let (packed, whole) = filled(5);
        let place = [3, 0, 4, 1, 2];
        let all: Vec<usize> = (0..5).collect();
        let wanted = DMatrix::from_fn(5, 5, |a, b| whole[(place[a], place[b])]);
        assert_eq!(packed.reordered(&place).block(&all, &all), wanted);
    }

    #[test]
    fn a_row_and_its_column_are_rescaled_together() {
        let (mut packed, mut whole) = filled(5);
        packed.rescale(3, 0.5);
        whole.row_mut(3).scale_mut(0.5);
        whole.column_mut(3).scale_mut(0.5);
        assert_eq!(packed.block(&[0, 1, 2, 3, 4], &[0, 1, 2, 3, 4]), whole);
    }
}
