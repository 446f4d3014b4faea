//! Largest and smallest singular value of a factor, by Lanczos' process.
//!
//! Golub and Kahan (1965) bidiagonalise the factor, or its inverse, from one start vector, two vectors at a time; the
//! largest singular value of the small bidiagonal matrix is the estimate, never above the true one. Vectors that have
//! lost their orthogonality repeat values that are found already (Paige 1971): they need not be kept.
//!
//! How near the estimate is rests on the start vector's part along the direction that is sought. For a start that is
//! drawn evenly from all directions Kuczynski and Wozniakowski (1992, theorem 4.2) bound it for *any* spectrum: the
//! square of the estimate is low by more than a share e with a probability of at most `1.648 sqrt(n) exp(-sqrt(e) (2 k - 1))`
//! after `k` steps. The power method needs some `1 / e` steps for what takes `1 / sqrt(e)` of these.

use super::packed;
use super::upper::Factor;
use crate::math::sqrt;

/// Steps at most. A bound on the work: by the bound one end of the worst spectrum of 62 is off by over 3 % in 1 of 40,000
/// factors; as was measured over the spectra of `tests/suite/condition.rs`, both together are off by 0.5 % at most.
const STEPS: usize = 28;
/// Share of the estimate that halving its interval leaves open. Derived from f32: a hundred of its roundings.
const RESOLUTION: f32 = 1.0e-5;

/// Which matrix is asked about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Of {
    /// The factor.
    Itself,
    /// Its inverse.
    Inverse,
}

impl Factor<'_> {
    /// Largest singular value of itself or of its inverse; infinite beyond f32's range. `work` is of as many numbers each as
    /// there are unknowns.
    pub fn largest_singular_value(self, of: Of, [product, left, right]: [&mut [f32]; 3]) -> f32 {
        let mut bidiagonal = Bidiagonal::new();
        start_vector(right);
        left.fill(0.0);
        let mut beta = 0.0;
        for _ in 0..STEPS.min(right.len()) {
            product.copy_from_slice(right);
            match of {
                Of::Itself => self.multiply(product),
                Of::Inverse => self.forward(product),
            }
            let alpha = advance(left, product, beta);
            product.copy_from_slice(left);
            match of {
                Of::Itself => self.multiply_transposed(product),
                Of::Inverse => self.backward(product),
            }
            beta = advance(right, product, alpha);
            if !(alpha.is_finite() && beta.is_finite()) {
                return f32::INFINITY;
            }
            bidiagonal.push(alpha, beta);
            if beta == 0.0 {
                break;
            }
        }
        bidiagonal.largest_singular_value()
    }
}

/// `old <- product - length old`, brought to length one; returns the length it had.
#[inline(never)]
fn advance(old: &mut [f32], product: &[f32], length: f32) -> f32 {
    for (old, product) in old.iter_mut().zip(product) {
        *old = product - length * *old;
    }
    let length = sqrt(packed::dot(old, old));
    if length > 0.0 {
        let inverse = 1.0 / length;
        old.iter_mut().for_each(|x| *x *= inverse);
    }
    length
}

/// Diagonal and superdiagonal of what [`Factor::largest_singular_value`] finds; the last of the superdiagonal in a column of its own.
struct Bidiagonal {
    diagonal: [f32; STEPS],
    superdiagonal: [f32; STEPS],
    steps: usize,
}

impl Bidiagonal {
    const fn new() -> Self {
        Self {
            diagonal: [0.0; STEPS],
            superdiagonal: [0.0; STEPS],
            steps: 0,
        }
    }

    fn push(&mut self, diagonal: f32, superdiagonal: f32) {
        self.diagonal[self.steps] = diagonal;
        self.superdiagonal[self.steps] = superdiagonal;
        self.steps += 1;
    }

    /// By halving of an interval that holds it, to [`RESOLUTION`].
    fn largest_singular_value(&self) -> f32 {
        // It is not below any entry, nor above the largest sum of a row or a column.
        let (mut low, mut high, mut above) = (0.0f32, 0.0f32, 0.0);
        for (a, b) in self.entries() {
            low = low.max(a);
            high = high.max(a + b).max(a + above);
            above = b;
        }
        while high - low > RESOLUTION * high {
            let middle = 0.5 * (low + high);
            if self.exceeds(middle) {
                low = middle;
            } else {
                high = middle;
            }
        }
        low
    }

    fn entries(&self) -> impl Iterator<Item = (f32, f32)> {
        let taken = self.diagonal.iter().zip(&self.superdiagonal);
        taken.take(self.steps).map(|(a, b)| (*a, *b))
    }

    /// Is a singular value above `bound`? Then a pivot of `B B^T - bound^2` is not negative.
    fn exceeds(&self, bound: f32) -> bool {
        // In units of the bound, so that squares stay in range.
        let unit = 1.0 / bound;
        let (mut pivot, mut beta) = (-1.0f32, 0.0f32);
        for (a, b) in self.entries() {
            let (a, b) = (a * unit, b * unit);
            let coupling = a * beta;
            pivot = a * a + b * b - 1.0 - coupling * coupling / pivot;
            if pivot >= 0.0 {
                return true;
            }
            beta = b;
        }
        false
    }
}

/// A vector of length one, drawn evenly from all directions, the same at every call.
pub(super) fn start_vector(v: &mut [f32]) {
    let mut state = 0x2545_F491u32;
    for v in v.iter_mut() {
        // The sum of four even draws is near enough to a normal one that no direction is favoured.
        let mut sum = 0.0;
        for _ in 0..4 {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            sum += (state >> 8) as f32 - 8_388_607.5;
        }
        *v = sum;
    }
    let inverse = 1.0 / sqrt(packed::dot(v, v));
    v.iter_mut().for_each(|v| *v *= inverse);
}
