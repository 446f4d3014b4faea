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

    /// Row of the factor, from the diagonal, without its right-hand side.
    #[inline]
    pub fn row(&self, row: usize) -> &[f32] {
        let range = packed::row(self.unknowns, row);
        &self.packed[range.start..range.end - 1]
    }

    /// Row of the factor, from the diagonal to the right-hand side.
    #[inline]
    pub fn row_mut(&mut self, row: usize) -> &mut [f32] {
        &mut self.packed[packed::row(self.unknowns, row)]
    }

    /// Right-hand side of a row.
    pub fn rhs(&self, row: usize) -> f32 {
        self.packed[packed::row(self.unknowns, row).end - 1]
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

    /// Solves `R^T u = v` in place. False if a diagonal entry that is needed has vanished.
    pub fn forward(&self, v: &mut [f32]) -> bool {
        for i in 0..self.unknowns {
            if v[i] == 0.0 {
                continue;
            }
            let row = self.row(i);
            let y = v[i] / row[0];
            if !y.is_finite() {
                return false;
            }
            v[i] = y;
            packed::subtract(&mut v[i + 1..self.unknowns], y, &row[1..]);
        }
        true
    }

    /// Solves `R x = rhs` into `x`. A vanished diagonal entry gives infinities.
    pub fn backward(&self, x: &mut [f32]) {
        for i in (0..self.unknowns).rev() {
            let row = self.row(i);
            let tail = &x[i + 1..self.unknowns];
            x[i] = (self.rhs(i) - packed::dot(&row[1..], tail)) / row[0];
        }
    }
}
