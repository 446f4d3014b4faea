//! Noise above the stated one: whether it is what is left. How much there is of it, and whose, is in `noise_level.rs`.

use super::fitted_effects::FittedEffects;
use crate::figures::limits::NOISY_RATIO;
use effects::sensor::READINGS;

impl FittedEffects<'_> {
    /// Noise of each reading over the stated one, where it was not known and is what is left.
    pub(super) fn noise_left(&self) -> Option<[f64; READINGS]> {
        let is_noise = self.noise.is_none()
            && self.ratio() >= NOISY_RATIO
            && self.rough(&self.after)
            && self.is_noise(&self.after)
            && !self.hums();
        is_noise.then(|| {
            let noise = self.noise_of_readings();
            crate::trace::log(&format!("noise over the stated one: {noise:.2?}"));
            noise
        })
    }
}
