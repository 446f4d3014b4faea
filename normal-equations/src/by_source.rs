//! Products of columns that are one number a sample, times one of a few vectors that each sample has.
//!
//! A column that acts on one reading adds to all rows of a sample, by the derivatives of the rows by that reading: its *source*. Of
//! two columns only the product of their sources' vectors counts, so that a sample costs one multiplication for each pair of columns,
//! where whole rows would cost one for each row. Sources whose vectors stand at right angles throughout cost nothing.

use crate::cholesky::BLOCK;
use crate::products;
use crate::symmetric::{Symmetric, consecutive, dot};
use nalgebra::{DMatrixView, DMatrixViewMut, Dyn};

/// Of so few rows or columns a matrix is no faster than its products one by one: that was measured for nalgebra, whose own bound
/// is 5 as well. Cost alone: the sums are the same.
const FEW: usize = 5;

/// Columns of some samples, and the memory that their products need: it is used again for the next samples.
pub struct SourceBuffer {
    samples: usize,
    sources: Vec<Source>,
    weighted: Vec<f64>,
    part: Vec<f64>,
    filled: Vec<Vec<(usize, f64)>>,
}

/// The columns of one source.
#[derive(Clone, Debug, Default)]
struct Source {
    columns: Vec<usize>,
    /// `[column, sample]`.
    values: Vec<f64>,
}

/// Products of the vectors of two sources, sample by sample.
struct Pair {
    sources: [usize; 2],
    products: Vec<f64>,
}

impl SourceBuffer {
    /// For so many sources.
    #[must_use]
    pub fn new(sources: usize) -> Self {
        Self {
            samples: 0,
            sources: vec![Source::default(); sources],
            weighted: Vec::new(),
            part: Vec::new(),
            filled: Vec::new(),
        }
    }

    /// Takes all columns out and begins with so many samples.
    pub fn begin(&mut self, samples: usize) {
        self.samples = samples;
        for source in &mut self.sources {
            source.columns.clear();
            source.values.clear();
        }
    }

    /// Adds a column's values of one source, one a sample; a column that is zero throughout is left out. Columns may have several
    /// sources, and each of them once; those of one source come in ascending order.
    pub fn push(&mut self, source: usize, column: usize, values: impl Iterator<Item = f64>) {
        let Source {
            columns,
            values: all,
        } = &mut self.sources[source];
        let before = all.len();
        all.extend(values);
        assert_eq!(all.len() - before, self.samples, "one value a sample");
        if all[before..].iter().all(|value| *value == 0.0) {
            all.truncate(before);
        } else {
            let ascends = columns.last().is_none_or(|last| *last < column);
            assert!(ascends, "the columns of a source ascend");
            columns.push(column);
        }
    }

    /// Adds the products of the columns. `product` is told a sample and two sources, the first not above the second.
    pub fn add_products(
        &mut self,
        product: impl Fn(usize, usize, usize) -> f64,
        gram: &mut Symmetric,
    ) {
        let used = |s: &usize| !self.sources[*s].columns.is_empty();
        let used: Vec<usize> = (0..self.sources.len()).filter(used).collect();
        let mut pairs: Vec<Pair> = Vec::new();
        for (k, &s) in used.iter().enumerate() {
            for &t in &used[k..] {
                let products: Vec<f64> = (0..self.samples).map(|i| product(i, s, t)).collect();
                if products.iter().any(|p| *p != 0.0) {
                    let sources = [s, t];
                    pairs.push(Pair { sources, products });
                }
            }
        }
        if self.is_scattered(&pairs) {
            self.add_scattered(&pairs, gram);
            return;
        }
        for pairs in pairs.chunk_by(|a, b| a.sources[0] == b.sources[0]) {
            self.add_dense(pairs, gram);
        }
    }

