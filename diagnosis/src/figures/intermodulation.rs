//! Harmonics that a pair's offset makes of those of equation (3). An offset of a part `e` of the amplitude moves the measured phase
//! against the true one by `e` times its sine, and a pattern of order n over the true phase is one of orders n - 1 and n + 1 over the
//! measured one, each n e / 2 as large (Jacobi and Anger's expansion to first order). A gap that changes the amplitude shows how large
//! the offset is: it is what makes the first order change with it. A third harmonic of a part `h` of the amplitude, of opposite sign in
//! sine and cosine, makes order 4 as large as `h` and of its square order 8: h²/2 in the pair's angle, and 2 h² of the other sign where order
//! 4 moves the phase that it is measured over. A field falls off with the gap the faster the shorter its wave is (Laplace), so that `h` goes
//! with the square of the amplitude: order 4 changes by twice what there is of it.

use crate::linearization::baseline::ORDERS;
use crate::linearization::relinearized::RelinearizedFit;
use effects::identity::{Factor, Identity, Part, Wave};
use std::f64::consts::TAU;

/// Orders that equation (3) lacks and an offset brings in, each with its neighbours that equation (3) has. Derived from the
/// product: an offset is a wave of order 1, which makes of order n the orders n - 1 and n + 1.
const MIXED_ORDERS: [(usize, [usize; 2]); 3] = [(3, [2, 4]), (5, [4, 6]), (7, [6, 8])];
/// Order that a third harmonic makes, what its square makes, and how much.
const THIRD_ORDER_PRODUCTS: (usize, usize, f64) = (4, 8, 1.5);
/// A harmonic up to this many times what is made is taken for it: the offset is known to some tenths.
const INTERMODULATION_MARGIN: f64 = 2.0;
/// Share of the harmonics' power that may be beyond: second order in the offset.
const FOREIGN_POWER_SHARE: f64 = 0.1;

/// Highest order that is fitted, or more.
/// A bound on the work: what is higher is not looked at.
const HIGHEST_ORDER: usize = 40;

/// Amplitudes of one pair's harmonics by their order, m, and its offset and third harmonic as parts of the amplitude.
struct Pair {
    offset: f64,
    third: f64,
    pitch_m: f64,
    /// Equation (3)'s.
    baseline_m: [f64; HIGHEST_ORDER + 1],
    /// Free ones.
    found_m: [f64; HIGHEST_ORDER + 1],
}

/// True if the free harmonics that are found are what the offsets that the gap shows make of equation (3)'s, and its third harmonics.
/// `gap` and `harmonics` are the names of the two effects.
pub(crate) fn are_the_gaps_own(relinearized: &RelinearizedFit, gap: &str, harmonics: &str) -> bool {
    let pitch_m = relinearized.linearized.observations.pitch_m;
    let changes_m =
        |order: usize, s: usize| amplitude_m(relinearized, gap, Factor::Amplitude, order, s);
    let pairs: [Pair; 4] = std::array::from_fn(|s| Pair {
        offset: changes_m(1, s) * TAU / pitch_m,
        third: 0.5 * changes_m(THIRD_ORDER_PRODUCTS.0, s) * TAU / pitch_m,
        pitch_m,
        baseline_m: std::array::from_fn(|order| baseline_m(relinearized, order, s)),
        found_m: std::array::from_fn(|order| {
            amplitude_m(relinearized, harmonics, Factor::One, order, s)
        }),
    });
    are_made(&pairs)
}

fn are_made(pairs: &[Pair]) -> bool {
    let (mut power, mut beyond) = (0.0, 0.0);
    for pair in pairs {
        for (order, found_m) in pair.found_m.iter().enumerate() {
            let mixed = MIXED_ORDERS.iter().find(|(to, _)| *to == order);
            let from = mixed.map_or([0; 2], |(_, from)| *from);
            let made_m = from.map(|n| 0.5 * n as f64 * pair.offset * pair.baseline_m[n]);
            let squared = if order == THIRD_ORDER_PRODUCTS.1 {
                THIRD_ORDER_PRODUCTS.2 * pair.third.powi(2)
            } else {
                0.0
            };
            let made_m = made_m.iter().sum::<f64>() + squared * pair.pitch_m / TAU;
            let more_m = found_m - INTERMODULATION_MARGIN * made_m;
            power += found_m.powi(2);
            beyond += more_m.max(0.0).powi(2);
        }
    }
    power > 0.0 && beyond < FOREIGN_POWER_SHARE * power
}

