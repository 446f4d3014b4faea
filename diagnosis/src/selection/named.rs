//! What is named: its share, its rivals, its amounts.

use super::ModelSelection;
use crate::algebra::statistics::NORMAL_97_5;
use crate::data::channel_names::CHANNEL_NAMES;
use crate::data::one_way::is_one_way;
use crate::data::slips::Slip;
use crate::design::assembly::complexity_penalty;
use crate::inference::cross_validation::CrossValidation;
use crate::inference::posterior::{Estimate, Posterior, birge_ratio};
use crate::posterior::unlogged::{unlogged_causes, with_the_temperature};
use crate::selection::worth::unexplained_fraction;
use crate::verdict::answer::{Magnitude, Named};
use crate::verdict::rivals::Rivals;
use effects::effect::KnownBy;
use effects::{Card, Detection};

/// A runner-up whose odds are less than this share of all is not worth a mention: the 5 % at which two are usually taken to differ
/// (Fisher 1925).
const ALIAS_SHARE: f64 = 0.05;
/// Amounts that are told of each effect. A bound on the work: of a reader; the model that is written has all.
const REPORTED_AMOUNTS: usize = 12;

/// Causes that leave the same, to within this share of what they take, are not told apart by this motion, whatever the number of
/// their unknowns: the odds are at least these.
const INDISTINGUISHABLE_SHARE: f64 = 0.002;
/// See [`INDISTINGUISHABLE_SHARE`].
const INDISTINGUISHABLE_ODDS: f64 = 0.5;
/// Beside harmonics an effect takes this share of what it takes without them, or they are its own.
const OWN_SHARE_BESIDE_HARMONICS: f64 = 0.5;

/// True for what is no flexible shape, which would do in the place of anything.
fn is_cause(name: &str) -> bool {
    effects::has(name, Card::is_cause)
}

