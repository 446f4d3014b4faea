//! Short disturbances, marked before anything is fitted.

use crate::algebra::statistics::{median, median_and_deviation, rms};
use crate::data::observations::Observations;
use effects::sensor::CHANNELS;
use std::collections::HashMap;

/// Samples in a piece over which a disturbance must stand out. Derived from the median deviation, which is then known to 15 %
/// (1.17 over the root of their number) as long as less than half of them are disturbed.
const PIECE_SAMPLES: usize = 60;
/// By this many robust deviations. Derived from that and the normal tail: where the deviation is found two such errors too small,
/// 7 of it are 4.9, by chance one value in a million.
const OUTLIER_DEVIATIONS: f64 = 7.0;

/// What is next to such a sample belongs to it by this many. Derived from the same tail: by chance one neighbour in 2,000, or in
/// 70 where the deviation is found too small.
const BESIDE: f64 = 3.5;

/// Fewer tell no usual scatter. Derived from the median deviation, which is then known to 26 %.
const FEWEST_NEIGHBOURS: usize = 20;

/// Pairs, whose amplitudes are told behind the residual channels. By definition one for each of the four segments.
const PAIRS: usize = 4;

/// Which samples are told apart from each other: those of a stretch, and the poses of a run that is one by one at rest. What a model
/// leaves of those scatters alike; what a gap leaves need not.
fn with_single_poses(stretch: &[usize], run: &[usize]) -> Vec<usize> {
    let mut samples = vec![0; stretch.iter().max().map_or(0, |last| last + 1)];
    stretch.iter().for_each(|s| samples[*s] += 1);
    let of = |(s, r): (&usize, &usize)| {
        if samples[*s] < FEWEST_NEIGHBOURS {
            samples.len() + r
        } else {
            *s
        }
    };
    stretch.iter().zip(run).map(of).collect()
}

/// Part of a tooth that no error of a sensor reaches. A derivation: an eighth of the paper's pitch is 127 µm, more than four
/// times what all errors of four segments come to together (29.3 µm of parity, paper 3.1.2).
const ASTRAY: f64 = 0.125;

/// Marks poses one by one at rest that are off by a good part of a tooth, as a count that is wrong for a moment leaves them: whatever a gap
/// leaves of the others, it is less. `rows` as in [`disturbed`].
pub fn astray(rows: &[(usize, usize, f64)], o: &Observations) -> Vec<bool> {
    let noise = o.position_noise_m.iter().flatten().copied();
    let noise_m = rms(noise.filter(|n| n.is_finite())).max(f64::MIN_POSITIVE);
    far_among_single_poses(rows, &o.stretch, &o.run, ASTRAY * o.pitch_m / noise_m)
}

fn far_among_single_poses(
    rows: &[(usize, usize, f64)],
    stretch: &[usize],
    run: &[usize],
    limit: f64,
) -> Vec<bool> {
    let groups = with_single_poses(stretch, run);
    let single = |i: usize| groups[i] != stretch[i];
    let mut values: HashMap<(usize, usize), Vec<f64>> = HashMap::new();
    for (i, channel, white) in rows.iter().filter(|r| single(r.0)) {
        values
            .entry((groups[*i], *channel))
            .or_default()
            .push(*white);
    }
    let centres: HashMap<(usize, usize), f64> = values
        .into_iter()
        .filter_map(|(group, mut list)| Some((group, median(&mut list)?)))
        .collect();
    let mut marked = vec![false; stretch.len()];
    for (i, channel, white) in rows.iter().filter(|r| single(r.0)) {
        let centre = centres.get(&(groups[*i], *channel)).copied().unwrap_or(0.0);
        marked[*i] |= (white - centre).abs() > limit;
    }
    marked
}

/// Marks samples that stand out of their neighbourhood. `rows` are (sample, channel, whitened residual) in time order; behind the residual channels
/// may come the amplitudes of the four pairs ([`crate::linearization::recording::LinearizedRecording::amplitude_rows`]).
pub fn disturbed(rows: &[(usize, usize, f64)], samples: usize, stretch: &[usize]) -> Vec<bool> {
    marked(rows, samples, stretch, &HashMap::new())
}

