//! Harmonics that a pair's offset makes of those of equation (3). An offset of a part `e` of the amplitude moves the measured phase
//! against the true one by `e` times its sine, and a pattern of order n over the true phase is one of orders n - 1 and n + 1 over the
//! measured one, each n e / 2 as large (Jacobi and Anger's expansion to first order). A gap that changes the amplitude shows how large
//! the offset is: it is what makes the first order change with it.

use crate::baseline::ORDERS;
use crate::refine::Refined;
use std::f64::consts::TAU;

/// Orders that equation (3) lacks and an offset brings in, each with its neighbours that equation (3) has.
const MIXED: [(usize, [usize; 2]); 3] = [(3, [2, 4]), (5, [4, 6]), (7, [6, 8])];
/// A harmonic up to this many times what the offset makes is taken for it: the offset is known to some tenths.
const MARGIN: f64 = 2.0;
/// Share of the harmonics' power that may be beyond: second order in the offset.
const BEYOND: f64 = 0.1;

/// Highest order that is fitted, or more.
const MOST: usize = 40;

/// Amplitudes of one pair's harmonics by their order, m, and its offset as a part of the amplitude.
struct Pair {
    offset: f64,
    /// Equation (3)'s.
    baseline_m: [f64; MOST + 1],
    /// Free ones.
    found_m: [f64; MOST + 1],
}

/// True if the free harmonics that are found are what the offsets that the gap shows make of equation (3)'s.
pub(super) fn are_the_gaps_own(fine: &Refined) -> bool {
    let pitch_m = fine.scene.observations.pitch_m;
    let offset_m = |s: usize| amplitude_m(fine, "gap_variation", "amplitude times ", 1, s);
    let pairs: [Pair; 4] = std::array::from_fn(|s| Pair {
        offset: offset_m(s) * TAU / pitch_m,
        baseline_m: std::array::from_fn(|order| baseline_m(fine, order, s)),
        found_m: std::array::from_fn(|order| amplitude_m(fine, "extra_harmonics", "", order, s)),
    });
    are_made(&pairs)
}

fn are_made(pairs: &[Pair]) -> bool {
    let (mut power, mut beyond) = (0.0, 0.0);
    for pair in pairs {
        for (order, found_m) in pair.found_m.iter().enumerate() {
            let mixed = MIXED.iter().find(|(to, _)| *to == order);
            let from = mixed.map_or([0; 2], |(_, from)| *from);
            let made_m = from.map(|n| 0.5 * n as f64 * pair.offset * pair.baseline_m[n]);
            let more_m = found_m - MARGIN * made_m.iter().sum::<f64>();
            power += found_m.powi(2);
            beyond += more_m.max(0.0).powi(2);
        }
    }
    power > 0.0 && beyond < BEYOND * power
}

/// Amplitude of a sine and a cosine of an effect; zero where it has none.
fn amplitude_m(fine: &Refined, effect: &str, label: &str, order: usize, segment: usize) -> f64 {
    let Some(block) = fine.columns.blocks.iter().find(|b| b.name == effect) else {
        return 0.0;
    };
    let part = |part: &str| {
        let name = format!("{label}order {order} {part}, segment {}", segment + 1);
        let mut columns = block.columns.clone();
        let column = columns.find(|c| fine.columns.regressors[*c].name == name);
        column.map_or(0.0, |c| fine.amount(c))
    };
    part("sine").hypot(part("cosine"))
}

/// Amplitude of an order of equation (3); zero where it has none.
fn baseline_m(fine: &Refined, order: usize, segment: usize) -> f64 {
    let k_m = &fine.scene.baseline.k_m[segment];
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
        let (offset, mut baseline_m) = (0.12, [0.0; MOST + 1]);
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
}
