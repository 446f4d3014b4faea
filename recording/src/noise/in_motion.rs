//! Noise of a log, measured from the log itself: what differs from one sample to the next beyond a smooth motion.
//!
//! The third difference `d = x[3] - 3 x[2] + 3 x[1] - x[0]` of four samples in a row is zero for a place that changes evenly or with an
//! even acceleration; of white noise its rms is sqrt(1 + 9 + 9 + 1) = sqrt(20) times the noise's. Only the slowest part of the log
//! is used, since a quick motion bends more than that. Noise that a filter made smooth is smaller from sample to sample
//! than it is as a whole.

/// The rms of a third difference of white noise over that of the noise: the root of 1 + 9 + 9 + 1.
const GAIN: f64 = 4.472_135_954_999_58;
/// Median of the absolute value of a Gaussian over its standard deviation.
const MEDIAN: f64 = 0.674_489_750_196_081_7;
/// Differences beyond so many standard deviations are disturbances, not noise: one in 16,000 of a Gaussian is, which takes 0.05 % of
/// its rms.
const CLIP: f64 = 4.0;
/// The slowest share of the log that is used. Of a motion to and fro like a sine, the slowest quarter is that within 22.5° of a turning
/// point in phase: its fastest is sin(22.5°) = 0.38 of the highest speed, and the phase's bend, which grows with the cube of the speed, 6 %.
const SLOWEST_SHARE: f64 = 0.25;
/// Fewer differences than these tell the rms to no better than a fifth (1 / sqrt(2 n), three of four overlapping).
const ENOUGH: usize = 30;
/// Where the slower half of what is used shows this much less than the quicker half, motion is among the noise: by chance the halves of
/// some hundred differences differ by a tenth.
const ALIKE: f64 = 1.25;

/// What was measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scatter {
    /// Noise, rms, in the values' unit.
    pub rms: f64,
    /// Differences that it comes from.
    pub differences: usize,
    /// True where the motion is too quick between samples to be told apart: the noise is at most this.
    pub holds_motion: bool,
}

/// Noise of channels that were sampled together: `channels[k][i]`, NaN where not measured. `place` is what tells how quick the
/// motion is (pitches, or any other unit); `follows[i]` is true where sample `i` came one interval after the one before.
#[must_use]
pub fn scatter(channels: &[&[f64]], place: &[f64], follows: &[bool]) -> Option<Scatter> {
    let mut windows: Vec<(f64, Vec<f64>)> = Vec::new();
    for last in 3..place.len() {
        if !follows[last - 2..=last].iter().all(|follows| *follows) {
            continue;
        }
        let pace = slope(&place[last - 3..=last]).abs();
        let third = |x: &&[f64]| x[last] - 3.0 * x[last - 1] + 3.0 * x[last - 2] - x[last - 3];
        let differences: Vec<f64> = channels.iter().map(third).collect();
        if pace.is_finite() && differences.iter().all(|d| d.is_finite()) {
            windows.push((pace, differences));
        }
    }
    if windows.len() < ENOUGH {
        return None;
    }
    windows.sort_by(|a, b| a.0.total_cmp(&b.0));
    let used = ((SLOWEST_SHARE * windows.len() as f64) as usize).max(ENOUGH);
    let of = |windows: &[(f64, Vec<f64>)]| {
        clipped_rms(windows.iter().flat_map(|(_, d)| d.iter().copied())) / GAIN
    };
    let (slower, quicker) = (of(&windows[..used / 2]), of(&windows[used / 2..used]));
    let holds_motion = quicker > ALIKE * slower;
    Some(Scatter {
        rms: if holds_motion {
            slower
        } else {
            of(&windows[..used])
        },
        differences: used * channels.len(),
        holds_motion,
    })
}

/// Slope of a straight line fitted to four values, a step. The line's weights -3, -1, 1, 3 are orthogonal to the third
/// difference's -1, 3, -3, 1: which windows count as slow does not depend on the noise that is measured in them.
fn slope(values: &[f64]) -> f64 {
    (3.0 * (values[3] - values[0]) + values[2] - values[1]) / 10.0
}