/// The same among bursts, of what a model leaves: single poses among those of their run, and a burst that fills a neighbourhood by what the
/// rest of its stretch leaves.
pub fn among_bursts(rows: &[(usize, usize, f64)], stretch: &[usize], run: &[usize]) -> Vec<bool> {
    let groups = with_single_poses(stretch, run);
    let mut values: HashMap<(usize, usize), Vec<f64>> = HashMap::new();
    for (i, channel, white) in rows {
        values
            .entry((groups[*i], *channel))
            .or_default()
            .push(*white);
    }
    let usual = values
        .into_iter()
        .filter_map(|(group, mut list)| Some((group, ALIKE * median_and_deviation(&mut list)?.1)));
    marked(rows, stretch.len(), &groups, &usual.collect())
}

/// What a neighbourhood scatters by, over all of its stretch, where it scatters alike. A derivation: of 60 values the deviation
/// is known to 15 %, so that twice the stretch's is beyond chance by six errors.
const ALIKE: f64 = 2.0;

/// `most` bounds the usual scatter of a stretch and channel.
fn marked(
    rows: &[(usize, usize, f64)],
    samples: usize,
    stretch: &[usize],
    most: &HashMap<(usize, usize), f64>,
) -> Vec<bool> {
    let mut marked = vec![false; samples];
    for channel in 0..CHANNELS + PAIRS {
        let list: Vec<(usize, f64)> = rows
            .iter()
            .filter(|r| r.1 == channel)
            .map(|r| (r.0, r.2))
            .collect();
        let mut start = 0;
        while start < list.len() {
            let mut end = start;
            while end < list.len()
                && end - start < PIECE_SAMPLES
                && stretch[list[end].0] == stretch[list[start].0]
            {
                end += 1;
            }
            // What is left of a stretch is held against what is before it as well.
            let of_it = |k: &usize| stretch[list[*k].0] == stretch[list[start].0];
            let back = (end.saturating_sub(PIECE_SAMPLES)..start)
                .rev()
                .take_while(of_it);
            let from = start
                - if end - start < PIECE_SAMPLES {
                    back.count()
                } else {
                    0
                };
            let mut values: Vec<f64> = list[from..end].iter().map(|r| r.1).collect();
            if let Some((centre, deviation)) =
                median_and_deviation(&mut values).filter(|_| end - from >= FEWEST_NEIGHBOURS)
            {
                let most = most.get(&(stretch[list[start].0], channel));
                let limit =
                    OUTLIER_DEVIATIONS * deviation.min(*most.unwrap_or(&f64::INFINITY)).max(1.0);
                let far = |k: &usize, limit: f64| (list[*k].1 - centre).abs() > limit;
                let near = limit * BESIDE / OUTLIER_DEVIATIONS;
                for k in (start..end).filter(|k| far(k, limit)) {
                    let back = (start..=k).rev().take_while(|k| far(k, near));
                    let on = (k..end).take_while(|k| far(k, near));
                    back.chain(on).for_each(|k| marked[list[k].0] = true);
                }
            }
            start = end;
        }
    }
    marked
}

#[cfg(test)]
mod tests {
    use super::*;

    fn in_one_channel(samples: usize, value: impl Fn(usize) -> f64) -> Vec<(usize, usize, f64)> {
        (0..samples).map(|i| (i, 0, value(i))).collect()
    }

    fn with_one_burst(samples: usize, at: usize) -> Vec<(usize, usize, f64)> {
        let usual = |i: usize| (1.7 * i as f64).sin() * 1.4;
        let value = |i: usize| if i == at { 12.0 } else { usual(i) };
        (0..samples).map(|i| (i, 0, value(i))).collect()
    }

