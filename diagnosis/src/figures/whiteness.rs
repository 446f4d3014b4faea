//! Whether what is left is white noise, which must be shown: there at rest, small beside a tooth, and other from sample to sample.

use super::fitted_effects::FittedEffects;
use crate::algebra::statistics::median_and_deviation;
use crate::inference::residuals::Residuals;

/// Neighbours on smooth paths that are needed to tell noise from a pattern, in a channel; and in
/// all to name it. Derived from the scatter of half the mean squared step over the mean square, 1/√n (von Neumann 1941): 0.06 of
/// 300 pairs and 0.13 of 60, where `WHITE_STEP_RATIO` lies 0.4 below noise's.
const ROUGH_PAIRS: usize = 300;
/// See [`ROUGH_PAIRS`].
const SHOWN_PAIRS: usize = 60;
/// Of what is there beyond the stated noise, noise is at least this share: half the mean squared step is all of its mean square
/// (von Neumann 1941), and hardly any of a pattern's.
const WHITE_STEP_RATIO: f64 = 0.6;
/// Standard deviations by which a pattern must show before noise is doubted. Derived from the normal tail: by chance once in 740
/// on one side.
const PATTERN_DEVIATIONS: f64 = 3.0;
/// Neighbours at rest that are needed to tell whether noise is there without motion. Derived from the scatter of such a ratio,
/// 1/√n: 0.1 of a hundred.
const STILL_PAIRS: usize = 100;
/// White noise at rest is at least this share of what it is elsewhere, and in slow motion of what it is in fast.
const REST_NOISE_SHARE: f64 = 0.3;
/// Parts of the path: the slowest is held against the fastest.
/// By definition: quarters.
const SPEED_CLASSES: usize = 4;
/// What scatters by more than this share of a pitch is neither noise nor an error of the sensor: the readings belong to another
/// segment, sign or tooth. The paper's parity without calibration, of four segments, is 0.03 of it (29.3 µm, 3.1.2).
const SENSOR_ERROR_PITCHES: f64 = 0.05;
/// A channel is looked at if its mean square is this far above the noise that is stated.
const LOUD_CHANNEL_RATIO: f64 = 1.2;

/// Of the excess over the stated noise the middle of the readings, told by their median deviation, shows at least this share: all
/// of it where it is noise, next to nothing where a few of them are disturbed. A derivation: the middle of both.
const BULK_NOISE_SHARE: f64 = 0.5;

/// Half the mean squared step, the mean square, and their number.
#[derive(Clone, Copy, Default)]
pub(super) struct SquaredSteps {
    pub(super) step: f64,
    pub(super) level: f64,
    pub(super) pairs: usize,
}

impl SquaredSteps {
    fn add(&mut self, a: f64, b: f64) {
        self.step += 0.5 * (a - b) * (a - b);
        self.level += 0.5 * (a * a + b * b);
        self.pairs += 1;
    }

    /// True if the excess over noise of this mean square is a pattern for a good part, beyond chance: neighbours' mean product is
    /// the pattern's square, and scatters by the mean square over the root of their number.
    fn is_pattern(&self, noise: f64) -> bool {
        let count = self.pairs.max(1) as f64;
        let (step, level) = (self.step / count, self.level / count);
        let chance = PATTERN_DEVIATIONS * level / count.sqrt();
        level - step > (1.0 - WHITE_STEP_RATIO) * (level - noise).max(0.0) + chance
    }
}

