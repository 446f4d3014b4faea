//! The best that anybody could do on a case: the ideal observer of signal detection (Green and Swets 1966, Signal Detection Theory and
//! Psychophysics, chapter 6).
//!
//! It knows the courier's calibration up to what equations (3), (10) and (11) can take, every other effect of the case exactly, the figure
//! that the effect in question would make exactly, and how often such an effect is drawn. It decides one thing by the recording: whether
//! the effect acts. A diagnosis has to find the figure as well, so it is right less often than that.
//!
//! Missing codes are the exception: what they do follows the noise, and of that only what two draws of noise have in common is counted. The
//! observer's share is too low there.

use diagnosis::linearization::separation::{Separation, separation};
use diagnosis::posterior::least_size::least_squares;
use effects::Detection;
use libm::erfc;
use serde::{Deserialize, Serialize};
use specimens::{Case, Drawn};

/// What a recording shows of the effects of its case.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ideal {
    /// Probability that the ideal observer is right about the case: that it sees each of its effects. One where nothing acts, since what it
    /// does not see it does not name.
    pub seen: f64,
    /// Whether each effect does as much on this recording as the diagnosis asks of a cause before it names it ([`least_squares`]).
    pub worth_a_name: bool,
}

/// What a case's first recording shows of its effects. Cost: four recordings and four calibrations for each effect.
#[must_use]
pub fn ideal(case: &Case) -> Ideal {
    let none = Ideal {
        seen: 1.0,
        worth_a_name: true,
    };
    case.effects.iter().fold(none, |all, effect| {
        let one = of_one(case, effect);
        Ideal {
            seen: all.seen * one.seen,
            worth_a_name: all.worth_a_name && one.worth_a_name,
        }
    })
}

/// What it shows of one effect of a case.
fn of_one(case: &Case, effect: &Drawn) -> Ideal {
    let [[with, without], [with_again, without_again]] =
        [0, 1].map(|noise| case.with_and_without(&effect.name, noise));
    let Ok(each) = separation([&with, &without], [&with_again, &without_again]) else {
        return Ideal {
            seen: 0.0,
            worth_a_name: false,
        };
    };
    let variance = case.noise_over_stated().powi(2);
    let each = each.map(|channel| Separation {
        squares: channel.squares / variance,
        ..channel
    });
    let squares: f64 = each.iter().map(|channel| channel.squares).sum();
    let rows: usize = each.iter().map(|channel| channel.rows).sum();
    let ratio = if effects::is(&effect.name, Detection::AsNoise) {
        of_noise(&each)
    } else {
        of_a_figure(squares)
    };
    let acts = case.share_that_acts();
    Ideal {
        seen: ratio.exceeds(((1.0 - acts) / acts).ln()),
        worth_a_name: squares > least_squares(rows as f64),
    }
}

/// Logarithm of how much likelier the readings are with the effect than without it, where it acts: a normal number, being a sum over many rows.
#[derive(Clone, Copy, Debug, PartialEq)]
struct LikelihoodRatio {
    mean: f64,
    variance: f64,
}

impl LikelihoodRatio {
    /// Probability that it is above a value.
    fn exceeds(self, value: f64) -> f64 {
        if self.variance <= 0.0 {
            return 0.0;
        }
        0.5 * erfc((value - self.mean) / (2.0 * self.variance).sqrt())
    }
}

/// Of a figure of `V` whitened squares: its mean is `V/2` and its variance `V`.
fn of_a_figure(squares: f64) -> LikelihoodRatio {
    let squares = squares.max(0.0);
    LikelihoodRatio {
        mean: 0.5 * squares,
        variance: squares,
    }
}

/// Of noise that adds `s` times the variance to each of `n` rows: its mean is `n (s − ln(1 + s)) / 2` and its variance `n s² / 2`.
fn of_noise(each: &[Separation]) -> LikelihoodRatio {
    let of = |channel: &Separation| {
        let rows = channel.rows.max(1) as f64;
        let more = channel.squares.max(0.0) / rows;
        [0.5 * rows * (more - more.ln_1p()), 0.5 * rows * more * more]
    };
    let [mean, variance] = each
        .iter()
        .map(of)
        .fold([0.0; 2], |sum, one| [sum[0] + one[0], sum[1] + one[1]]);
    LikelihoodRatio { mean, variance }
}

#[cfg(test)]
mod tests {
    use super::*;
    use specimens::{Conditions, Kind};

    /// A courier with a short recording: with a beacon for `seed` 52, without one for 46.
    fn single(seed: u64, name: &str, size_m: f64) -> Case {
        Case {
            number: 0,
            seed,
            kind: Kind::Single,
            effects: vec![Drawn {
                name: name.into(),
                size_m,
            }],
            conditions: Conditions::Drawn,
        }
    }

    /// What does nothing is never seen, what does much is always seen, and at twice the logarithm of the odds against it half of them are.
    #[test]
    fn what_shows_is_seen() {
        let of = |squares: f64| of_a_figure(squares).exceeds(3.0);
        assert_eq!(of(0.0), 0.0);
        assert!((of(6.0) - 0.5).abs() < 1e-12);
        assert!(of(100.0) > 0.999);
        // Of noise the second order alone is seen: n s²/4, and not n s/2.
        let channel = Separation {
            squares: 100.0,
            rows: 10_000,
        };
        assert!(of_noise(&[channel]).exceeds(3.0) < 0.01);
    }

    /// Harmonics are seen at a micrometre and not at a tenth of a nanometre; without a beacon nobody sees what acts on it alone.
    #[test]
    fn what_an_effect_shows_follows_its_size() {
        let of = |size_m: f64| ideal(&single(52, "extra_harmonics", size_m));
        let [large, small] = [1.0e-6, 1.0e-10].map(of);
        assert!(large.seen > 0.999 && large.worth_a_name, "{large:?}");
        assert!(small.seen < 0.01 && !small.worth_a_name, "{small:?}");
        let of = |seed: u64| ideal(&single(seed, "psd_nonlinearity", 2.0e-6));
        let [shown, hidden] = [52, 46].map(of);
        assert!(shown.seen > 0.999, "{shown:?}");
        assert!(hidden.seen == 0.0 && !hidden.worth_a_name, "{hidden:?}");
    }
}
