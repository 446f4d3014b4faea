//! Precision of splines in blocks, and what it is of teeth: weights of a tooth in splines are products of one along and one across, so that a block
//! takes them one after the other. Cost: of a block with n splines and t teeth along and m and u across, one to two times `n² m² u + n² m u² + n t u² (n + t)`
//! products. Those across are most of them, and serve all apertures that differ along alone.

use nalgebra::{DMatrix, DMatrixView, DMatrixViewMut};

/// Kinds of splines, and of teeth. By definition four: single ones of x's field and of y's, then whole lines of both.
pub const KINDS: usize = 4;

/// Where the splines of one kind are that the data tell something of.
#[derive(Clone, Debug)]
pub struct Told {
    /// Number of the first spline of the kind.
    pub first: usize,
    /// How many there are across, next to each other.
    pub across: usize,
    /// Numbers along of those that are told.
    pub along: Vec<usize>,
}

impl Told {
    /// Splines that are told, across running fastest.
    fn places(&self) -> Vec<usize> {
        let first = |i: &usize| self.first + i * self.across;
        let rows = self.along.iter().map(first);
        rows.flat_map(|first| first..first + self.across).collect()
    }

    /// Their amounts, a column for each number along.
    pub fn of(&self, amounts: &[f64]) -> DMatrix<f64> {
        let told = self.places().into_iter().map(|at| amounts[at]);
        DMatrix::from_iterator(self.across, self.along.len(), told)
    }
}

/// Weights of one kind's teeth.
pub struct Weights {
    /// A row for each spline along that is told, a column for each tooth.
    pub along: DMatrix<f64>,
    /// A row for each tooth across, a column for each spline.
    pub across: DMatrix<f64>,
}

/// A part of the precision: of two kinds, the second of which is not after the first.
pub struct Block {
    kinds: [usize; 2],
    /// Numbers across of the first, across of the second, along of the second and along of the first, each running faster than the next.
    amounts: Vec<f64>,
}

impl Block {
    /// All of a precision.
    pub fn all(precision: &DMatrix<f64>, told: &[Told; KINDS]) -> Vec<Self> {
        let places = told.each_ref().map(Told::places);
        let pairs = (0..KINDS).flat_map(|first| (0..=first).map(move |second| [first, second]));
        let one = |kinds: [usize; 2]| {
            let [first, second] = kinds.map(|kind| &places[kind]);
            let mut amounts = Vec::with_capacity(first.len() * second.len());
            for row in first.chunks(told[kinds[0]].across.max(1)) {
                let columns = second.iter();
                columns.for_each(|column| {
                    amounts.extend(row.iter().map(|at| precision[(*at, *column)]))
                });
            }
            Self { kinds, amounts }
        };
        pairs.map(one).collect()
    }

    /// The same with teeth in place of the splines across.
    pub fn across(&self, weights: &[Weights; KINDS]) -> Self {
        let [first, second] = self.kinds.map(|kind| &weights[kind].across);
        let width = first.ncols();
        let splines = self.amounts.len() / width.max(1);
        let teeth = first * DMatrixView::from_slice(&self.amounts, width, splines);
        Self {
            kinds: self.kinds,
            amounts: slabs(teeth.as_slice(), first.nrows(), &second.transpose()),
        }
    }

    /// With teeth in place of those along as well, into the precision of all teeth, where each kind has its first.
    pub fn along(
        &self,
        weights: &[Weights; KINDS],
        firsts: &[usize; KINDS],
        to: &mut DMatrix<f64>,
    ) {
        let [first, second] = self.kinds.map(|kind| &weights[kind]);
        let [rows, columns] = [first, second].map(|of| of.across.nrows());
        let teeth = slabs(&self.amounts, rows * columns, &second.along);
        let teeth = slabs(&teeth, rows * columns * second.along.ncols(), &first.along);
        let [first_row, first_column] = self.kinds.map(|kind| firsts[kind]);
        let width = columns * second.along.ncols();
        for (k, part) in teeth.chunks(rows.max(1)).enumerate() {
            let (row, column) = (first_row + k / width * rows, first_column + k % width);
            to.column_mut(column).as_mut_slice()[row..row + rows].copy_from_slice(part);
        }
    }
}

/// Products of each slab of so many rows with a matrix, slab after slab.
fn slabs(of: &[f64], rows: usize, by: &DMatrix<f64>) -> Vec<f64> {
    let [from, to] = [by.nrows(), by.ncols()].map(|columns| rows * columns);
    if from == 0 || to == 0 {
        return Vec::new();
    }
    let mut all = vec![0.0; of.len() / from * to];
    for (of, to) in of.chunks_exact(from).zip(all.chunks_exact_mut(to)) {
        let of = DMatrixView::from_slice(of, rows, by.nrows());
        DMatrixViewMut::from_slice(to, rows, by.ncols()).gemm(1.0, &of, by, 0.0);
    }
    all
}