impl FittedEffects<'_> {
    /// True if what is left changes from sample to sample as white noise does, in every channel that has too much of it: where
    /// the path is smooth a pattern would not, and what is noise is there at rest and in slow motion as well.
    pub(super) fn rough(&self, residuals: &Residuals) -> bool {
        let stated = self.floor.white_square;
        let mut moving = SquaredSteps::default();
        for channel in residuals.channels() {
            let list: Vec<usize> = (0..residuals.sample.len())
                .filter(|k| residuals.channel[*k] == channel)
                .collect();
            let mean =
                crate::algebra::statistics::rms(list.iter().map(|k| residuals.white[*k])).powi(2);
            let (path, still) = self.steps(residuals, &list);
            if mean > LOUD_CHANNEL_RATIO && path.pairs > ROUGH_PAIRS && path.is_pattern(stated) {
                return false;
            }
            let at_rest = still.step / still.pairs.max(1) as f64;
            if mean > LOUD_CHANNEL_RATIO
                && still.pairs > STILL_PAIRS
                && at_rest < REST_NOISE_SHARE * mean
            {
                return false;
            }
            if mean > LOUD_CHANNEL_RATIO && grows(self.by_speed(residuals, &list), stated) {
                return false;
            }
            moving.step += path.step;
            moving.level += path.level;
            moving.pairs += path.pairs;
        }
        moving.pairs < ROUGH_PAIRS || !moving.is_pattern(stated)
    }

    /// True if most of what is left beyond the stated noise changes from sample to sample on smooth paths, all channels together.
    pub(super) fn is_rough_on_the_whole(&self, residuals: &Residuals) -> bool {
        let path = self.path_steps(residuals);
        let beyond = |sum: f64| sum - self.floor.white_square * path.pairs as f64;
        path.pairs > ROUGH_PAIRS && beyond(path.step) > WHITE_STEP_RATIO * beyond(path.level)
    }

    /// True if what is left is not only rough but shown to be noise: there are smooth paths to see it on, it is there at rest,
    /// and it is small beside a tooth. Over separate poses any pattern looks like noise.
    pub(super) fn is_noise(&self, residuals: &Residuals) -> bool {
        let pairs: usize = residuals
            .channels()
            .into_iter()
            .map(|channel| {
                let list: Vec<usize> = (0..residuals.sample.len())
                    .filter(|k| residuals.channel[*k] == channel)
                    .collect();
                self.steps(residuals, &list).0.pairs
            })
            .sum();
        pairs > SHOWN_PAIRS && self.is_small(residuals) && self.noisy_at_rest(residuals)
    }

    /// True if what is left beyond the stated noise is in the middle of the readings as well and not in their tails alone: beside
    /// bursts, the tails are those that are too small to stand out.
    pub(super) fn in_the_middle(&self, residuals: &Residuals) -> bool {
        let (mut all, mut middle) = (0.0, 0.0);
        for channel in residuals.channels() {
            let of = |k: &usize| residuals.channel[*k] == channel;
            let rows = (0..residuals.white.len()).filter(of);
            let white = rows.map(|k| residuals.white[k]).collect();
            let excess = excess(white, self.floor.white_square);
            all += excess[0];
            middle += excess[1];
        }
        middle > BULK_NOISE_SHARE * all
    }

    /// True if what is left is small beside a tooth in every channel.
    pub(super) fn is_small(&self, residuals: &Residuals) -> bool {
        let limit_m = SENSOR_ERROR_PITCHES * self.design.linearized.observations.pitch_m;
        let channels = residuals.channels();
        let mut rms_m = channels.iter().map(|c| residuals.channel_rms_m(*c).0);
        rms_m.all(|rms| rms < limit_m)
    }

    /// Against a reference, samples at rest are left out of the comparison: noise would be in them as well.
    fn noisy_at_rest(&self, residuals: &Residuals) -> bool {
        let linearized = &self.relinearized.linearized;
        if self.prepared.resting.iter().filter(|r| **r).count() < STILL_PAIRS {
            return true;
        }
        let list: Vec<usize> = (0..self.relinearized.coefficients.len()).collect();
        let amounts = |_: usize| &self.relinearized.coefficients;
        let (columns, gram) = (&self.relinearized.columns, &self.relinearized.gram);
        let mut all = Residuals::predicted(linearized, columns, gram, &list, amounts, true);
        if self.noise.is_some() {
            all = self.by_stated_noise(&all);
        }
        residuals.channels().into_iter().all(|channel| {
            let rows: Vec<usize> = (0..all.sample.len())
                .filter(|k| all.channel[*k] == channel && self.prepared.resting[all.sample[*k]])
                .collect();
            let mut still = SquaredSteps::default();
            for pair in rows.windows(2) {
                if all.sample[pair[1]] == all.sample[pair[0]] + 1 {
                    still.add(all.white[pair[0]], all.white[pair[1]]);
                }
            }
            let white = (0..residuals.white.len()).filter(|k| residuals.channel[*k] == channel);
            let mean = crate::algebra::statistics::rms(white.map(|k| residuals.white[k])).powi(2);
            let at_rest = still.step / still.pairs.max(1) as f64;
            mean < LOUD_CHANNEL_RATIO
                || still.pairs < STILL_PAIRS
                || at_rest > REST_NOISE_SHARE * mean
        })
    }

    /// Steps between neighbours on smooth paths, of all channels.
    pub(super) fn path_steps(&self, residuals: &Residuals) -> SquaredSteps {
        let mut all = SquaredSteps::default();
        for channel in residuals.channels() {
            let of = |k: &usize| residuals.channel[*k] == channel;
            let list: Vec<usize> = (0..residuals.sample.len()).filter(of).collect();
            let (path, _) = self.steps(residuals, &list);
            all.step += path.step;
            all.level += path.level;
            all.pairs += path.pairs;
        }
        all
    }

    /// Steps between neighbours on smooth paths, and those of them at rest.
    fn steps(&self, residuals: &Residuals, list: &[usize]) -> (SquaredSteps, SquaredSteps) {
        let (mut path, mut still) = (SquaredSteps::default(), SquaredSteps::default());
        for (speed_m_s, a, b) in self.neighbours(residuals, list) {
            path.add(a, b);
            if speed_m_s == 0.0 {
                still.add(a, b);
            }
        }
        (path, still)
    }

    /// Neighbours on smooth paths: their speed, and what is left of both.
    fn neighbours(&self, residuals: &Residuals, list: &[usize]) -> Vec<(f64, f64, f64)> {
        let linearized = &self.design.linearized;
        let motion = &linearized.motion;
        let stretch = &linearized.observations.stretch;
        let speed_m_s = |i: usize| {
            let each = motion.speed_m_s.iter().filter_map(|v| v.get(i));
            each.map(|v| v * v).sum::<f64>().sqrt()
        };
        list.windows(2)
            .filter_map(|pair| {
                let (i, j) = (residuals.sample[pair[0]], residuals.sample[pair[1]]);
                let near = j == i + 1 && stretch[i] == stretch[j];
                let both = [pair[0], pair[1]].map(|k| residuals.white[k]);
                (near && motion.smooth[i] && motion.smooth[j])
                    .then(|| (speed_m_s(i), both[0], both[1]))
            })
            .collect()
    }

    /// Steps between neighbours in the slowest and in the fastest part of the path.
    fn by_speed(&self, residuals: &Residuals, list: &[usize]) -> [SquaredSteps; 2] {
        let mut pairs = self.neighbours(residuals, list);
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        let part = pairs.len() / SPEED_CLASSES;
        [&pairs[..part], &pairs[pairs.len() - part..]].map(|pairs| {
            let mut steps = SquaredSteps::default();
            pairs.iter().for_each(|(_, a, b)| steps.add(*a, *b));
            steps
        })
    }

    /// Of a channel's rms what changes from sample to sample on smooth paths as noise does; all of it where there are hardly any.
    pub(super) fn rough_part(&self, residuals: &Residuals, channel: usize) -> f64 {
        let of = |k: &usize| residuals.channel[*k] == channel;
        let list: Vec<usize> = (0..residuals.sample.len()).filter(of).collect();
        let (path, _) = self.steps(residuals, &list);
        if path.pairs > ROUGH_PAIRS {
            (path.step / path.level.max(1e-30)).min(1.0).sqrt()
        } else {
            1.0
        }
    }
}

