//! How far each reading's noise is above the stated one, where what is left is noise.

use super::fitted_effects::FittedEffects;
use super::variance_components::{SampleResiduals, noise_over_stated};
use crate::data::motion::MISFIT;
use crate::spectra::flicker::flicker_hz;
use crate::spectra::lines::lines_of;
use effects::sensor::READINGS;

/// The segments' own scatter is believed if its sum agrees with that of g_p within this factor.
const AGREEMENT_FACTOR: f64 = 2.0;

impl FittedEffects<'_> {
    /// True if lines stand out of what is left and none were looked for yet: a vibration near half the sample rate is as rough as
    /// noise is. They are held against what is left itself, which may be noise far above the stated one.
    pub(super) fn hums(&self) -> bool {
        let inputs = &self.design.linearized.inputs;
        let looked = !inputs.beacon_lines_hz.is_empty() || !inputs.segment_lines_hz.is_empty();
        !looked && {
            let left = self.relinearized.residuals().of_unit_rms();
            let (beacon, segments) = lines_of(&self.design.linearized, &left);
            let flicker = flicker_hz(&self.design.linearized, &left);
            [beacon, segments, flicker].iter().any(|l| !l.is_empty())
        }
    }

    /// Noise of each reading over the stated one.
    pub(super) fn noise_of_readings(&self) -> [f64; READINGS] {
        let scope = self.design.linearized.scope;
        let over = |c: usize| {
            let (rms, count) = self.after.channel_rms_m(c);
            if count > 0 {
                (rms * self.rough_part(&self.after, c) / self.floor.channel_rms_m[c].max(1e-15))
                    .max(1.0)
            } else {
                1.0
            }
        };
        let mut noise = [1.0; READINGS];
        if scope.reference {
            for s in (0..4).filter(|s| scope.segments[*s]) {
                noise[s] = over(3 + s);
            }
            return noise;
        }
        noise[..4].copy_from_slice(&self.segments(over(0)));
        if scope.beacon {
            noise[4..].copy_from_slice(&[over(1).max(over(2)); 2]);
            noise = noise_over_stated(&self.all_rows(), noise).unwrap_or(noise);
        }
        noise
    }

    /// What is left of the samples that show all three residuals, of a pattern's excess no more than what is rough.
    fn all_rows(&self) -> Vec<SampleResiduals> {
        let linearized = &self.design.linearized;
        let rough = [0, 1, 2].map(|c| self.rough_part(&self.after, c));
        let sample = &self.after.sample;
        let rows: Vec<usize> = (0..sample.len()).collect();
        let seen = rows
            .chunk_by(|a, b| sample[*a] == sample[*b])
            .filter_map(|rows| {
                let i = sample[rows[0]];
                let left = |k: &usize| rough[self.after.channel[*k]] * self.after.value_m[*k];
                let left: Vec<f64> = rows.iter().map(left).collect();
                SampleResiduals::new(&linearized.rows(i), &left, linearized.stated_variance(i))
            });
        seen.collect()
    }

    /// The four segments' share in what g_p has too much, `all` times the stated noise.
    fn segments(&self, all: f64) -> [f64; 4] {
        let linearized = &self.design.linearized;
        let stated: [f64; 4] = std::array::from_fn(|s| {
            let list = linearized.observations.position_noise_m[s].iter();
            crate::algebra::statistics::rms(list.copied().filter(|n| n.is_finite()))
        });
        let own: [f64; 4] = std::array::from_fn(|s| linearized.motion.scatter_m[s] / MISFIT);
        let wanted = all * all * stated.iter().map(|n| n * n).sum::<f64>();
        let factor = wanted / own.iter().map(|n| n * n).sum::<f64>().max(1e-30);
        if !(1.0 / AGREEMENT_FACTOR..AGREEMENT_FACTOR).contains(&factor) {
            return [all; 4];
        }
        std::array::from_fn(|s| (factor.sqrt() * own[s] / stated[s].max(1e-15)).max(1.0))
    }
}