    /// True if each sample has few columns, and other ones than most.
    fn is_scattered(&self, pairs: &[Pair]) -> bool {
        let counts = |source: &Source| {
            let mut counts = vec![0; self.samples];
            for column in source.values.chunks(self.samples.max(1)) {
                let filled = counts.iter_mut().zip(column);
                filled.for_each(|(count, value)| *count += usize::from(*value != 0.0));
            }
            counts
        };
        let counts: Vec<Vec<usize>> = self.sources.iter().map(counts).collect();
        let columns = |s: usize| self.sources[s].columns.len();
        let (mut scattered, mut dense) = (0, 0);
        for [s, t] in pairs.iter().map(|pair| pair.sources) {
            // Twice the products: within a source each pair of columns is formed once.
            let both = if s == t { 1 } else { 2 };
            let of_samples = counts[s].iter().zip(&counts[t]).map(|(a, b)| a * b);
            scattered += both * of_samples.sum::<usize>();
            dense += both * columns(s) * columns(t) * self.samples;
        }
        products::SCATTERED * scattered < dense
    }

    /// The products of one source with itself and with those after it.
    fn add_dense(&mut self, pairs: &[Pair], gram: &mut Symmetric) {
        let samples = self.samples;
        let first_source = &self.sources[pairs[0].sources[0]];
        self.weighted.clear();
        let mut ids: Vec<usize> = Vec::new();
        for Pair {
            sources: [_, other],
            products,
        } in pairs
        {
            let other = &self.sources[*other];
            ids.extend(&other.columns);
            for column in other.values.chunks(samples) {
                let weighted = column.iter().zip(products).map(|(v, p)| v * p);
                self.weighted.extend(weighted);
            }
        }
        let runs = consecutive(&ids);
        let own = first_source.columns.len();
        for first in (0..own).step_by(BLOCK) {
            let size = BLOCK.min(own - first);
            // From the panel's first on: the lower triangle and the panel's own square.
            let rest = ids.len() - first;
            let right = &first_source.values[first * samples..(first + size) * samples];
            self.part.resize(rest * size, 0.0);
            multiply(
                &self.weighted[first * samples..],
                right,
                samples,
                &mut self.part,
            );
            for (k, products) in self.part.chunks(rest).enumerate() {
                for run in runs.iter().filter(|run| run.end > first + k) {
                    let run = run.start.max(first + k)..run.end;
                    let products = &products[run.start - first..run.end - first];
                    add_run(
                        gram,
                        ids[first + k],
                        ids[run.start],
                        products,
                        k + first == run.start,
                    );
                }
            }
        }
    }

    /// The same, sample by sample.
    fn add_scattered(&mut self, pairs: &[Pair], gram: &mut Symmetric) {
        let sources = self.sources.len();
        self.filled.resize(self.samples * sources, Vec::new());
        self.filled.iter_mut().for_each(Vec::clear);
        for (s, source) in self.sources.iter().enumerate() {
            let columns = source.values.chunks(self.samples.max(1));
            for (column, values) in source.columns.iter().zip(columns) {
                for (i, value) in values.iter().enumerate().filter(|v| *v.1 != 0.0) {
                    self.filled[i * sources + s].push((*column, *value));
                }
            }
        }
        for i in 0..self.samples {
            for Pair {
                sources: [s, t],
                products,
            } in pairs
            {
                let [a, b] = [s, t].map(|s| &self.filled[i * sources + s]);
                for (k, (column, value)) in a.iter().enumerate() {
                    let by = value * products[i];
                    if s == t {
                        // Each pair once: the others of this source stand below the column's diagonal element.
                        let below = gram.below_mut(*column);
                        let others = a[k..].iter();
                        others.for_each(|(other, factor)| below[other - column] += by * factor);
                    } else {
                        let each = b.iter();
                        each.for_each(|(other, factor)| {
                            add_run(gram, *column, *other, &[by * factor], false);
                        });
                    }
                }
            }
        }
    }
}

/// Products of the columns of two matrices of so many rows each, `out[right, left]`.
fn multiply(left: &[f64], right: &[f64], rows: usize, out: &mut [f64]) {
    let (rest, size) = (left.len() / rows, right.len() / rows);
    if [rest, size, rows].into_iter().min() <= Some(FEW) {
        for (out, right) in out.chunks_mut(rest).zip(right.chunks(rows)) {
            let products = left.chunks(rows).map(|left| dot(left, right));
            out.iter_mut().zip(products).for_each(|(out, p)| *out = p);
        }
        return;
    }
    let left = DMatrixView::<f64, Dyn, Dyn>::from_slice_with_strides_generic(
        left,
        Dyn(rest),
        Dyn(rows),
        Dyn(rows),
        Dyn(1),
    );
    let right = DMatrixView::from_slice(right, rows, size);
    DMatrixViewMut::from_slice(out, rest, size).gemm(1.0, &left, &right, 0.0);
}

