//! Whether another recording confirms what was claimed.
//!
//! For each channel the claimed residual and the one that came are two numbers with an interval each. Their logarithms are taken as
//! normal, with the deviations that the 95 % intervals show; then how far the two truly differ is normal as well, about what is seen
//! and with both variances. A claim is confirmed where that difference is more likely below [`WITHIN`] than above. This is the test
//! for equivalence of Schuirmann (1987), which asks whether a difference is small and not whether it is proven to be there, told as
//! a probability with a flat prior for the difference.

use crate::algebra::statistics::NORMAL_97_5;
use crate::verdict::answer::{HeldOut, HeldOutChannel};
use serde::{Deserialize, Serialize};

/// Claims are right within this share. By definition that which `courier blind` judges by as well.
pub const WITHIN: f64 = 0.10;
/// More likely than not. By definition of likely: a half.
const LIKELY: f64 = 0.5;

/// The claim beside what came.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Confirmation {
    /// True if every channel is confirmed.
    pub confirmed: bool,
    /// The least probability of the channels'.
    pub probability: f64,
    /// Difference that still counts as confirmed, as a share.
    pub within: f64,
    /// By channel.
    pub channels: Vec<ConfirmedChannel>,
}

/// One channel's.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ConfirmedChannel {
    /// Channel.
    pub channel: String,
    /// What was claimed, rms m, with this recording's noise in the place of the other's.
    pub claimed_rms_m: f64,
    /// What came, rms m.
    pub came_rms_m: f64,
    /// Probability that the two differ by less than [`WITHIN`].
    pub probability: f64,
    /// The same if both numbers were equal: below a half the recordings are too short to confirm anything.
    pub probability_at_best: f64,
    /// Whether it is confirmed.
    pub confirmed: bool,
}

impl Confirmation {
    /// Of the figures that were claimed and those that came. Channels that only one of them has are left out.
    #[must_use]
    pub fn new(claimed: &HeldOut, came: &HeldOut) -> Self {
        let beside = |came: &HeldOutChannel| {
            let same = claimed.channels.iter().find(|c| c.channel == came.channel);
            same.map(|claimed| channel(claimed, came))
        };
        let channels: Vec<ConfirmedChannel> = came.channels.iter().filter_map(beside).collect();
        let least = channels.iter().map(|c| c.probability).fold(1.0, f64::min);
        Self {
            confirmed: !channels.is_empty() && channels.iter().all(|c| c.confirmed),
            probability: if channels.is_empty() { 0.0 } else { least },
            within: WITHIN,
            channels,
        }
    }
}

fn channel(claimed: &HeldOutChannel, came: &HeldOutChannel) -> ConfirmedChannel {
    let claimed_rms_m = at_other_noise_m(claimed, came.floor_rms_m);
    let difference = (came.after_rms_m / claimed_rms_m).ln();
    let deviation = log_deviation(claimed).hypot(log_deviation(came));
    let probability = within(difference, deviation);
    ConfirmedChannel {
        channel: came.channel.clone(),
        claimed_rms_m,
        came_rms_m: came.after_rms_m,
        probability,
        probability_at_best: within(0.0, deviation),
        confirmed: probability >= LIKELY,
    }
}

/// What is claimed is what the model leaves and the noise: the same with another recording's noise, rms m.
fn at_other_noise_m(claimed: &HeldOutChannel, floor_m: f64) -> f64 {
    if claimed.floor_rms_m <= 0.0 || floor_m <= 0.0 {
        return claimed.after_rms_m;
    }
    // Where the stated noise is too large, less than it is left, and all of that is noise.
    let noise_m = claimed.after_rms_m.min(claimed.floor_rms_m);
    let left = claimed.after_rms_m.powi(2) - noise_m.powi(2);
    left.sqrt().hypot(noise_m * floor_m / claimed.floor_rms_m)
}

/// Standard deviation of the logarithm of an rms, as its interval shows it.
fn log_deviation(channel: &HeldOutChannel) -> f64 {
    let [low, high] = channel.after_ci95_m;
    let width = (high / low).ln() / (2.0 * NORMAL_97_5);
    if width.is_finite() {
        width.max(0.0)
    } else {
        0.0
    }
}

/// Probability that a normal logarithm of a ratio is that of a ratio within [`WITHIN`] of one.
fn within(mean: f64, deviation: f64) -> f64 {
    let [low, high] = [(1.0 - WITHIN).ln(), (1.0 + WITHIN).ln()];
    if !mean.is_finite() {
        return 0.0;
    }
    if deviation <= 0.0 {
        return f64::from(u8::from((low..=high).contains(&mean)));
    }
    normal((high - mean) / deviation) - normal((low - mean) / deviation)
}

