//! How few bits numbers can take: what their noise alone holds.
//!
//! A number that is told by those before it, but for noise of deviation σ steps of its last digit, holds `log2(σ √(2πe))` bits (the entropy of a
//! normal density; Cover and Thomas 2006, section 8.1): no form that tells it so takes fewer in the mean. What is told is asked of a linear prediction, as
//! codecs of sound do (Robinson 1994): a motion past teeth makes sine and cosine waves, and a few numbers before tell the next. A form that knows one
//! column by another may take less.

use crate::decimal::decimals;
use nalgebra::{DMatrix, DVector};
use std::collections::HashSet;
use std::f64::consts::{E, TAU};

/// Numbers that are predicted by one set of coefficients. By definition of Parquet's differences, which have as many in a block of their own.
const BLOCK: usize = 128;
/// Numbers before each by which any form may predict it. Derived from waves without noise: two of them tell one that goes on, so that four tell a channel's
/// own wave and its second order.
pub const BY_ANY_FORM: usize = 4;
/// Numbers before each by which an encoding of Parquet tells it: by definition of its differences one, and of all others none.
pub const BY_PARQUET: usize = 1;
/// Deviation of a normal density over the median of its absolute values: by definition of the normal distribution's quartile, 0.6745.
const DEVIATION_OVER_MEDIAN: f64 = 1.4826;

/// The least bits that all of a column's numbers take where each is told by so many `before` it ([`BY_ANY_FORM`], [`BY_PARQUET`]), NaN left out. Of numbers
/// with more digits than are exact each holds 64 where it is first.
#[must_use]
pub fn least_bits(numbers: &[f64], before: usize) -> f64 {
    let numbers: Vec<f64> = numbers.iter().copied().filter(|n| !n.is_nan()).collect();
    let Some((steps, _)) = decimals(&numbers) else {
        let distinct: HashSet<u64> = numbers.iter().map(|number| number.to_bits()).collect();
        return 64.0 * distinct.len() as f64;
    };
    let steps: Vec<f64> = steps.iter().map(|step| *step as f64).collect();
    let blocks = (before..steps.len()).step_by(BLOCK);
    let bits = |first: usize| {
        let last = steps.len().min(first + BLOCK);
        (last - first) as f64 * of_block(&steps[first - before..last], before)
    };
    blocks.map(bits).sum()
}

/// Bits of each number behind the first few of these, which predict the next.
fn of_block(steps: &[f64], before: usize) -> f64 {
    let count = steps.len() - before;
    // So few are told by themselves.
    if count <= 2 * (before + 1) {
        return 0.0;
    }
    let base = steps[0];
    let design = DMatrix::from_fn(count, before + 1, |row, k| {
        if k == before {
            1.0
        } else {
            steps[row + k] - base
        }
    });
    let wanted = DVector::from_fn(count, |row, _| steps[row + before] - base);
    // Singular values: of a motion at rest the columns are alike.
    let solved = design.clone().svd(true, true).solve(&wanted, 1.0e-9);
    let Ok(coefficients) = solved else {
        return 0.0;
    };
    let mut left: Vec<f64> = (design * coefficients - wanted)
        .iter()
        .map(|left| left.abs())
        .collect();
    let middle = count / 2;
    let median = *left.select_nth_unstable_by(middle, f64::total_cmp).1;
    // The coefficients have taken a part of it: rather too little is told than too much.
    let deviation = DEVIATION_OVER_MEDIAN * median;
    (deviation * (TAU * E).sqrt()).log2().max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The generator of Numerical Recipes, chapter 7.1; a normal number is a sum of twelve.
    fn normal(state: &mut u64) -> f64 {
        let mut uniform = || {
            *state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (*state >> 11) as f64 / (1u64 << 53) as f64
        };
        (0..12).map(|_| uniform()).sum::<f64>() - 6.0
    }

    /// Noise of a known deviation about rest: its entropy, within what a block of so many tells of a deviation by its median, 1.17 / √128 of it, over
    /// the root of the blocks.
    #[test]
    fn noise_at_rest_holds_its_entropy() {
        let mut state = 1;
        for deviation in [3.0, 20.0, 300.0] {
            let numbers: Vec<f64> = (0..12_800)
                .map(|_| (1_000.0 + deviation * normal(&mut state)).round())
                .collect();
            let wanted = (deviation * (TAU * E).sqrt()).log2();
            let found = least_bits(&numbers, BY_ANY_FORM) / numbers.len() as f64;
            assert!(
                (found - wanted).abs() < 0.05,
                "{deviation}: {found} {wanted}"
            );
        }
    }

    /// A wave adds no bits of its own: four numbers tell it, and what noise these carry over is under a bit.
    #[test]
    fn a_motion_past_teeth_adds_less_than_a_bit() {
        let mut state = 2;
        let noise = 20.0;
        let numbers: Vec<f64> = (0..12_800)
            .map(|k| (20_000.0 * (0.2 * f64::from(k)).sin() + noise * normal(&mut state)).round())
            .collect();
        let alone = (noise * (TAU * E).sqrt()).log2();
        let found = least_bits(&numbers, BY_ANY_FORM) / numbers.len() as f64;
        assert!((alone..alone + 1.0).contains(&found), "{found} {alone}");
    }

    /// One number tells the next of a wave but for its other quadrant: what is left is a wave of sin(0.2) of its size.
    #[test]
    fn one_number_before_tells_less_of_a_wave_than_four() {
        let mut state = 3;
        let wave = |k: i32| {
            (20_000.0 * (0.2 * f64::from(k)).sin() + 20.0 * normal(&mut state)).round() + 0.0
        };
        let numbers: Vec<f64> = (0..12_800).map(wave).collect();
        let found = least_bits(&numbers, BY_PARQUET) / numbers.len() as f64;
        let median = 20_000.0 * 0.2_f64.sin() * 0.5_f64.sqrt();
        let wanted = (DEVIATION_OVER_MEDIAN * median * (TAU * E).sqrt()).log2();
        assert!((found - wanted).abs() < 0.1, "{found} {wanted}");
    }

    #[test]
    fn what_is_told_holds_nothing_and_what_has_too_many_digits_all() {
        let ramp: Vec<f64> = (0..1000).map(|k| f64::from(k) * 0.25).collect();
        assert_eq!(least_bits(&ramp, BY_ANY_FORM), 0.0);
        assert_eq!(least_bits(&[f64::NAN, 7.0, f64::NAN], BY_ANY_FORM), 0.0);
        assert_eq!(
            least_bits(&[1.0 / 3.0, f64::NAN, 1.0 / 3.0], BY_ANY_FORM),
            64.0
        );
    }
}