impl ModelSelection<'_> {
    /// The effects that add something to the readings. `part` is the share of the whole gap that is theirs.
    pub(super) fn structured(&self, validation: &mut CrossValidation, part: f64) -> Vec<Named> {
        let blocks = &self.selected.found.blocks;
        let all = unexplained_fraction(validation, blocks, self.selected.base);
        let candidates = self.design.effects();
        let known = Posterior::of(&self.relinearized, birge_ratio(self.held_out()));
        let mut out = Vec::new();
        for (place, &block) in blocks.iter().enumerate() {
            let others: Vec<usize> = blocks.iter().copied().filter(|b| *b != block).collect();
            let without = unexplained_fraction(validation, &others, self.selected.base);
            let name = self.design.columns.blocks[block].name.clone();
            let mut rivals = self.rivals(validation, block, &others, &candidates);
            let unlogged = unlogged_causes(self.prepared, self.options, &name);
            rivals.extend(unlogged.iter().map(|cause| ((*cause).into(), 1.0)));
            let sum: f64 = 1.0 + rivals.iter().map(|r| r.1).sum::<f64>();
            let (aliases, others): (Vec<_>, Vec<_>) = rivals
                .into_iter()
                .partition(|rival| rival.1 / sum > ALIAS_SHARE);
            let together = |rivals: &[(String, f64)]| rivals.iter().map(|rival| rival.1).sum();
            let rivals = Rivals {
                aliases: together(&aliases),
                others: together(&others),
                unlisted: 0.0,
            };
            let aliases: Vec<String> = aliases.into_iter().map(|rival| rival.0).collect();
            let total = known.as_ref().map(|known| known.total_m(1 + place));
            out.push(Named {
                magnitude: self.magnitudes(place, known.as_ref()),
                total_rms_m: total.map(|total| total.value),
                total_deviation_m: total.map(|total| total.deviation),
                break_alias: if aliases.is_empty() {
                    None
                } else if unlogged.is_empty() {
                    telling_motion(&name)
                } else {
                    telling_motion(&name).map(|motion| with_the_temperature(&motion))
                },
                aliases,
                share: ((without - all) * part).clamp(0.0, 1.0),
                gap_after_alone_m: self.alone_m(block),
                rivals,
                name,
                ..Named::default()
            });
        }
        out
    }

    /// Largest channel's held-out rms with one effect alone, m.
    fn alone_m(&self, block: usize) -> f64 {
        let only = self.selected.found.blocks == [block];
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

    /// Beside a gap of which the harmonics that it makes are told: those, as free ones, lest a rival stand in for them. Not where they
    /// would take what the effect itself takes.
    pub(super) fn with_what_a_gap_makes(
        &self,
        validation: &mut CrossValidation,
        block: usize,
        others: &[usize],
    ) -> Vec<usize> {
        let blocks = &self.design.columns.blocks;
        let mut holding = effects::holding(|by| by == KnownBy::MixedHarmonics);
        let synthetic_problem = holding.next().and_then(|(gap, holds)| {
            let selected =
                self.relinearized.linearized.inputs.gap_told && blocks[block].name != gap.name;
            let mut effects = self.design.effects().into_iter();
            effects.find(|b| selected && blocks[*b].name == holds.other)
        });
        let with = |more: Option<usize>| others.iter().copied().chain(more).collect::<Vec<_>>();
        let mut takes = |beside: Vec<usize>| {
            let both = [&beside[..], &[block]].concat();
            unexplained_fraction(validation, &beside, self.selected.base)
                - unexplained_fraction(validation, &both, self.selected.base)
        };
        if takes(with(synthetic_problem)) > OWN_SHARE_BESIDE_HARMONICS * takes(with(None)) {
            with(synthetic_problem)
        } else {
            with(None)
        }
    }

    /// Effects that would do in the place of `block`, with their odds against it.
    pub(super) fn rivals(
        &self,
        validation: &mut CrossValidation,
        block: usize,
        others: &[usize],
        candidates: &[usize],
    ) -> Vec<(String, f64)> {
        let others = &self.with_what_a_gap_makes(validation, block, others)[..];
        let mut with = others.to_vec();
        with.push(block);
        let mine = unexplained_fraction(validation, &with, self.selected.base);
        let without = unexplained_fraction(validation, others, self.selected.base);
        let evidence = validation.score(&with).log_evidence;
        let mut list = Vec::new();
        let name = |b: usize| self.design.columns.blocks[b].name.as_str();
        let own = complexity_penalty(name(block));
        for &c in candidates.iter().filter(|c| !with.contains(c)) {
            let mut set = others.to_vec();
            set.push(c);
            let theirs = unexplained_fraction(validation, &set, self.selected.base);
            // The model is never exact: what differs by less than a few percent of the effect is not told apart by fit.
            // Shapes and flexible effects give way here as they do in the search.
            let more = if self.same_by_clock(name(c), name(block)) {
                0.0
            } else {
                complexity_penalty(name(c)) - own
            };
            let complexity_penalty = more * without.max(0.0);
            let behind = (theirs + complexity_penalty - mine) / (without - mine).max(1e-9);
            let fit = (-behind.max(0.0) / 0.01).exp();
            let occam = (validation.score(&set).log_evidence - evidence)
                .clamp(-5.0, 0.0)
                .exp();
            let same = (theirs - mine).abs() < INDISTINGUISHABLE_SHARE * (without - mine);
            let odds = if same && is_cause(name(c)) && is_cause(name(block)) {
                occam.max(INDISTINGUISHABLE_ODDS)
            } else {
                fit * occam.max(fit * 0.2)
            };
            list.push((self.design.columns.blocks[c].name.clone(), odds));
        }
        list.sort_by(|a, b| b.1.total_cmp(&a.1));
        list
    }

    /// True if one of two effects keeps its own time, the other follows the temperature, and the temperature only rises or only falls: a
    /// course of its own that happens to be the temperature's is no coincidence then, and gives way to nothing.
    fn same_by_clock(&self, one: &str, other: &str) -> bool {
        let either = |a: &str, b: &str| {
            effects::has(a, Card::keeps_its_own_time) && effects::has(b, Card::follows_temperature)
        };
        (either(one, other) || either(other, one))
            && is_one_way(&self.prepared.observations.temperature_c)
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

impl ModelSelection<'_> {
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

/// The motion that tells an effect from others.
fn telling_motion(name: &str) -> Option<String> {
    effects::telling_motion(name).map(String::from)
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