/// Root mean square without disturbances.
fn clipped_rms(values: impl Iterator<Item = f64>) -> f64 {
    let mut sizes: Vec<f64> = values.map(f64::abs).collect();
    if sizes.is_empty() {
        return 0.0;
    }
    let middle = sizes.len() / 2;
    let median = *sizes.select_nth_unstable_by(middle, f64::total_cmp).1;
    // Of values that mostly stand still the median is zero: then nothing is a disturbance.
    let limit = if median > 0.0 {
        CLIP * median / MEDIAN
    } else {
        f64::INFINITY
    };
    let kept: Vec<f64> = sizes.into_iter().filter(|size| *size <= limit).collect();
    (kept.iter().map(|size| size * size).sum::<f64>() / kept.len().max(1) as f64).sqrt()
}

/// The step in which values were written, where they have few enough digits to show one: their smallest difference.
#[must_use]
pub fn step(values: &[f64]) -> Option<f64> {
    let mut sorted: Vec<f64> = values
        .iter()
        .copied()
        .filter(|value| value.is_finite())
        .collect();
    sorted.sort_by(f64::total_cmp);
    let differences = sorted
        .windows(2)
        .map(|pair| pair[1] - pair[0])
        .filter(|d| *d > 0.0);
    let smallest = differences.fold(f64::INFINITY, f64::min);
    smallest.is_finite().then_some(smallest)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Even noise of unit rms: a linear congruence's upper bits.
    fn noise(count: usize) -> Vec<f64> {
        let mut state = 7_u64;
        (0..count)
            .map(|_| {
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                ((state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5) * 12.0_f64.sqrt()
            })
            .collect()
    }

    #[test]
    fn noise_of_a_motion_with_rests() {
        // At rest, then at 60 units a sample with an acceleration.
        let place: Vec<f64> = (0..20_000)
            .map(|k| {
                if k < 8000 {
                    0.0
                } else {
                    1.0e-3 * f64::from(k - 8000).powi(2)
                }
            })
            .collect();
        let values: Vec<f64> = place
            .iter()
            .zip(noise(20_000))
            .map(|(place, noise)| (place / 50.0).sin() * 1000.0 + 3.0 * noise)
            .collect();
        let found = scatter(&[&values], &place, &vec![true; 20_000]).unwrap();
        assert!((found.rms / 3.0 - 1.0).abs() < 0.03, "{found:?}");
        assert!(!found.holds_motion);
    }

    /// The pace is told by the very values that hold the noise.
    #[test]
    fn noise_at_rest_is_not_made_smaller_by_the_choice_of_slow_windows() {
        let values = noise(20_000);
        let found = scatter(&[&values], &values, &vec![true; 20_000]).unwrap();
        assert!(
            (found.rms - 1.0).abs() < 0.03 && !found.holds_motion,
            "{found:?}"
        );
    }

    #[test]
    fn a_motion_that_is_too_quick_is_told() {
        let place: Vec<f64> = (0..20_000)
            .map(|k| 0.5 * f64::from(k) + 1.0e-4 * f64::from(k).powi(2))
            .collect();
        let values: Vec<f64> = place
            .iter()
            .zip(noise(20_000))
            .map(|(place, noise)| place.sin() * 1000.0 + 3.0 * noise)
            .collect();
        assert!(
            scatter(&[&values], &place, &vec![true; 20_000])
                .unwrap()
                .holds_motion
        );
        assert_eq!(scatter(&[&values[..20]], &place[..20], &[true; 20]), None);
    }

    /// One value in a hundred is far off: it takes part in four differences, which do not count.
    #[test]
    fn disturbances_do_not_count() {
        let mut values = noise(20_000);
        values.iter_mut().step_by(97).for_each(|v| *v += 50.0);
        let found = scatter(&[&values], &[0.0; 20_000], &[true; 20_000]).unwrap();
        assert!(
            (found.rms - 1.0).abs() < 0.03 && !found.holds_motion,
            "{found:?}"
        );
    }

    #[test]
    fn the_step_of_written_values() {
        assert!((step(&[0.5, 0.25, 0.75, 0.25, f64::NAN]).unwrap() - 0.25).abs() < 1e-12);
        assert_eq!(step(&[1.0, 1.0]), None);
    }
}