/// Amplitude of a sine and a cosine of an effect; zero where it has none.
fn amplitude_m(
    relinearized: &RelinearizedFit,
    effect: &str,
    factor: Factor,
    order: usize,
    segment: usize,
) -> f64 {
    let Some(block) = relinearized
        .columns
        .blocks
        .iter()
        .find(|b| b.name == effect)
    else {
        return 0.0;
    };
    let amount = |part: Part| {
        let wave = Wave {
            segment,
            own_order: order,
            lateral_order: 0,
            part,
            factor,
        };
        let identity = Some(Identity::Wave(wave));
        let mut columns = block.columns.clone();
        let column = columns.find(|c| relinearized.columns.regressors[*c].identity == identity);
        column.map_or(0.0, |c| relinearized.coefficient(c))
    };
    amount(Part::Sine).hypot(amount(Part::Cosine))
}

/// Amplitude of an order of equation (3); zero where it has none.
fn baseline_m(relinearized: &RelinearizedFit, order: usize, segment: usize) -> f64 {
    let k_m = &relinearized.linearized.baseline.k_m[segment];
    let at = ORDERS.iter().position(|n| *n == order);
    at.map_or(0.0, |at| k_m[1 + 2 * at].hypot(k_m[2 + 2 * at]))
}

#[cfg(test)]
mod tests {
    use super::*;

    const POINTS: usize = 4000;

    /// Amplitude of an order of an error over the phase that a pair with an offset measures; the error is one of the true phase.
    fn measured_m(order: usize, offset: f64, error_m: impl Fn(f64) -> f64) -> f64 {
        let (mut sine, mut cosine) = (0.0, 0.0);
        for k in 0..POINTS {
            let phase = TAU * k as f64 / POINTS as f64;
            let mut truth = phase;
            for _ in 0..30 {
                truth = phase - offset * truth.sin();
            }
            let (s, c) = (order as f64 * phase).sin_cos();
            sine += error_m(truth) * s;
            cosine += error_m(truth) * c;
        }
        2.0 * f64::hypot(sine, cosine) / POINTS as f64
    }

    #[test]
    fn what_an_offset_makes_of_a_pattern_is_told_from_a_pattern() {
        let error_m = |phase: f64| 3.0e-6 * (4.0 * phase).sin() + 1.0e-6 * (6.0 * phase).cos();
        let (offset, mut baseline_m) = (0.12, [0.0; HIGHEST_ORDER + 1]);
        (baseline_m[4], baseline_m[6]) = (3.0e-6, 1.0e-6);
        let free = |order| {
            if [3, 5, 7, 8, 9, 10].contains(&order) {
                1.0
            } else {
                0.0
            }
        };
        let pair = |more: usize, size_m: f64| Pair {
            offset,
            third: 0.0,
            pitch_m: 1.0e-3,
            baseline_m,
            found_m: std::array::from_fn(|order| {
                let more_m = if order == more { size_m } else { 0.0 };
                free(order) * measured_m(order, offset, error_m) + more_m
            }),
        };
        assert!(pair(0, 0.0).found_m[3] > 0.5e-6);
        assert!(are_made(&[pair(0, 0.0)]));
        assert!(!are_made(&[pair(8, 0.7e-6)]));
        assert!(!are_made(&[pair(3, 1.5e-6)]));
    }

    #[test]
    fn what_the_square_of_a_third_harmonic_makes_is_told_from_a_pattern() {
        let (pitch_m, third) = (1.0e-3, 0.05);
        // What must be added to the measured phase, over it.
        let (mut sine, mut cosine) = (0.0, 0.0);
        for k in 0..POINTS {
            let truth = TAU * k as f64 / POINTS as f64;
            let s = truth.sin() - third * (3.0 * truth).sin();
            let c = truth.cos() + third * (3.0 * truth).cos();
            let read = s.atan2(c);
            let error = (truth - read).sin().atan2((truth - read).cos());
            // Spaced evenly over the true phase: weighed by how densely that is read.
            let slope = 1.0 - 4.0 * third * (4.0 * truth).cos();
            let (to_s, to_c) = (8.0 * read).sin_cos();
            sine += slope * error * to_s;
            cosine += slope * error * to_c;
        }
        let eighth_m = 2.0 * f64::hypot(sine, cosine) / POINTS as f64 * pitch_m / TAU;
        let pair = |third: f64| Pair {
            offset: 0.0,
            third,
            pitch_m,
            baseline_m: [0.0; HIGHEST_ORDER + 1],
            found_m: std::array::from_fn(|order| if order == 8 { eighth_m } else { 0.0 }),
        };
        assert!(
            (eighth_m / (1.5 * third * third * pitch_m / TAU) - 1.0).abs() < 0.2,
            "{eighth_m:e}"
        );
        assert!(are_made(&[pair(third)]));
        assert!(!are_made(&[pair(0.5 * third)]));
    }
}
