//! Each block in its own axes: combinations of its columns whose products with each other are a diagonal. The prior of a block is the same
//! in all directions, so that nothing else changes; what a size does to a block is then told coefficient by coefficient.

use super::reduced::{Common, Reduced, ranges};
use super::scale::RANGE;
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// What an axis may add to the logarithm of an evidence at the most, and is left out: sixty thousand of them do not change it by
/// a tenth. Derived from that sum: a tenth of a logarithm changes no odds by more than a tenth.
const UNSEEN: f64 = 1.0e-6;

/// The axes of a block that the data may tell, as columns.
pub fn axes(normal: &DMatrix<f64>, targets: &[DVector<f64>]) -> DMatrix<f64> {
    let eigen = normal.clone().symmetric_eigen();
    let largest = (2.0 * RANGE[1]).exp();
    let along: Vec<DVector<f64>> = targets
        .iter()
        .map(|t| eigen.eigenvectors.tr_mul(t))
        .collect();
    // Of noise about one, an axis of squares `a` with the target's product `r` adds at the most `g a / 2` to Occam's factor and `g r² / 2`
    // to what is explained, `g` being the largest variance.
    let adds = |k: usize| {
        let squares = along
            .iter()
            .map(|t| t[k] * t[k])
            .fold(eigen.eigenvalues[k], f64::max);
        0.5 * largest * squares
    };
    let mut seen: Vec<usize> = (0..normal.nrows()).filter(|k| adds(*k) > UNSEEN).collect();
    if seen.is_empty() {
        seen.extend((0..normal.nrows()).max_by(|a, b| adds(*a).total_cmp(&adds(*b))));
    }
    seen.sort_by(|a, b| adds(*b).total_cmp(&adds(*a)));
    eigen.eigenvectors.select_columns(&seen)
}

/// A symmetric matrix of all columns, or of products of them, in the blocks' axes.
pub fn turned(
    matrix: &DMatrix<f64>,
    blocks: &[Range<usize>],
    axes: &[DMatrix<f64>],
) -> DMatrix<f64> {
    let once = rows_turned(matrix, blocks, axes);
    let both = rows_turned(&once.transpose(), blocks, axes);
    // To rounding it is symmetric already.
    0.5 * (&both + both.transpose())
}

fn rows_turned(
    matrix: &DMatrix<f64>,
    blocks: &[Range<usize>],
    axes: &[DMatrix<f64>],
) -> DMatrix<f64> {
    let rows: usize = axes.iter().map(DMatrix::ncols).sum();
    let mut out = DMatrix::zeros(rows, matrix.ncols());
    let mut at = 0;
    for (block, axes) in blocks.iter().zip(axes) {
        let own = axes.transpose() * matrix.rows(block.start, block.len());
        out.rows_mut(at, axes.ncols()).copy_from(&own);
        at += axes.ncols();
    }
    out
}

/// A vector of all columns in the blocks' axes.
pub fn vector_turned(
    vector: &DVector<f64>,
    blocks: &[Range<usize>],
    axes: &[DMatrix<f64>],
) -> DVector<f64> {
    let parts = blocks.iter().zip(axes);
    let parts = parts.flat_map(|(block, axes)| {
        let own = axes.tr_mul(&vector.rows(block.start, block.len()));
        own.iter().copied().collect::<Vec<f64>>()
    });
    DVector::from_vec(parts.collect())
}

/// Exact zeros beside the diagonals of the blocks, where rounding has left something.
pub fn cleared(mut normal: DMatrix<f64>, blocks: &[Range<usize>]) -> DMatrix<f64> {
    for block in blocks {
        let mut own = normal.view_mut((block.start, block.start), (block.len(), block.len()));
        let diagonal = own.diagonal();
        own.fill(0.0);
        own.set_diagonal(&diagonal.map(|d| d.max(0.0)));
    }
    normal
}

impl Reduced {
    /// The same with each block in its own axes. Cost: some nine times the cube of each block, and the square of all columns times each.
    pub fn in_own_axes(self) -> Self {
        let axes: Vec<DMatrix<f64>> = self
            .blocks
            .iter()
            .map(|block| {
                let own = self
                    .normal
                    .view((block.start, block.start), (block.len(), block.len()));
                let targets = self
                    .targets()
                    .map(|t| t.rows(block.start, block.len()).into_owned());
                axes(&own.into_owned(), &targets)
            })
            .collect();
        self.turned(&axes)
    }

    /// The same with the columns of each block turned to some axes, in which their products are a diagonal.
    fn turned(self, axes: &[DMatrix<f64>]) -> Self {
        let vector = |v: &DVector<f64>| vector_turned(v, &self.blocks, axes);
        let matrix = |m: &DMatrix<f64>| turned(m, &self.blocks, axes);
        let blocks = ranges(axes.iter().map(DMatrix::ncols));
        Self {
            normal: cleared(matrix(&self.normal), &blocks),
            right: vector(&self.right),
            centre: vector(&self.centre),
            carried: self.carried.as_ref().map(matrix),
            common: Common {
                right: vector(&self.common.right),
                ..self.common
            },
            in_own_axes: true,
            blocks,
            ..self
        }
    }
}
