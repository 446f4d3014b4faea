//! The error model in machine units: equations (3) and (9) dense, every other row in a bounded list.

use super::further::Further;
use super::{ErrorModel, Term};
use crate::equations::OWN_ORDERS;
use crate::frame::SEGMENTS;
use crate::lanes::Lanes;
use core::array::from_fn;

impl Term {
    /// Whether the interrupt evaluates it by itself: it is in neither equation (3) nor (9).
    #[must_use]
    pub fn is_further(&self) -> bool {
        *self != Self::lateral(1) && !OWN_ORDERS.iter().any(|&n| *self == Self::own(n))
    }
}

/// Equation (3) of two segments as polynomials in the measured sine s and cosine c, turns.
///
/// With u = s²: `e = even(u) + s (sine + c odd(u)) + cosine c`. The multiple-angle formulas, orders 2, 4 and 6:
/// cosines `1 - 2u`, `1 - 8u + 8u²`, `1 - 18u + 48u² - 32u³`; sines over s c: `2`, `4 - 8u`, `6 - 32u + 32u²`.
/// 17 operations where the harmonics one by one ([`own_error`](crate::equations::own_error)) take 33: that is why the interrupt has a
/// form of its own. A test holds both equal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct OwnPolynomial {
    even: [Lanes; 4],
    odd: [Lanes; 3],
    sine: Lanes,
    cosine: Lanes,
}

impl OwnPolynomial {
    /// No errors.
    pub const ZERO: Self = Self {
        even: [Lanes([0.0; 2]); 4],
        odd: [Lanes([0.0; 2]); 3],
        sine: Lanes([0.0; 2]),
        cosine: Lanes([0.0; 2]),
    };

    /// From the constants and the `[sine, cosine]` coefficients of orders 1, 2, 4 and 6.
    fn new(constant: Lanes, [[s1, c1], [s2, c2], [s4, c4], [s6, c6]]: [[Lanes; 2]; 4]) -> Self {
        Self {
            even: [
                constant + c2 + c4 + c6,
                c2 * -2.0 + c4 * -8.0 + c6 * -18.0,
                c4 * 8.0 + c6 * 48.0,
                c6 * -32.0,
            ],
            odd: [
                s2 * 2.0 + s4 * 4.0 + s6 * 6.0,
                s4 * -8.0 + s6 * -32.0,
                s6 * 32.0,
            ],
            sine: s1,
            cosine: c1,
        }
    }

    /// Equation (3) of two segments, turns.
    #[inline(always)]
    pub fn errors(&self, sine: Lanes, cosine: Lanes) -> Lanes {
        let (even, odd) = (&self.even, &self.odd);
        let u = sine * sine;
        let q = u * (u * odd[2] + odd[1]) + odd[0];
        let r = u * (u * (u * even[3] + even[2]) + even[1]) + even[0];
        r + sine * (cosine * q + self.sine) + cosine * self.cosine
    }
}

impl Further {
    /// Takes up a model's rows beyond equation (3), coefficients in turns, in place of what was there: a list is a kilobyte. Returns
    /// equation (3), segments 1 and 3, 2 and 4. Without a model there are no errors.
    #[inline] // built with the image, for size
    pub fn set(&mut self, model: Option<&ErrorModel>, pitch_m: f32) -> [OwnPolynomial; 2] {
        self.clear();
        let Some(model) = model else {
            return [OwnPolynomial::ZERO; 2];
        };
        let per_pitch = 1.0 / pitch_m;
        let mut harmonics = [[[0.0; 2]; 4]; SEGMENTS];
        for (term, rows) in model.terms.iter().zip(&model.coefficients) {
            let rows = rows.map(|row| row.map(|k| k * per_pitch));
            match OWN_ORDERS.iter().position(|&n| *term == Term::own(n)) {
                Some(order) => (0..SEGMENTS).for_each(|i| harmonics[i][order] = rows[i]),
                None => self.add(*term, rows),
            }
        }
        from_fn(|p| {
            let lanes = |of: &dyn Fn(usize) -> f32| Lanes([of(p), of(p + 2)]);
            OwnPolynomial::new(
                lanes(&|i| model.constants_m[i] * per_pitch),
                from_fn(|order| from_fn(|part| lanes(&|i| harmonics[i][order][part]))),
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::equations::{own_error, own_functions};
    use core::f64::consts::TAU;

    /// The interrupt's form of equation (3) is equation (3), within what the rounding of its f32 can do: 17 operations on numbers of
    /// at most 48 times the coefficients (the multiple-angle formula of order 6).
    #[test]
    fn the_polynomial_is_equation_3() {
        // Any coefficients will do: those of the golden ratio lie everywhere between -1 and 1.
        let spread = |n: usize| 2.0 * ((n + 1) as f64 * 0.618_034).fract() - 1.0;
        let limit = 17.0 * 48.0 * 9.0 * f64::from(f32::EPSILON) / 2.0;
        for set in 0..20 {
            let k: [f32; 9] = from_fn(|n| spread(9 * set + n) as f32);
            let lanes = |value: f32| Lanes([value, -value]);
            let pairs = from_fn(|n| [lanes(k[1 + 2 * n]), lanes(k[2 + 2 * n])]);
            let polynomial = OwnPolynomial::new(lanes(k[0]), pairs);
            for step in 0..200 {
                let (sine, cosine) = (TAU * f64::from(step) / 200.0).sin_cos();
                let [sine, cosine] = [sine as f32, cosine as f32];
                let Lanes(found) = polynomial.errors(Lanes([sine; 2]), Lanes([cosine; 2]));
                let functions = own_functions([f64::from(sine), f64::from(cosine)]);
                let wanted = own_error(&k.map(f64::from), &functions);
                assert!((f64::from(found[0]) - wanted).abs() < limit, "{set} {step}");
                assert_eq!(found[1], -found[0]);
            }
        }
    }
}
