//! The error model of one pair: harmonics of its phase, dense from order 1 on.

use crate::model::Unit;

/// Highest order of the phase. A definition: a third harmonic makes order 4, its square order 8.
pub const ORDERS: usize = 8;

/// What is added to the phase: `sum over n of a_n sin(n phi) + b_n cos(n phi)`, with phi the phase as it was measured.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Harmonics {
    /// `[a_n, b_n]` of orders 1 to 8, turns of the phase.
    pub turns: [[f32; 2]; ORDERS],
}

impl Harmonics {
    /// Their sum at a phase, turns: Clenshaw's recurrence on the measured sine and cosine, 6 operations an order.
    #[inline(always)]
    #[must_use]
    pub fn at(&self, phase: Unit) -> f32 {
        let twice = phase.cosine + phase.cosine;
        // The two highest orders have less before them.
        let [lower @ .., [a, b], [sine, cosine]] = &self.turns;
        let mut sine = [a + twice * sine, *sine];
        let mut cosine = [b + twice * cosine, *cosine];
        for [a, b] in lower.iter().rev() {
            sine = [a + (twice * sine[0] - sine[1]), sine[0]];
            cosine = [b + (twice * cosine[0] - cosine[1]), cosine[0]];
        }
        phase.sine * sine[0] + (phase.cosine * cosine[0] - cosine[1])
    }

    /// Largest that the sum can be, turns.
    #[must_use]
    pub fn bound_turns(&self) -> f32 {
        self.turns.as_flattened().iter().map(|k| k.abs()).sum()
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;

    /// The recurrence is the sum, within what f32 can do: 100 operations on numbers of at most eight times the coefficients.
    #[test]
    fn the_recurrence_is_the_sum() {
        let mut harmonics = Harmonics::default();
        for (n, k) in harmonics.turns.as_flattened_mut().iter_mut().enumerate() {
            *k = (2.0 * ((n + 1) as f32 * 0.618_034).fract() - 1.0) * 0.01;
        }
        for step in 0..500 {
            let phase = Unit::from_turns(step as f32 / 500.0);
            let turn = core::f64::consts::TAU * f64::from(step) / 500.0;
            let terms = harmonics.turns.iter().zip(1..);
            let sum: f64 = terms
                .map(|([a, b], n)| {
                    let (s, c) = (turn * f64::from(n)).sin_cos();
                    f64::from(*a) * s + f64::from(*b) * c
                })
                .sum();
            let limit = 100.0 * 8.0 * 0.01 * f64::from(f32::EPSILON);
            assert!((f64::from(harmonics.at(phase)) - sum).abs() < limit);
        }
    }
}