/// Adds the products of a column with columns that follow one another from `from` on; `is_itself` if the first of these is the
/// column by the same source. By another source it counts twice: each of the two with the other.
#[inline]
fn add_run(gram: &mut Symmetric, column: usize, from: usize, products: &[f64], is_itself: bool) {
    if from > column || from == column && is_itself {
        let slots = &mut gram.below_mut(column)[from - column..][..products.len()];
        slots.iter_mut().zip(products).for_each(|(s, p)| *s += p);
        return;
    }
    for (other, product) in (from..).zip(products) {
        let times = if other == column { 2.0 } else { 1.0 };
        let (low, high) = (column.min(other), column.max(other));
        gram.below_mut(low)[high - low] += times * product;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::products::RowBuffer;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    const SOURCES: usize = 4;
    const ROWS: usize = 3;

    /// Products by sources and by whole rows, where each sample has only some of the columns.
    fn both(width: usize, samples: usize, acts: impl Fn(usize, usize) -> bool) -> [Symmetric; 2] {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let mut normal = || -> f64 { StandardNormal.sample(&mut rng) };
        // The last source stands at right angles to all others.
        let vector = |s: usize, normal: &mut dyn FnMut() -> f64| {
            std::array::from_fn(|row| {
                if (s == SOURCES - 1) == (row == 0) {
                    normal()
                } else {
                    0.0
                }
            })
        };
        let vectors: Vec<[[f64; ROWS]; SOURCES]> = (0..samples)
            .map(|_| std::array::from_fn(|s| vector(s, &mut normal)))
            .collect();
        let mut buffer = SourceBuffer::new(SOURCES);
        buffer.begin(samples);
        let mut rows = RowBuffer::new(width, samples * ROWS);
        let mut whole = vec![vec![[0.0; ROWS]; width]; samples];
        for column in 0..width {
            // Every eleventh column has two sources, and some stand among those of an earlier one.
            let one = [column * SOURCES / width, (column + 1) % SOURCES];
            let count = if column % 11 == 0 { 2 } else { 1 };
            for source in one.into_iter().take(count) {
                let value = |i: usize| if acts(i, column) { normal() } else { 0.0 };
                let values: Vec<f64> = (0..samples).map(value).collect();
                for (i, value) in values.iter().enumerate() {
                    for row in 0..ROWS {
                        whole[i][column][row] += value * vectors[i][source][row];
                    }
                }
                buffer.push(source, column, values.into_iter());
                if one[0] == one[1] {
                    break;
                }
            }
        }
        for sample in &whole {
            rows.extend(ROWS);
            (0..width).for_each(|c| rows.set(c, &sample[c], 1.0));
        }
        let mut sums = [Symmetric::zeros(width), Symmetric::zeros(width)];
        let dot = |i: usize, s: usize, t: usize| {
            let parts = vectors[i][s].iter().zip(&vectors[i][t]);
            parts.map(|(a, b)| a * b).sum()
        };
        buffer.add_products(dot, &mut sums[0]);
        rows.add_products(&mut sums[1]);
        sums
    }

    fn assert_alike([by_source, by_rows]: [Symmetric; 2]) {
        for a in 0..by_rows.order() {
            for b in 0..=a {
                let (found, wanted) = (by_source[(a, b)], by_rows[(a, b)]);
                assert!((found - wanted).abs() < 1e-11, "{a} {b}: {found} {wanted}");
            }
        }
    }

    #[test]
    fn products_by_source_are_those_of_whole_rows() {
        for (width, samples) in [(230, 70), (230, 3), (230, 1), (9, 70), (4, 70), (1, 1)] {
            assert_alike(both(width, samples, |_, _| true));
        }
    }

    #[test]
    fn of_samples_with_few_columns_they_are_as_well() {
        assert_alike(both(230, 70, |i, c| c % 70 == i || c == 11));
    }

    #[test]
    fn no_sample_adds_nothing() {
        let [sum, _] = both(230, 0, |_, _| true);
        assert_eq!(sum, Symmetric::zeros(230));
    }
}
