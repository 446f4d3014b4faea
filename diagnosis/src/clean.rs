//! Short disturbances, marked before anything is fitted.

use crate::statistics::median_and_deviation;

/// Samples in a piece over which a disturbance must stand out.
const PIECE: usize = 60;
/// By this many robust deviations.
const OUTSIDE: f64 = 7.0;

/// What is next to such a sample belongs to it by this many.
const BESIDE: f64 = 3.5;

/// Fewer tell no usual scatter.
const LEAST: usize = 20;

/// Which samples are told apart from each other: those of a stretch, and the poses of a run that is one by one at rest. What a model
/// leaves of those scatters alike; what a gap leaves need not.
pub fn with_single_poses(stretch: &[usize], run: &[usize]) -> Vec<usize> {
    let mut samples = vec![0; stretch.iter().max().map_or(0, |last| last + 1)];
    stretch.iter().for_each(|s| samples[*s] += 1);
    let of = |(s, r): (&usize, &usize)| {
        if samples[*s] < LEAST {
            samples.len() + r
        } else {
            *s
        }
    };
    stretch.iter().zip(run).map(of).collect()
}

/// Marks samples that stand out of their neighbourhood. `rows` are (sample, channel, whitened residual) in time order.
pub fn disturbed(rows: &[(usize, usize, f64)], samples: usize, stretch: &[usize]) -> Vec<bool> {
    let mut marked = vec![false; samples];
    for channel in 0..effects::sensor::CHANNELS {
        let list: Vec<(usize, f64)> = rows
            .iter()
            .filter(|r| r.1 == channel)
            .map(|r| (r.0, r.2))
            .collect();
        let mut start = 0;
        while start < list.len() {
            let mut end = start;
            while end < list.len()
                && end - start < PIECE
                && stretch[list[end].0] == stretch[list[start].0]
            {
                end += 1;
            }
            // What is left of a stretch is held against what is before it as well.
            let of_it = |k: &usize| stretch[list[*k].0] == stretch[list[start].0];
            let back = (end.saturating_sub(PIECE)..start).rev().take_while(of_it);
            let from = start - if end - start < PIECE { back.count() } else { 0 };
            let mut values: Vec<f64> = list[from..end].iter().map(|r| r.1).collect();
            if let Some((centre, deviation)) =
                median_and_deviation(&mut values).filter(|_| end - from >= LEAST)
            {
                let limit = OUTSIDE * deviation.max(1.0);
                let far = |k: &usize, limit: f64| (list[*k].1 - centre).abs() > limit;
                let near = limit * BESIDE / OUTSIDE;
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

    fn with_one_burst(samples: usize, at: usize) -> Vec<(usize, usize, f64)> {
        let usual = |i: usize| (1.7 * i as f64).sin() * 1.4;
        let value = |i: usize| if i == at { 12.0 } else { usual(i) };
        (0..samples).map(|i| (i, 0, value(i))).collect()
    }

    #[test]
    fn poses_one_by_one_are_held_against_each_other() {
        let rows = with_one_burst(90, 40);
        let stretch: Vec<usize> = (0..90).collect();
        let marked = |pieces: &[usize]| disturbed(&rows, 90, pieces).iter().filter(|m| **m).count();
        assert_eq!(marked(&stretch), 0);
        let pieces = with_single_poses(&stretch, &[3; 90]);
        assert_eq!(marked(&pieces), 1);
        let one = with_single_poses(&[0; 90], &[3; 90]);
        assert_eq!(one, [0; 90]);
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
        let rows: Vec<(usize, usize, f64)> = (0..140).map(|i| (i, 0, value(i))).collect();
        let marked = disturbed(&rows, 140, &[0; 140]);
        assert!((124..135).filter(|i| marked[*i]).count() > 8);
        assert!((0..124).chain(135..140).all(|i| !marked[i]));
    }

    #[test]
    fn the_tail_of_a_disturbance_is_marked_with_it() {
        let value = |i: usize| match i {
            100 => 20.0,
            101 => 7.0,
            50 => 7.0,
            _ => (1.7 * i as f64).sin() * 1.4,
        };
        let rows: Vec<(usize, usize, f64)> = (0..200).map(|i| (i, 0, value(i))).collect();
        let marked = disturbed(&rows, 200, &[0; 200]);
        let list: Vec<usize> = (0..200).filter(|&i| marked[i]).collect();
        assert_eq!(list, [100, 101]);
    }
}
