//! What a window tells of one place, and sums of it.

use crate::math::sqrt;

/// What a window tells of one place: information, as the upper triangle of a symmetric matrix, and score, both times the variance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Windowed {
    /// Sum of squares of the sine's column, of products, of squares of the cosine's: what other columns but equation (3)'s tell alike is
    /// taken out.
    pub matrix: [f32; 3],
    /// The same of the residual against the reference, metres.
    pub vector: [f32; 2],
}

impl Windowed {
    /// This, scaled, plus another.
    #[must_use]
    pub fn plus(self, factor: f32, other: Self, by: f32) -> Self {
        let (a, b) = (self.matrix, other.matrix);
        let matrix = core::array::from_fn(|i| factor * a[i] + by * b[i]);
        let (a, b) = (self.vector, other.vector);
        let vector = core::array::from_fn(|i| factor * a[i] + by * b[i]);
        Self { matrix, vector }
    }

    /// Amounts of sine and cosine, and the smaller eigenvalue of the information; none where there is none.
    #[must_use]
    pub fn estimate(&self) -> Option<([f32; 2], f32)> {
        let [a, b, d] = self.matrix;
        let determinant = a * d - b * b;
        let (half, apart) = (0.5 * (a + d), 0.5 * (a - d));
        let least = half - sqrt(apart * apart + b * b);
        let [v, w] = self.vector;
        // Below f32's digits beside the larger one it is rounding.
        (least > 1.0e-5 * half).then(|| {
            let amounts = [(d * v - b * w) / determinant, (a * w - b * v) / determinant];
            (amounts, least)
        })
    }

    /// By how much it lowers the sum of squares, if there is nothing else: twice the logarithm of the likelihood ratio, times the variance.
    #[must_use]
    pub fn gain(&self) -> f32 {
        let [v, w] = self.vector;
        self.estimate().map_or(0.0, |([a, b], _)| a * v + b * w)
    }
}
