//! Taking a row out of the factor again.

use super::givens::{Rotation, hypot};
use super::rotate::LEAST_PIVOT;
use super::triangle::Triangle;
use crate::math::sqrt;

/// A row may be removed if one minus its leverage is at least this: four of f32's seven digits are left. Derived from f32's
/// 2^-24: the rest of a row is then known to 6e-5.
const LEAST_APART: f32 = 1.0e-3;

impl<const N: usize, const P: usize> Triangle<N, P> {
    /// Takes out a row that was entered (LINPACK's downdate; Stewart 1979). False, and nothing is changed, if the others
    /// would determine too little: then nearly all digits would be lost.
    pub fn remove(&mut self, row: &[f32], rhs: f32) -> bool {
        let mut sines = [0.0; N];
        if self.check(row, rhs).is_err() {
            return false;
        }
        for ((v, row), scale) in sines.iter_mut().zip(row).zip(&self.scale) {
            *v = row * scale;
        }
        if !self.forward(&mut sines) {
            return false;
        }
        for (i, v) in sines.iter_mut().enumerate().take(self.unknowns) {
            if *v != 0.0 {
                *v /= sqrt(self.row(i)[0]);
            }
        }
        let apart = 1.0 - sines[..self.unknowns].iter().map(|a| a * a).sum::<f32>();
        if apart.is_nan() || apart < LEAST_APART {
            return false;
        }
        self.rotate_out(&mut sines, sqrt(apart), rhs * self.rhs_scale);
        self.rows = self.rows.saturating_sub(1);
        self.weight -= 1.0;
        true
    }

    /// `sines` holds `R^-T row` and becomes the rotations that, from the bottom up, turn the row out of the factor.
    fn rotate_out(&mut self, sines: &mut [f32; N], mut radius: f32, mut rest: f32) {
        let mut cosines = [0.0; N];
        let unknowns = self.unknowns;
        self.packed[..=unknowns].fill(0.0);
        for i in (0..unknowns).rev() {
            let next = hypot(radius, sines[i]);
            cosines[i] = radius / next;
            sines[i] /= next;
            radius = next;
            let rotation = Rotation {
                c: cosines[i],
                s: -sines[i],
            };
            self.turn_plain(i, rotation);
        }
        for i in 0..unknowns {
            let (c, s) = (cosines[i], sines[i]);
            let row = self.row_mut(i);
            let (root, z) = (sqrt(row[0]), &mut row[unknowns - i]);
            let turned = (*z * root - s * rest) / c;
            rest = c * rest - s * turned;
            *z = if root > 0.0 { turned / root } else { 0.0 };
        }
        self.residual_square = (self.residual_square - rest * rest).max(0.0);
    }

    /// Turns row `i`, made plain for it, against the row that goes out; the right-hand side is only brought to the new `d`.
    fn turn_plain(&mut self, i: usize, rotation: Rotation) {
        let unknowns = self.unknowns;
        let (entering, factor) = self.packed.split_at_mut(unknowns + 1);
        let start = super::packed::start(unknowns, i) - entering.len();
        let row = &mut factor[start..=start + unknowns - i];
        let mut pivot = sqrt(row[0]);
        let root = pivot;
        rotation.turn(&mut pivot, &mut entering[i]);
        if pivot * pivot < LEAST_PIVOT {
            row.fill(0.0);
            return;
        }
        for (u, entry) in row[1..unknowns - i].iter_mut().zip(&mut entering[i + 1..]) {
            let mut plain = root * *u;
            rotation.turn(&mut plain, entry);
            *u = plain / pivot;
        }
        row[unknowns - i] *= root / pivot;
        row[0] = pivot * pivot;
    }
}