/// Standard normal distribution, to 1e-7 (Abramowitz and Stegun 1964, 26.2.17).
fn normal(x: f64) -> f64 {
    /// Coefficients of the normal distribution's tail (Zelen and Severo 1964, equation 26.2.17), exact to 7.5e-8.
    const COEFFICIENTS: [f64; 5] = [
        0.319_381_530,
        -0.356_563_782,
        1.781_477_937,
        -1.821_255_978,
        1.330_274_429,
    ];
    let t = 1.0 / (1.0 + 0.231_641_9 * x.abs());
    let sum = COEFFICIENTS.iter().rev().fold(0.0, |sum, c| (sum + c) * t);
    let above = (-0.5 * x * x).exp() / (2.0 * std::f64::consts::PI).sqrt() * sum;
    if x > 0.0 { 1.0 - above } else { above }
}

#[cfg(test)]
mod tests {
    use super::*;
    use effects::random::{ChaCha8Rng, SeedableRng, normal as drawn};

    fn held_out(after_rms_m: f64, share: f64, floor_rms_m: f64) -> HeldOut {
        HeldOut {
            channels: vec![HeldOutChannel {
                channel: "g_p".into(),
                after_rms_m,
                after_ci95_m: [after_rms_m / (1.0 + share), after_rms_m * (1.0 + share)],
                floor_rms_m,
                ..HeldOutChannel::default()
            }],
            ..HeldOut::default()
        }
    }

    #[test]
    fn the_normal_distribution_at_known_points() {
        for (x, wanted) in [
            (0.0, 0.5),
            (1.0, 0.841_344_7),
            (-1.96, 0.024_997_9),
            (3.0, 0.998_650_1),
        ] {
            assert!((normal(x) - wanted).abs() < 1.0e-6, "{x}");
        }
    }

    #[test]
    fn what_came_is_confirmed_within_a_tenth_and_by_how_well_both_are_known() {
        let at = |came: f64, share: f64| {
            Confirmation::new(&held_out(1.0, share, 0.0), &held_out(came, share, 0.0))
        };
        for share in [0.01, 0.03, 0.08] {
            assert!(at(1.02, share).confirmed, "{share}");
            assert!(!at(1.2, share).confirmed, "{share}");
            assert!(!at(0.8, share).confirmed, "{share}");
        }
        assert!(at(1.02, 0.01).probability > at(1.02, 0.05).probability);
        // Too short to confirm anything, however equal both numbers are.
        let short = at(1.0, 0.6);
        assert!(!short.confirmed && short.channels[0].probability_at_best < 0.5);
        let nothing = Confirmation::new(&HeldOut::default(), &held_out(1.0, 0.1, 0.0));
        assert!(!nothing.confirmed && nothing.channels.is_empty());
    }

    #[test]
    fn another_noise_is_no_contradiction() {
        let left = |floor: f64| 0.3_f64.hypot(floor);
        let claimed = held_out(left(1.0), 0.03, 1.0);
        let quieter = held_out(left(0.5), 0.03, 0.5);
        assert!(Confirmation::new(&claimed, &quieter).confirmed);
        // Half of the noise and yet as much left is more than was claimed.
        let not_quieter = held_out(left(1.0), 0.03, 0.5);
        assert!(!Confirmation::new(&claimed, &not_quieter).confirmed);
        // Stated too large on both.
        let estimate = Confirmation::new(&held_out(0.9, 0.03, 1.0), &held_out(0.45, 0.03, 0.5));
        assert!(estimate.confirmed && (estimate.channels[0].claimed_rms_m - 0.45).abs() < 1e-12);
    }

    /// Pairs whose true values differ by a known share are confirmed as often as their mean probability says.
    #[test]
    fn the_probability_is_that_of_the_true_difference() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let share = 0.08_f64;
        let deviation = (1.0 + share).ln() / NORMAL_97_5;
        let (mut foretold, mut true_ones, mut pairs) = (0.0, 0.0, 0.0);
        for _ in 0..4000 {
            // A wide prior stands for the flat one.
            let difference = 0.2 * drawn(&mut rng);
            let [claimed, came] =
                [0.0, difference].map(|mean: f64| (mean + deviation * drawn(&mut rng)).exp());
            let estimate =
                Confirmation::new(&held_out(claimed, share, 0.0), &held_out(came, share, 0.0));
            foretold += estimate.probability;
            true_ones += f64::from(u8::from(((difference.exp()) - 1.0).abs() <= WITHIN));
            pairs += 1.0;
        }
        let [foretold, true_ones] = [foretold, true_ones].map(|sum: f64| sum / pairs);
        // Three deviations of the share of so many pairs, and what the wide prior pulls.
        let chance = 3.0 * (0.25_f64 / pairs).sqrt() + 0.03;
        assert!(
            (foretold - true_ones).abs() < chance,
            "{foretold} {true_ones}"
        );
    }
}
