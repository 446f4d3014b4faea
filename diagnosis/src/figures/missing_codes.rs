//! Codes that a converter never gives: a bit sticks, or steps are wide. What is rounded to those that are left is an error of which
//! no reading of its own tells more; how large it is follows from the gaps between the codes.

use super::fitted_effects::FittedEffects;
use super::location::Located;
use crate::algebra::statistics::{median, quantile};
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

/// Fewer steps from code to code tell no comb. Derived from chance: steps of a smooth distribution are exponential, and none of fifty is below
/// eight tenths of their median once in 10^11.
const FEWEST_STEPS: usize = 50;
/// Share of the steps that may be smaller than those of the comb. A prior: a disturbed reading may stand between two codes of the
/// comb, and of five hundred codes no more than ten do.
const SMALLER_STEPS: f64 = 0.02;
/// Steps of a comb from code to code are no smaller than this share of their median. Derived from rounding to whole counts, which
/// makes one of more than five counts at most a sixth smaller.
const LEAST_STEP: f64 = 0.8;
/// A comb that is so many times as wide as another channel's is no converter's own: all channels come through one. By definition a bit is
/// a factor of two.
const WIDER: f64 = 2.0;

impl FittedEffects<'_> {
    /// Where codes are missing, and the share of the excess that rounding to the others makes.
    pub(super) fn missing_codes(&self) -> Option<Located> {
        let linearized = &self.design.linearized;
        let variance_m2: [f64; 4] = rounding_m2(linearized.observations).map(|v| v.unwrap_or(0.0));
        if variance_m2.iter().all(|v| *v == 0.0) {
            return None;
        }
        let before = &self.before;
        // Of each row: what the rounding makes, and what noise makes beyond the stated one where the rows are whitened by louder noise. That noise
        // may be nothing but the rounding.
        let (mut rounding, mut louder) = (0.0, 0.0);
        for (sample, channel) in before.sample.iter().zip(&before.channel) {
            let rows = linearized.rows(*sample);
            let mut list = 0..rows.count;
            let Some(row) = list.find(|row| rows.channel[*row] == *channel) else {
                continue;
            };
            let slopes = rows.white_by_reading()[row];
            let by = |variance: &[f64]| -> f64 {
                let each = variance.iter().zip(slopes);
                each.map(|(v, slope)| v * slope * slope).sum()
            };
            let [found, stated] = [
                linearized.reading_variance(*sample),
                linearized.stated_variance(*sample),
            ];
            rounding += by(&variance_m2);
            louder += by(&found) - by(&stated);
        }
        let count = before.sample.len().max(1) as f64;
        let left = before.white_rms().powi(2) - self.floor.white_square;
        let excess = left + louder / count;
        (excess > 0.0).then(|| {
            let share = (rounding / count / excess).min(1.0);
            let segments = variance_m2.map(|v| v > 0.0);
            Located::of_segments("own tooth phase, missing codes", share, segments)
        })
    }
}

/// Variance of each segment's place by what its channels are rounded to, m²; none where no codes are missing.
fn rounding_m2(o: &Observations) -> [Option<f64>; 4] {
    let codes = [0, 1, 2, 3].map(|s| {
        [0, 1].map(|channel| {
            let finite = o.pair_counts[s].iter().map(|p| p[channel]);
            let mut codes: Vec<f64> = finite.filter(|c| c.is_finite()).collect();
            codes.sort_by(f64::total_cmp);
            codes
        })
    });
    let combs = codes
        .each_ref()
        .map(|pair| pair.each_ref().map(|c| comb(c)));
    let each = codes.as_flattened().iter().zip(combs.as_flattened());
    let known = each.filter(|(codes, _)| !codes.is_empty());
    let steps = known.map(|(_, comb)| comb.unwrap_or(1.0));
    let finest = steps.fold(f64::INFINITY, f64::min);
    std::array::from_fn(|s| {
        let amplitudes = o.amplitude_counts[s].iter().copied();
        let amplitude = crate::algebra::statistics::rms(amplitudes.filter(|a| a.is_finite()));
        let squares = [0, 1].map(|channel| {
            let wider = combs[s][channel].filter(|step| *step > WIDER * finest);
            let by_comb = wider.map(|step| step * step / 12.0);
            by_comb.or_else(|| missing(&codes[s][channel], amplitude))
        });
        if squares == [None, None] {
            return None;
        }
        // Each channel tells the phase on one half of the tooth.
        let mean = 0.5 * squares.iter().flatten().sum::<f64>();
        Some(mean * (o.pitch_m / TAU / amplitude).powi(2))
    })
}

/// Step from code to code, counts, of a channel whose codes stand at the points of a comb. Codes in their order.
fn comb(codes: &[f64]) -> Option<f64> {
    let steps = codes.windows(2).map(|pair| pair[1] - pair[0]);
    let mut steps: Vec<f64> = steps.filter(|step| *step > 0.0).collect();
    if steps.len() < FEWEST_STEPS {
        return None;
    }
    let least = quantile(&mut steps, SMALLER_STEPS)?;
    let usual = median(&mut steps)?;
    (usual > 1.0 && least > LEAST_STEP * usual).then_some(usual)
}

/// Mean square of what a channel is rounded off by, counts², where it shows gaps between its codes that are no chance.
/// Codes in their order.
fn missing(codes: &[f64], amplitude: f64) -> Option<f64> {
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
        in_order((0..8000).map(code).collect())
    }

    fn in_order(mut codes: Vec<f64>) -> Vec<f64> {
        codes.sort_by(f64::total_cmp);
        codes
    }

    /// A step of 76.7 counts, which too few readings pass for its gaps to be no chance one by one.
    #[test]
    fn a_comb_is_told_by_its_smallest_steps() {
        let step = 76.7;
        let found = comb(&codes(|c| ((c / step).round() * step).round())).unwrap();
        assert!((found - step).abs() < 1.0, "{found}");
        assert_eq!(comb(&codes(|c| c)), None);
        assert_eq!(comb(&codes(|c| (c / 16.0).round() * 16.0)), Some(16.0));
    }

    #[test]
    fn missing_codes_are_told_with_what_rounding_to_the_others_makes() {
        let step = 800.0;
        let found = missing(&codes(|c| (c / step).round() * step), 20_000.0).unwrap();
        assert!((found / (step * step / 12.0) - 1.0).abs() < 0.05, "{found}");
    }

    /// Every code; a converter of 12 bits in a word of 16; and a courier that was at forty places only.
    #[test]
    fn few_codes_are_no_missing_ones() {
        assert_eq!(missing(&codes(|c| c), 20_000.0), None);
        let of_twelve_bits = codes(|c| (c / 16.0).round() * 16.0);
        assert_eq!(missing(&of_twelve_bits, 20_000.0), None);
        let mut rng = ChaCha8Rng::seed_from_u64(8);
        let coordinate_blocks: Vec<f64> = (0..40)
            .map(|_| 20_000.0 * uniform(&mut rng, 0.0, TAU).sin())
            .collect();
        let noisy = |k: usize| (coordinate_blocks[k % 40] + uniform(&mut rng, -15.0, 15.0)).round();
        let few = in_order((0..8000).map(noisy).collect());
        assert_eq!((missing(&few, 20_000.0), comb(&few)), (None, None));
    }
}
