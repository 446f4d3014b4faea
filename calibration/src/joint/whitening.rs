//! Small helpers of the constraints: the Cholesky factor of their covariance, sine and cosine of a small angle.

use super::layout::Values;
use crate::math::sqrt;

/// A lower triangular 3 x 3 matrix and what it makes of a vector: `L^-1 v`.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Whitening([[f32; 3]; 3]);

impl Whitening {
    /// Cholesky factor of a covariance.
    pub fn of(s: [[f32; 3]; 3]) -> Self {
        let a = sqrt(s[0][0]);
        let (b, d) = (s[1][0] / a, s[2][0] / a);
        let c = sqrt(s[1][1] - b * b);
        let e = (s[2][1] - d * b) / c;
        let f = sqrt(s[2][2] - d * d - e * e);
        Self([[a, 0.0, 0.0], [b, c, 0.0], [d, e, f]])
    }

    /// `L^-1 v`.
    pub fn apply(&self, v: [f32; 3]) -> [f32; 3] {
        let l = &self.0;
        let x = v[0] / l[0][0];
        let y = (v[1] - l[1][0] * x) / l[1][1];
        [x, y, (v[2] - l[2][0] * x - l[2][1] * y) / l[2][2]]
    }

    /// Covariance's inverse times `v`.
    pub fn solve(&self, v: [f32; 3]) -> [f32; 3] {
        let l = &self.0;
        let [x, y, z] = self.apply(v);
        let z = z / l[2][2];
        let y = (y - l[2][1] * z) / l[1][1];
        [(x - l[1][0] * y - l[2][0] * z) / l[0][0], y, z]
    }

    /// Whitens the first `columns` columns of three rows.
    pub fn apply_rows(&self, rows: &mut [Values; 3], columns: usize) {
        for column in 0..columns {
            let whitened = self.apply([rows[0][column], rows[1][column], rows[2][column]]);
            for (row, value) in rows.iter_mut().zip(whitened) {
                row[column] = value;
            }
        }
    }
}

/// Sine and one minus cosine, to f32's last digits for the courier's few degrees (series to the fifth and sixth power).
pub(super) fn small_angle(angle: f32) -> (f32, f32) {
    let z = angle * angle;
    let sine = angle * (1.0 - z / 6.0 * (1.0 - z / 20.0));
    let rest = 0.5 * z * (1.0 - z / 12.0 * (1.0 - z / 30.0));
    (sine, rest)
}
