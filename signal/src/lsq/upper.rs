//! A plain upper-triangular factor with right-hand side: what is solved.

use super::givens::Rotation;
use super::packed;

/// Plain factor of up to `N` unknowns; `P = packed_len(N)`.
#[derive(Clone, Debug)]
pub(super) struct Upper<const N: usize, const P: usize> {
    pub unknowns: usize,
    packed: [f32; P],
}

impl<const N: usize, const P: usize> Upper<N, P> {
    /// Empty, with `unknowns` in use.
    pub const fn new(unknowns: usize) -> Self {
        Self {
            unknowns: if unknowns < N { unknowns } else { N },
            packed: [0.0; P],
        }
    }

    /// Itself without its size: one copy of what is done with it serves all sizes.
    #[inline]
    pub fn factor(&self) -> Factor<'_> {
        Factor {
            unknowns: self.unknowns,
            packed: &self.packed,
        }
    }

    /// Row of the factor, from the diagonal to the right-hand side.
    #[inline]
    pub fn row_mut(&mut self, row: usize) -> &mut [f32] {
        &mut self.packed[packed::row(self.unknowns, row)]
    }

    /// Solves `R x = rhs` into `x`. A vanished diagonal entry gives infinities.
    pub fn solve(&self, x: &mut [f32]) {
        for (i, x) in x.iter_mut().enumerate().take(self.unknowns) {
            *x = self.packed[packed::row(self.unknowns, i).end - 1];
        }
        self.factor().backward(x);
    }

    /// Enters `scale * row * x = 0` by ordinary rotations; returns what is left of the right-hand side.
    pub fn enter(&mut self, row: &[f32], scale: f32) -> f32 {
        let (entering, mut factor) = self.packed.split_at_mut(self.unknowns + 1);
        for (entry, x) in entering.iter_mut().zip(row) {
            *entry = scale * x;
        }
        entering[self.unknowns] = 0.0;
        for i in 0..self.unknowns {
            let entries = &mut entering[i..];
            let (row, rest) = factor.split_at_mut(entries.len());
            factor = rest;
            if entries[0] == 0.0 {
                continue;
            }
            let (rotation, radius) = Rotation::new(row[0], entries[0]);
            row[0] = radius;
            for (factor, entry) in row[1..].iter_mut().zip(&mut entries[1..]) {
                rotation.turn(factor, entry);
            }
        }
        entering[self.unknowns]
    }
}

/// A plain factor `R` as it is read. Vectors are of as many numbers as there are unknowns, or more, which stay.
#[derive(Clone, Copy, Debug)]
pub(super) struct Factor<'p> {
    pub unknowns: usize,
    packed: &'p [f32],
}

impl<'p> Factor<'p> {
    /// Row of the factor, from the diagonal, without its right-hand side.
    #[inline]
    pub fn row(self, row: usize) -> &'p [f32] {
        let range = packed::row(self.unknowns, row);
        &self.packed[range.start..range.end - 1]
    }

    /// `v <- R v`.
    pub fn multiply(self, v: &mut [f32]) {
        for i in 0..self.unknowns {
            v[i] = packed::dot(self.row(i), &v[i..self.unknowns]);
        }
    }

    /// `v <- R^T v`.
    pub fn multiply_transposed(self, v: &mut [f32]) {
        for i in (0..self.unknowns).rev() {
            let (row, x) = (self.row(i), v[i]);
            v[i] = x * row[0];
            packed::subtract(&mut v[i + 1..self.unknowns], -x, &row[1..]);
        }
    }

    /// `v <- R^-T v`. A vanished diagonal entry that is needed gives infinities.
    pub fn forward(self, v: &mut [f32]) {
        for i in 0..self.unknowns {
            if v[i] == 0.0 {
                continue;
            }
            let row = self.row(i);
            let y = v[i] / row[0];
            v[i] = y;
            packed::subtract(&mut v[i + 1..self.unknowns], y, &row[1..]);
        }
    }

    /// `v <- R^-1 v`. A vanished diagonal entry gives infinities.
    pub fn backward(self, v: &mut [f32]) {
        for i in (0..self.unknowns).rev() {
            let row = self.row(i);
            let sum = packed::dot(&row[1..], &v[i + 1..self.unknowns]);
            v[i] = (v[i] - sum) / row[0];
        }
    }
}
