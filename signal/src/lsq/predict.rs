//! What the factor says about a further row: for gating and planning.

use super::triangle::Triangle;

/// What the rows so far say about one more.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prediction {
    /// `row * x` with the present estimate, in the right-hand side's unit.
    pub value: f32,
    /// Variance of `value` in units of the rows' noise variance; infinite if the rows do not determine it.
    pub leverage: f32,
}

impl<const N: usize, const P: usize> Triangle<N, P> {
    /// Value and leverage of a linear functional of the unknowns, for gating and planning. About as dear as entering a
    /// row: one forward substitution. `None` if `row` has the wrong length or is not finite.
    #[must_use]
    pub fn predict(&self, row: &[f32]) -> Option<Prediction> {
        self.check(row, 0.0).ok()?;
        let mut solved = [0.0; N];
        for ((solved, row), scale) in solved.iter_mut().zip(row).zip(&self.scale) {
            if *row != 0.0 && *scale == 0.0 {
                return Some(Prediction {
                    value: 0.0,
                    leverage: f32::INFINITY,
                });
            }
            *solved = row * scale;
        }
        if !self.forward(&mut solved) {
            return Some(Prediction {
                value: 0.0,
                leverage: f32::INFINITY,
            });
        }
        let (mut value, mut leverage) = (0.0, 0.0);
        for (i, y) in solved.iter().enumerate().take(self.unknowns) {
            let row = self.row(i);
            if let (true, Some(z)) = (*y != 0.0, row.last()) {
                value += y * z;
                leverage += y * y / row[0];
            }
        }
        Some(Prediction {
            value: value * self.rhs_unit,
            leverage,
        })
    }

    /// `P row` (the change of the unknowns for an innovation of `1 + leverage`), with the leverage; `P` is the unknowns'
    /// covariance for unit noise. `None` if the rows do not determine it. Two substitutions.
    #[must_use]
    pub fn pull(&self, row: &[f32]) -> Option<([f32; N], f32)> {
        self.check(row, 0.0).ok()?;
        let mut v = [0.0; N];
        for ((v, row), scale) in v.iter_mut().zip(row).zip(&self.scale) {
            *v = row * scale;
        }
        if !self.forward(&mut v) || self.scale[..self.unknowns].contains(&0.0) {
            return None;
        }
        let mut leverage = 0.0;
        for (i, v) in v.iter_mut().enumerate().take(self.unknowns) {
            let share = *v / self.row(i)[0];
            leverage += *v * share;
            *v = share;
        }
        self.backward(&mut v);
        for (v, scale) in v.iter_mut().zip(&self.scale) {
            *v *= scale;
        }
        v[..self.unknowns]
            .iter()
            .all(|v| v.is_finite())
            .then_some((v, leverage))
    }
}
