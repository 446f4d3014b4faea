//! Codes that a converter never gives: a bit sticks, or steps are wide. What is rounded to those that are left is an error of which
//! no reading of its own tells more; how large it is follows from the gaps between the codes.

use super::fitted_effects::FittedEffects;
use super::location::Located;
use crate::algebra::statistics::median;
use crate::data::observations::Observations;
use std::f64::consts::{PI, TAU};

/// Samples by which a gap is no chance that should have fallen into it, were it not one. Derived from Poisson's distribution:
/// none of twelve comes once in 160,000.
const EXPECTED_IN_GAP: f64 = 12.0;
/// Share of a channel's range that such gaps must fill.
const GAPS_SHARE_OF_RANGE: f64 = 0.3;
/// Part by which their widths may differ, and the least number of them.
const WIDTH_TOLERANCE: f64 = 0.15;
/// See [`WIDTH_TOLERANCE`].
const FEWEST_GAPS: usize = 8;

impl FittedEffects<'_> {
    /// Where codes are missing, and the share of the excess that rounding to the others makes.
    pub(super) fn missing_codes(&self) -> Option<Located> {
        let linearized = &self.design.linearized;
        let variance_m2: [f64; 4] =
            std::array::from_fn(|s| rounding_m2(linearized.observations, s).unwrap_or(0.0));
        if variance_m2.iter().all(|v| *v == 0.0) {
            return None;
        }
        let before = &self.before;
        let synthetic_problem: f64 = (0..before.sample.len())
            .map(|k| {
                let rows = linearized.rows(before.sample[k]);
                let mut list = 0..rows.count;
                let row = list.find(|row| rows.channel[*row] == before.channel[k]);
                let slopes = row.map(|row| rows.white_by_reading()[row]);
                let of = |s: usize| slopes.map_or(0.0, |slopes| slopes[s].powi(2) * variance_m2[s]);
                (0..4).map(of).sum::<f64>()
            })
            .sum();
        let count = before.sample.len().max(1) as f64;
        let excess = before.white_rms().powi(2) - self.floor.white_square;
        (excess > 0.0).then(|| {
            let share = (synthetic_problem / count / excess).min(1.0);
            let segments = variance_m2.map(|v| v > 0.0);
            Located::of_segments("own tooth phase, missing codes", share, segments)
        })
    }
}

/// Variance of a segment's place by what its channels are rounded to, m²; none where no codes are missing.
fn rounding_m2(o: &Observations, segment: usize) -> Option<f64> {
    let pairs = &o.pair_counts[segment];
    let amplitudes = o.amplitude_counts[segment].iter().copied();
    let amplitude = crate::algebra::statistics::rms(amplitudes.filter(|a| a.is_finite()));
    let squares = [0, 1].map(|channel| {
        let finite = pairs.iter().map(|p| p[channel]).filter(|c| c.is_finite());
        missing(finite.collect(), amplitude)
    });
    if squares == [None, None] {
        return None;
    }
    // Each channel tells the phase on one half of the tooth.
    let mean = 0.5 * squares.iter().flatten().sum::<f64>();
    Some(mean * (o.pitch_m / TAU / amplitude).powi(2))
}

/// Mean square of what a channel is rounded off by, counts², where it shows gaps between its codes that are no chance.
fn missing(mut codes: Vec<f64>, amplitude: f64) -> Option<f64> {
    codes.sort_by(f64::total_cmp);
    let range = codes.last()? - codes.first()?;
    // A sine is rarest in the middle of its range.
    let density = codes.len() as f64 / (PI * amplitude);
    let gaps = codes.windows(2).map(|pair| pair[1] - pair[0]);
    let wide = gaps.filter(|gap| gap * density > EXPECTED_IN_GAP && *gap > 1.0);
    let mut wide: Vec<f64> = wide.collect();
    let usual = median(&mut wide)?;
    // A courier that was at a few places only leaves gaps of all widths.
    wide.retain(|gap| (gap / usual - 1.0).abs() < WIDTH_TOLERANCE);
    let filled: f64 = wide.iter().sum();
    let cubes: f64 = wide.iter().map(|gap| gap.powi(3)).sum();
    let regular = wide.len() >= FEWEST_GAPS && filled > GAPS_SHARE_OF_RANGE * range;
    regular.then(|| cubes / 12.0 / range)
}

#[cfg(test)]
mod tests {
    use super::*;
    use effects::random::{ChaCha8Rng, SeedableRng, uniform};

    fn codes(of: impl Fn(f64) -> f64) -> Vec<f64> {
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let mut phase = || uniform(&mut rng, 0.0, TAU);
        let code = |_| of((20_000.0 * phase().sin()).round());
        (0..8000).map(code).collect()
    }

    #[test]
    fn missing_codes_are_told_with_what_rounding_to_the_others_makes() {
        let step = 800.0;
        let found = missing(codes(|c| (c / step).round() * step), 20_000.0).unwrap();
        assert!((found / (step * step / 12.0) - 1.0).abs() < 0.05, "{found}");
    }

    /// Every code; a converter of 12 bits in a word of 16; and a courier that was at forty places only.
    #[test]
    fn few_codes_are_no_missing_ones() {
        assert_eq!(missing(codes(|c| c), 20_000.0), None);
        let of_twelve_bits = codes(|c| (c / 16.0).round() * 16.0);
        assert_eq!(missing(of_twelve_bits, 20_000.0), None);
        let mut rng = ChaCha8Rng::seed_from_u64(8);
        let coordinate_blocks: Vec<f64> = (0..40)
            .map(|_| 20_000.0 * uniform(&mut rng, 0.0, TAU).sin())
            .collect();
        let noisy = |k: usize| (coordinate_blocks[k % 40] + uniform(&mut rng, -15.0, 15.0)).round();
        assert_eq!(missing((0..8000).map(noisy).collect(), 20_000.0), None);
    }
}
