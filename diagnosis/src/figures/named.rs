//! What is named: its share and its amounts.

use super::fitted_effects::FittedEffects;
use crate::algebra::statistics::NORMAL_97_5;
use crate::data::channel_names::CHANNEL_NAMES;
use crate::data::slips::Slip;
use crate::figures::gap::unexplained_fraction;
use crate::inference::cross_validation::CrossValidation;
use crate::inference::posterior::{Estimate, Posterior, birge_ratio};
use crate::verdict::answer::{Magnitude, Named};
use effects::Detection;

/// Amounts that are told of each effect. A bound on the work: of a reader; the model that is written has all.
const REPORTED_AMOUNTS: usize = 12;

impl FittedEffects<'_> {
    /// The effects that add something to the readings. `part` is the share of the whole gap that is theirs.
    pub(super) fn structured(&self, validation: &mut CrossValidation, part: f64) -> Vec<Named> {
        let blocks = &self.blocks;
        let all = unexplained_fraction(validation, blocks, self.base);
        let known = Posterior::of(&self.relinearized, birge_ratio(self.held_out()));
        let mut out = Vec::new();
        for (place, &block) in blocks.iter().enumerate() {
            let others: Vec<usize> = blocks.iter().copied().filter(|b| *b != block).collect();
            let without = unexplained_fraction(validation, &others, self.base);
            let name = self.design.columns.blocks[block].name.clone();
            let total = known.as_ref().map(|known| known.total_m(1 + place));
            out.push(Named {
                magnitude: self.magnitudes(place, known.as_ref()),
                total_rms_m: total.map(|total| total.value),
                total_deviation_m: total.map(|total| total.deviation),
                share: ((without - all) * part).clamp(0.0, 1.0),
                gap_after_alone_m: self.alone_m(block),
                name,
                ..Named::default()
            });
        }
        out
    }

    /// Largest channel's held-out rms with one effect alone, m.
    fn alone_m(&self, block: usize) -> f64 {
        let only = self.blocks == [block];
        let alone = if only {
            self.after.clone()
        } else {
            self.design.residuals(&[block])
        };
        alone
            .channels()
            .iter()
            .map(|c| alone.channel_rms_m(*c).0)
            .fold(0.0, f64::max)
    }

    /// The largest amounts of the effect at a place of the answer, with their units: what is added to the readings.
    fn magnitudes(&self, place: usize, known: Option<&Posterior>) -> Vec<Magnitude> {
        let relinearized = &self.relinearized;
        let mut out: Vec<(f64, usize)> = relinearized.columns.blocks[1 + place]
            .columns
            .clone()
            .map(|c| {
                let regressor = &relinearized.columns.regressors[c];
                let size =
                    relinearized.coefficients[c] * relinearized.gram.shrunk[c] * regressor.size_m;
                (size.abs(), c)
            })
            .collect();
        out.sort_by(|a, b| b.0.total_cmp(&a.0));
        let selected = |(_, c): (f64, usize)| Magnitude {
            name: relinearized.columns.regressors[c].name.clone(),
            value: relinearized.coefficient(c),
            deviation: known.map(|known| known.deviation(c)),
            unit: relinearized.columns.regressors[c].unit.into(),
        };
        out.into_iter()
            .take(REPORTED_AMOUNTS)
            .map(selected)
            .collect()
    }

    /// White noise above the stated level.
    pub(super) fn noise(&self, share: f64) -> Named {
        let channels = self.after.channels();
        let beyond = channels.iter().map(|c| (*c, self.beyond_the_floor(*c)));
        let beyond: Vec<(usize, Estimate)> = beyond.collect();
        let magnitude = beyond.iter().map(|(c, known)| Magnitude {
            name: format!("beyond the stated noise, {}", CHANNEL_NAMES[*c]),
            value: known.value,
            deviation: Some(known.deviation),
            unit: "m".into(),
        });
        let rows = |c: usize| self.after.channel_rms_m(c).1 as f64;
        let total = pooled(beyond.iter().map(|(c, known)| (rows(*c), *known)));
        Named {
            name: effects::name_of(Detection::AsNoise).into(),
            magnitude: magnitude.collect(),
            total_rms_m: Some(total.value),
            total_deviation_m: Some(total.deviation),
            share,
            ..Named::default()
        }
    }
}

