//! Taking a row out of the factor again.

use super::givens::{Rotation, hypot};
use super::triangle::Triangle;

/// A row may be removed if one minus its leverage is at least this: four of f32's seven digits are left.
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
        self.settle_rows();
        if !self.forward(&mut sines) {
            return false;
        }
        let apart = 1.0 - sines[..self.unknowns].iter().map(|a| a * a).sum::<f32>();
        if apart.is_nan() || apart < LEAST_APART {
            return false;
        }
        self.rotate_out(&mut sines, crate::math::sqrt(apart), rhs * self.rhs_scale);
        self.rows = self.rows.saturating_sub(1);
        self.weight -= 1.0;
        true
    }

    /// `sines` holds `R^-T row` and becomes the rotations that, from the bottom up, turn the row out of the factor.
    fn rotate_out(&mut self, sines: &mut [f32; N], mut radius: f32, mut rest: f32) {
        self.work.fill(0.0);
        let mut cosines = [0.0; N];
        for i in (0..self.unknowns).rev() {
            let next = hypot(radius, sines[i]);
            cosines[i] = radius / next;
            sines[i] /= next;
            radius = next;
            let rotation = Rotation {
                c: cosines[i],
                s: -sines[i],
            };
            let (start, end) = (self.start(i), self.start(i) + self.unknowns - i);
            rotation.turn_all(
                &mut self.factor[start..end],
                &mut self.work[i..self.unknowns],
            );
        }
        for ((z, c), s) in self
            .rhs
            .iter_mut()
            .zip(&cosines)
            .zip(sines)
            .take(self.unknowns)
        {
            *z = (*z - *s * rest) / c;
            rest = c * rest - *s * *z;
        }
        let left = (self.residual_norm - rest.abs()).max(0.0) * (self.residual_norm + rest.abs());
        self.residual_norm = crate::math::sqrt(left);
    }
}
