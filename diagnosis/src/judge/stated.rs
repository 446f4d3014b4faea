//! The stated noise, where it is too large to judge by: nothing but the statement can be said to be wrong then.

use super::{CHANNEL_NAMES, Judge};
use crate::heldout::Residuals;
use crate::observe::MINIMUM_SAMPLES;
use crate::statistics::rms;

/// A recording that scatters by less than this share of the stated noise cannot be judged by it.
const TOO_QUIET: f64 = 0.7;
/// Where a channel shows that a stated noise is not there, a gap must stand this far above what is stated: sets of effects are
/// weighed against that noise, and twice the rms leaves it a quarter of the squares.
const ABOVE_STATED: f64 = 2.0;

impl Judge<'_> {
    /// The limit that is violated, by the whitened rms before and after. A filter makes noise smooth and leaves its size: less
    /// scatter on smooth paths alone is no reason.
    pub(super) fn too_quiet(&self, before: f64, after: f64) -> Option<String> {
        if before < TOO_QUIET {
            return Some(format!(
                "stated noise: the recording scatters by {before:.2} of what is stated, at least {TOO_QUIET} wanted"
            ));
        }
        let limit = self.prepared.overstated.as_ref();
        limit
            .filter(|_| after < TOO_QUIET)
            .map(ToString::to_string)
            .or_else(|| self.quiet_channel().filter(|_| before < ABOVE_STATED))
    }

    /// A channel that is left with less than the stated noise, as it is where one of its readings' noise is stated too large.
    pub(super) fn quiet_channel(&self) -> Option<String> {
        quietest(&self.after, self.floor.white_square.sqrt()).map(|(channel, found)| {
            format!(
                "stated noise: {} is left with {found:.2} of what is stated, at least {TOO_QUIET} wanted",
                CHANNEL_NAMES[channel]
            )
        })
    }
}

/// The channel with least of its stated noise, where that is too little beyond chance: four standard deviations of an rms.
fn quietest(residuals: &Residuals, floor: f64) -> Option<(usize, f64)> {
    let found = |channel: usize| {
        let rows = residuals.white.iter().zip(&residuals.channel);
        let white: Vec<f64> = rows
            .filter(|(_, c)| **c == channel)
            .map(|(white, _)| *white)
            .collect();
        let chance = 4.0 / (2.0 * white.len() as f64).sqrt();
        let found = rms(white.iter().copied()) / floor;
        let quiet = white.len() >= MINIMUM_SAMPLES && found < TOO_QUIET * (1.0 - chance);
        quiet.then_some((channel, found))
    };
    let quiet = residuals.channels().into_iter().filter_map(found);
    quiet.min_by(|a, b| a.1.total_cmp(&b.1))
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
        let (channel, found) = quietest(&residuals, 1.0).expect("a channel");
        assert_eq!(channel, 1);
        assert!((found - 0.1).abs() < 0.02, "{found}");
        residuals.channel.iter_mut().for_each(|c| *c = 0);
        residuals.white.truncate(0);
        let white = residuals.channel.iter().map(|_| 0.8 * normal(&mut rng));
        residuals.white = white.collect();
        assert_eq!(quietest(&residuals, 1.0), None);
    }
}
