//! The stated noise, where it is too large to judge by: nothing but the statement can be said to be wrong then.

use super::ModelSelection;
use crate::algebra::statistics::rms;
use crate::data::channel_names::CHANNEL_NAMES;
use crate::data::observations::MINIMUM_SAMPLES;
use crate::inference::residuals::Residuals;

/// A recording that scatters by less than this share of the stated noise cannot be judged by it.
const TOO_QUIET_RATIO: f64 = 0.7;
/// Where a channel shows that a stated noise is not there, a gap must stand this far above what is stated: sets of effects are
/// weighed against that noise, and twice the rms leaves it a quarter of the squares.
const ABOVE_STATED_RATIO: f64 = 2.0;

impl ModelSelection<'_> {
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

    /// True if the channel that shows the gap is left with less than its noise, though the readings themselves do not say that the
    /// statement is too large: then the shapes that were found hold the noise, and no cause.
    pub(super) fn holds_the_noise(&self) -> bool {
        let main = self.main_channel();
        let mut quiet = self.quiet_channels().into_iter();
        self.prepared.overstated.is_none() && quiet.any(|(c, _)| CHANNEL_NAMES[c] == main)
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
