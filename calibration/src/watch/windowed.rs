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
        let (half, least) = (0.5 * (a + d), self.least());
        let [v, w] = self.vector;
        // Below f32's digits beside the larger one it is rounding.
        (least > 1.0e-5 * half).then(|| {
            let amounts = [(d * v - b * w) / determinant, (a * w - b * v) / determinant];
            (amounts, least)
        })
    }

    /// The smaller eigenvalue of the information that is left where another's amounts are not known either; `cross` are their common products.
    pub(super) fn without(&self, other: &Self, [[p, q], [r, s]]: [[f32; 2]; 2]) -> f32 {
        let [a, b, d] = other.matrix;
        let determinant = a * d - b * b;
        if determinant <= 0.0 {
            return self.least();
        }
        // The quadratic form of the other's inverse.
        let form = |[u, v]: [f32; 2], [w, x]: [f32; 2]| {
            (d * u * w - b * (u * x + v * w) + a * v * x) / determinant
        };
        let [e, f, g] = self.matrix;
        let left = Self {
            matrix: [
                e - form([p, q], [p, q]),
                f - form([p, q], [r, s]),
                g - form([r, s], [r, s]),
            ],
            vector: [0.0; 2],
        };
        left.least()
    }

    /// The smaller eigenvalue of the information.
    fn least(&self) -> f32 {
        let [a, b, d] = self.matrix;
        let (half, apart) = (0.5 * (a + d), 0.5 * (a - d));
        half - sqrt(apart * apart + b * b)
    }

    /// By how much it lowers the sum of squares, if there is nothing else: twice the logarithm of the likelihood ratio, times the variance.
    #[must_use]
    pub fn gain(&self) -> f32 {
        let [v, w] = self.vector;
        self.estimate().map_or(0.0, |([a, b], _)| a * v + b * w)
    }
}