    #[test]
    fn poses_one_by_one_are_held_against_each_other() {
        let rows = with_one_burst(90, 40);
        let stretch: Vec<usize> = (0..90).collect();
        let count = |marked: &[bool]| marked.iter().filter(|m| **m).count();
        assert_eq!(count(&disturbed(&rows, 90, &stretch)), 0);
        assert_eq!(count(&among_bursts(&rows, &stretch, &[3; 90])), 1);
        let one = with_single_poses(&[0; 90], &[3; 90]);
        assert_eq!(one, [0; 90]);
    }

    /// A pose off by thousands of deviations is no gap; one that is off by hundreds may be, and a moving one has neighbours to tell.
    #[test]
    fn a_single_pose_far_astray_is_marked_whatever_the_others_leave() {
        let value = |i: usize| match i {
            7 | 95 => 5000.0,
            8 => 300.0,
            _ => 40.0 * (1.7 * i as f64).sin(),
        };
        let rows = in_one_channel(130, value);
        let stretch: Vec<usize> = (0..130).map(|i| i.min(90)).collect();
        let marked = far_among_single_poses(&rows, &stretch, &[0; 130], 1000.0);
        assert_eq!((0..130).filter(|i| marked[*i]).collect::<Vec<_>>(), [7]);
    }

    /// What disturbs a pair shows in its amplitude, be the phase as it may.
    #[test]
    fn a_sample_whose_amplitude_stands_out_is_marked() {
        let mut rows = in_one_channel(120, |i| (1.7 * i as f64).sin() * 1.4);
        let of_pair = with_one_burst(120, 70);
        rows.extend(of_pair.into_iter().map(|r| (r.0, CHANNELS + 3, r.2)));
        let marked = disturbed(&rows, 120, &[0; 120]);
        assert_eq!((0..120).filter(|i| marked[*i]).collect::<Vec<_>>(), [70]);
    }

    #[test]
    fn the_last_samples_of_a_stretch_are_looked_at_too() {
        let rows = with_one_burst(130, 125);
        let marked = disturbed(&rows, 130, &[0; 130]);
        assert_eq!((0..130).filter(|i| marked[*i]).collect::<Vec<_>>(), [125]);
    }

    /// A burst may be longer than half of what is left of a stretch.
    #[test]
    fn a_burst_in_the_last_samples_is_no_usual_scatter_there() {
        let value = |i: usize| {
            let burst = (124..135).contains(&i);
            (1.7 * i as f64).sin() * if burst { 40.0 } else { 1.4 }
        };
        let rows = in_one_channel(140, value);
        let marked = disturbed(&rows, 140, &[0; 140]);
        assert!((124..135).filter(|i| marked[*i]).count() > 8);
        assert!((0..124).chain(135..140).all(|i| !marked[i]));
    }

    /// A burst may fill most of sixty samples. In what a model leaves the rest of the stretch tells what is usual.
    #[test]
    fn a_burst_that_fills_its_neighbourhood_stands_out_of_its_stretch() {
        let value = |i: usize| {
            let burst = (65..110).contains(&i);
            (1.7 * i as f64).sin() * if burst { 60.0 } else { 1.4 }
        };
        let rows = in_one_channel(240, value);
        let of_it = |marked: &[bool]| (65..110).filter(|i| marked[*i]).count();
        assert_eq!(of_it(&disturbed(&rows, 240, &[0; 240])), 0);
        let marked = among_bursts(&rows, &[0; 240], &[0; 240]);
        assert!(of_it(&marked) > 35);
        assert!((0..65).chain(110..240).all(|i| !marked[i]));
    }

    #[test]
    fn the_tail_of_a_disturbance_is_marked_with_it() {
        let value = |i: usize| match i {
            100 => 20.0,
            101 => 7.0,
            50 => 7.0,
            _ => (1.7 * i as f64).sin() * 1.4,
        };
        let rows = in_one_channel(200, value);
        let marked = disturbed(&rows, 200, &[0; 200]);
        let list: Vec<usize> = (0..200).filter(|&i| marked[i]).collect();
        assert_eq!(list, [100, 101]);
    }
}