impl FittedEffects<'_> {
    /// What is left of a channel beyond the simulator's own scatter, m rms.
    fn beyond_the_floor(&self, channel: usize) -> Estimate {
        let rms_m = self.after.channel_rms_m(channel).0;
        let floor_m = self.floor.channel_rms_m[channel];
        let value = (rms_m * rms_m - floor_m * floor_m).max(0.0).sqrt();
        let [low, high] = self.after.interval_m(channel);
        let deviation = 0.5 * (high - low) / NORMAL_97_5;
        Estimate {
            value,
            // Where hardly anything is beyond, it is known to no better than its square is.
            deviation: (deviation * rms_m / value.max(f64::MIN_POSITIVE))
                .min((rms_m * deviation).sqrt()),
        }
    }
}

/// Rms over several groups of so many values each, with what each is known to.
fn pooled(groups: impl Iterator<Item = (f64, Estimate)>) -> Estimate {
    let (mut count, mut square, mut variance) = (0.0, 0.0, 0.0);
    for (rows, known) in groups {
        count += rows;
        square += rows * known.value * known.value;
        variance += (rows * known.value * known.deviation).powi(2);
    }
    let value = (square / f64::max(count, 1.0)).sqrt();
    let deviation = if value > 0.0 {
        variance.sqrt() / (count * value)
    } else {
        0.0
    };
    Estimate { value, deviation }
}

/// Whole teeth that a counter lost or won, of a recording of so many samples.
pub(super) fn slips_named(all: &[Slip], samples: usize, pitch_m: f64) -> Named {
    let magnitude = all
        .iter()
        .map(|s| Magnitude {
            name: format!("segment {} from sample {}", s.segment + 1, s.sample),
            value: f64::from(s.teeth),
            deviation: Some(0.0),
            unit: "teeth".into(),
        })
        .collect();
    Named {
        name: effects::name_of(Detection::AsSlips).into(),
        magnitude,
        total_rms_m: Some(pitch_m * teeth_off_rms(all, samples)),
        // Teeth are whole.
        total_deviation_m: Some(0.0),
        share: 1.0,
        ..Named::default()
    }
}

/// Teeth that the segments which slipped are off by, rms about each one's mean.
fn teeth_off_rms(all: &[Slip], samples: usize) -> f64 {
    let count = samples.max(1) as f64;
    let variance = |segment: usize| {
        let slips = || all.iter().filter(|slip| slip.segment == segment);
        let after = |slip: &Slip| samples.saturating_sub(slip.sample) as f64 / count;
        let mean: f64 = slips()
            .map(|slip| f64::from(slip.teeth) * after(slip))
            .sum();
        // Two steps overlap from the later one on.
        let pairs = slips().flat_map(|one| slips().map(move |other| (one, other)));
        let square: f64 = pairs
            .map(|(one, other)| {
                let both = f64::from(one.teeth) * f64::from(other.teeth);
                both * after(one).min(after(other))
            })
            .sum();
        square - mean * mean
    };
    let slipped: Vec<usize> = (0..4)
        .filter(|s| all.iter().any(|slip| slip.segment == *s))
        .collect();
    let sum: f64 = slipped.iter().map(|s| variance(*s)).sum();
    (sum / slipped.len().max(1) as f64).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slips_add_up_from_each_on() {
        let slip = |segment, teeth, sample| Slip {
            segment,
            teeth,
            sample,
            sure: true,
        };
        let list = [slip(0, 1, 50), slip(0, -1, 75), slip(2, 2, 50)];
        let off = |segment: usize, i: usize| {
            let slips = list
                .iter()
                .filter(|s| s.segment == segment && s.sample <= i);
            slips.map(|s| f64::from(s.teeth)).sum::<f64>()
        };
        let variance = |segment: usize| {
            let values: Vec<f64> = (0..100).map(|i| off(segment, i)).collect();
            crate::algebra::statistics::deviation(&values).powi(2)
        };
        let wanted = (0.5 * (variance(0) + variance(2))).sqrt();
        assert!((teeth_off_rms(&list, 100) - wanted).abs() < 1e-12);
    }

    #[test]
    fn groups_are_pooled_by_their_rows() {
        let known = |value, deviation| Estimate { value, deviation };
        let all = pooled([(30.0, known(1.0, 0.1)), (10.0, known(3.0, 0.2))].into_iter());
        assert!((all.value - 3.0_f64.sqrt()).abs() < 1e-12);
        let wanted = (3.0_f64.powi(2) + 6.0_f64.powi(2)).sqrt() / (40.0 * 3.0_f64.sqrt());
        assert!((all.deviation - wanted).abs() < 1e-12);
    }
}