/// True if of what is rough beyond the stated mean square hardly any is there in slow motion, beyond chance: half a squared step of
/// noise scatters by 1.7 of its mean, neighbours' overlap counted.
fn grows([slow, fast]: [SquaredSteps; 2], stated: f64) -> bool {
    let mean = |s: &SquaredSteps| s.step / s.pairs.max(1) as f64;
    let chance =
        |s: &SquaredSteps| PATTERN_DEVIATIONS * (3.0 / s.pairs.max(1) as f64).sqrt() * mean(s);
    let enough = slow.pairs.min(fast.pairs) > STILL_PAIRS;
    enough
        && mean(&slow) - stated + chance(&slow)
            < REST_NOISE_SHARE * (mean(&fast) - stated - chance(&fast))
}

/// Squares beyond a stated mean square: of all values, and as their median deviation tells it.
fn excess(mut values: Vec<f64>, stated: f64) -> [f64; 2] {
    let count = values.len() as f64;
    let mean = crate::algebra::statistics::rms(values.iter().copied()).powi(2);
    let middle = median_and_deviation(&mut values).map_or(0.0, |(_, d)| d * d);
    [mean, middle].map(|square| count * (square - stated).max(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use effects::random::{ChaCha8Rng, SeedableRng, normal};

    /// Neighbours of the stated noise with something on top.
    fn steps(on_top: impl Fn(usize, &mut ChaCha8Rng) -> f64) -> SquaredSteps {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let value: Vec<f64> = (0..8000)
            .map(|i| normal(&mut rng) + on_top(i, &mut rng))
            .collect();
        let mut steps = SquaredSteps::default();
        value.windows(2).for_each(|v| steps.add(v[0], v[1]));
        steps
    }

    /// Most of what is seen is the stated noise either way: only what is beyond it tells.
    #[test]
    fn a_faint_pattern_under_the_stated_noise_is_no_noise() {
        let pattern = steps(|i, _| 0.9 * (0.02 * i as f64).sin());
        assert!(pattern.step > WHITE_STEP_RATIO * pattern.level && pattern.is_pattern(1.0));
        let noise = steps(|_, rng| 0.65 * normal(rng));
        assert!(!noise.is_pattern(1.0));
    }

    #[test]
    fn what_is_rough_in_fast_motion_alone_is_no_noise() {
        let slow = |more: f64| steps(|_, rng| more * normal(rng));
        assert!(grows([slow(0.1), slow(1.0)], 1.0));
        assert!(!grows([slow(0.9), slow(1.0)], 1.0) && !grows([slow(0.0), slow(0.1)], 1.0));
    }

    /// Noise is louder in every reading, small bursts in a few: both raise the mean square, noise alone the median deviation.
    #[test]
    fn small_bursts_are_not_in_the_middle_of_the_readings() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let mut share = |loudness: f64, bursts: f64| {
            let value = |i: usize| match i % 40 {
                0 => bursts * normal(&mut rng),
                _ => loudness * normal(&mut rng),
            };
            let [all, middle] = excess((0..20_000).map(value).collect(), 1.0);
            middle / all
        };
        assert!(share(1.2, 1.2) > 0.8 && share(1.2, 1.2) < 1.2);
        assert!(share(1.0, 5.0) < 0.2);
        assert!(share(1.3, 4.0) > BULK_NOISE_SHARE);
    }
}
