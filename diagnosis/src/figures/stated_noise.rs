//! The stated noise, where it is too large to judge by: nothing but the statement can be said to be wrong then.

use super::fitted_effects::FittedEffects;
use crate::algebra::statistics::rms;
use crate::data::channel_names::CHANNEL_NAMES;
use crate::data::observations::MINIMUM_SAMPLES;
use crate::inference::residuals::Residuals;

/// A recording that scatters by less than this share of the stated noise cannot be judged by it.
/// By definition: half of the squares that are stated are not there.
const TOO_QUIET_RATIO: f64 = 0.7;
/// Where a channel shows that a stated noise is not there, a gap must stand this far above what is stated: sets of effects are
/// weighed against that noise, and twice the rms leaves it a quarter of the squares.
/// Derived from squares: of twice the rms a quarter is that noise.
const ABOVE_STATED_RATIO: f64 = 2.0;

/// All channels this far above the stated noise, and alike: the statement may be what is wrong. A prior: of a data sheet's noise, which is
/// right to a factor of two, twice that.
const MISSTATED_RATIO: f64 = 4.0;
/// Channels are alike if the quietest has this share of the loudest. A prior: a factor of two, with a quarter of it for chance.
const ALIKE_SHARE: f64 = 0.4;

impl FittedEffects<'_> {
    /// The limit that is violated, by the whitened rms before and after. A filter makes noise smooth and leaves its size: less
    /// scatter on smooth paths alone is no reason.
    pub(super) fn too_quiet(&self, before: f64, after: f64) -> Option<String> {
        if before < TOO_QUIET_RATIO {
            return Some(format!(
                "stated noise: the recording scatters by {before:.2} of what is stated, at least {TOO_QUIET_RATIO} wanted"
            ));
        }
        let limit = self.prepared.overstated.as_ref();
        limit
            .filter(|_| after < TOO_QUIET_RATIO)
            .map(ToString::to_string)
            .or_else(|| self.quiet_channel().filter(|_| before < ABOVE_STATED_RATIO))
    }

    /// What speaks for the statement being wrong, of noise that is shown to be louder than stated: it is far louder, and in every channel alike.
    pub(super) fn too_loud(&self, after: f64) -> Option<String> {
        (after > MISSTATED_RATIO || self.is_misstated()).then(|| {
            format!(
                "stated noise: what is left scatters as noise does, by {after:.1} times what is stated, at most {MISSTATED_RATIO} wanted: it may be the statement that is wrong"
            )
        })
    }

    /// True if platen and coordination sensor exceed their stated noise alike: then the statement may be wrong, not a channel.
    fn is_misstated(&self) -> bool {
        let after = &self.after;
        let channels = after.channels().into_iter();
        let over_stated = channels
            .map(|c| after.channel_rms_m(c).0 / self.floor.channel_rms_m[c].max(f64::MIN_POSITIVE));
        let (low, high) =
            over_stated.fold((f64::INFINITY, 0.0f64), |(l, h), r| (l.min(r), h.max(r)));
        low > MISSTATED_RATIO && low > ALIKE_SHARE * high
    }

    /// A channel that is left with less than the stated noise, as it is where one of its readings' noise is stated too large.
    pub(super) fn quiet_channel(&self) -> Option<String> {
        let quiet = self.quiet_channels().into_iter();
        let quietest = quiet.min_by(|a, b| a.1.total_cmp(&b.1));
        quietest.map(|(channel, found)| {
            format!(
                "stated noise: {} is left with {found:.2} of what is stated, at least {TOO_QUIET_RATIO} wanted",
                CHANNEL_NAMES[channel]
            )
        })
    }

    fn quiet_channels(&self) -> Vec<(usize, f64)> {
        quiet(&self.after, self.floor.white_square.sqrt())
    }
}

/// Channels with too little of their stated noise, beyond chance: four standard deviations of an rms.
fn quiet(residuals: &Residuals, floor: f64) -> Vec<(usize, f64)> {
    let found = |channel: usize| {
        let rows = residuals.white.iter().zip(&residuals.channel);
        let white: Vec<f64> = rows
            .filter(|(_, c)| **c == channel)
            .map(|(white, _)| *white)
            .collect();
        let chance = 4.0 / (2.0 * white.len() as f64).sqrt();
        let found = rms(white.iter().copied()) / floor;
        let quiet = white.len() >= MINIMUM_SAMPLES && found < TOO_QUIET_RATIO * (1.0 - chance);
        quiet.then_some((channel, found))
    };
    residuals.channels().into_iter().filter_map(found).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use effects::random::{ChaCha8Rng, SeedableRng, normal};

    #[test]
    fn a_channel_far_below_its_stated_noise_is_told_and_one_by_chance_is_not() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let mut residuals = Residuals::default();
        for k in 0..3000 {
            residuals.channel.push(k % 3);
            let size = if k % 3 == 1 { 0.1 } else { 1.0 };
            residuals.white.push(size * normal(&mut rng));
        }
        let [(1, found)] = quiet(&residuals, 1.0)[..] else {
            panic!("{:?}", quiet(&residuals, 1.0));
        };
        assert!((found - 0.1).abs() < 0.02, "{found}");
        residuals.channel.iter_mut().for_each(|c| *c = 0);
        residuals.white.truncate(0);
        let white = residuals.channel.iter().map(|_| 0.8 * normal(&mut rng));
        residuals.white = white.collect();
        assert_eq!(quiet(&residuals, 1.0), []);
    }
}
