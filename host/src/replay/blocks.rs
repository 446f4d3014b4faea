//! Which samples are fitted and which are held out: a third of the stretches, both ways.

use std::ops::Range;

/// A sample enters if an output has moved this far since the last one that did, pitches: the sensor's resolution of one part in
/// 5000 (paper, section 1). A long rest would otherwise outweigh the motion with copies of one place.
const STEP_PITCHES: f64 = 1.0 / 5000.0;
/// The whole path is cut into about this many stretches. Derived from their third that is held out, of which 43 tell a scatter to
/// 11 %.
const STRETCHES: f64 = 128.0;
/// Their least and greatest length, pitches: not below a quarter of the period of order 16, the error model's highest, nor so
/// long that a pass is one stretch. On a recording of a single pitch longer ones would leave whole flanks of an over-ranged
/// sensor's error unseen, and judge the extrapolation instead of the calibration. Derived from both: a 64th is that quarter, and
/// a pass over the paper's ten pitches is five stretches.
const STRETCH_PITCHES: [f64; 2] = [1.0 / 64.0, 2.0];
/// Share of the stretches that is held out.
const HELD_OUT: f64 = 1.0 / 3.0;
/// Inverse golden ratio. Stretch k is held out if the fraction of k times this is below [`HELD_OUT`]: evenly spread, never two in
/// a row, and in step with no harmonic of the pitch. Every third stretch would be: with a third of an eighth of a pitch it holds
/// out the same part of each period of order 8, which an over-ranged converter makes. Derived from the golden section: the
/// fractions of its multiples fill a unit evenly, however many there are.
const SPREAD: f64 = 0.618_033_988_749_894_8;

/// Indices of samples, each in order of time.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Split {
    /// To be fitted.
    pub fitted: Vec<usize>,
    /// To be judged on.
    pub held_out: Vec<usize>,
}

/// Splits the samples at `places`, which lists `(sample, outputs in pitches)` in order of time.
///
/// The coordinate that moves most is cut into stretches of equal length; a third of them is held out whenever they are
/// passed, on the way there and on the way back: a delay or a backlash then weighs alike in what is fitted and what is
/// judged, and no held-out place was fitted from the other side.
pub fn split<const N: usize>(places: &[(usize, [f64; N])]) -> Split {
    let moved = moving(places);
    let path: f64 = moved
        .windows(2)
        .map(|pair| distance(&pair[0].1, &pair[1].1))
        .sum();
    let length = (path / STRETCHES).clamp(STRETCH_PITCHES[0], STRETCH_PITCHES[1]);
    let mut split = Split::default();
    for (range, coordinate) in legs(&moved, length) {
        for (sample, place) in &moved[range] {
            let stretch = (place[coordinate] / length).floor();
            let held_out = (stretch * SPREAD).rem_euclid(1.0) < HELD_OUT;
            if held_out {
                &mut split.held_out
            } else {
                &mut split.fitted
            }
            .push(*sample);
        }
    }
    split
}

fn moving<const N: usize>(places: &[(usize, [f64; N])]) -> Vec<(usize, [f64; N])> {
    let mut moved: Vec<(usize, [f64; N])> = Vec::new();
    for place in places {
        if moved
            .last()
            .is_none_or(|last| distance(&last.1, &place.1) >= STEP_PITCHES)
        {
            moved.push(*place);
        }
    }
    moved
}

/// Cuts the way into legs of `length`; each with the coordinate that moves most in it.
fn legs<const N: usize>(moved: &[(usize, [f64; N])], length: f64) -> Vec<(Range<usize>, usize)> {
    let mut legs = Vec::new();
    let mut begin = 0;
    let mut path = 0.0;
    for end in 1..=moved.len() {
        path += moved
            .get(end)
            .map_or(f64::INFINITY, |next| distance(&moved[end - 1].1, &next.1));
        if path >= length {
            let last = moved.get(end).unwrap_or(&moved[end - 1]);
            legs.push((begin..end, coordinate(&moved[begin].1, &last.1)));
            (begin, path) = (end, 0.0);
        }
    }
    legs
}

/// Largest difference of any coordinate.
fn distance<const N: usize>(from: &[f64; N], to: &[f64; N]) -> f64 {
    from.iter()
        .zip(to)
        .fold(0.0, |largest, (from, to)| largest.max((to - from).abs()))
}

/// The coordinate that differs most.
fn coordinate<const N: usize>(from: &[f64; N], to: &[f64; N]) -> usize {
    let mut most = 0;
    for coordinate in 1..N {
        if (to[coordinate] - from[coordinate]).abs() > (to[most] - from[most]).abs() {
            most = coordinate;
        }
    }
    most
}

#[cfg(test)]
mod tests {
    use super::*;

    /// There over one pitch in steps of a thousandth, a rest with some noise, and back.
    fn there_and_back() -> Vec<(usize, [f64; 1])> {
        let there = (0..1000).map(|step| f64::from(step) / 1000.0);
        let rest = (0..3000).map(|step| 1.0 + 1e-5 * f64::from(step % 7));
        let back = (0..1000).rev().map(|step| f64::from(step) / 1000.0);
        there
            .chain(rest)
            .chain(back)
            .enumerate()
            .map(|(index, place)| (index, [place]))
            .collect()
    }

    #[test]
    fn a_rest_counts_once() {
        let split = split(&there_and_back());
        assert_eq!(split.fitted.len() + split.held_out.len(), 2001);
    }

    #[test]
    fn a_third_of_both_directions_is_held_out_in_blocks() {
        let split = split(&there_and_back());
        for range in [0..1000, 4000..5000] {
            let held_out: Vec<usize> = split
                .held_out
                .iter()
                .copied()
                .filter(|index| range.contains(index))
                .collect();
            assert!((250..=450).contains(&held_out.len()), "{}", held_out.len());
            let breaks = held_out
                .windows(2)
                .filter(|pair| pair[1] != pair[0] + 1)
                .count();
            assert!(breaks <= 30, "{breaks} breaks: no blocks");
        }
    }

    #[test]
    fn the_same_places_are_held_out_both_ways() {
        let places = there_and_back();
        let split = split(&places);
        let held_out = |range: Range<usize>| -> Vec<bool> {
            let mut hit = vec![false; 1001];
            for index in split.held_out.iter().filter(|index| range.contains(index)) {
                hit[(places[*index].1[0] * 1000.0).round() as usize] = true;
            }
            hit
        };
        let (there, back) = (held_out(0..1000), held_out(4000..5000));
        let differ = there
            .iter()
            .zip(back)
            .filter(|(there, back)| *there != back)
            .count();
        assert!(differ <= 3, "{differ} of 1000 places differ");
    }

    #[test]
    fn independent_poses_are_blocks_of_their_own() {
        let places: Vec<(usize, [f64; 2])> = (0..300)
            .map(|index| {
                (
                    index,
                    [
                        f64::from((index * 37 % 101) as u32),
                        f64::from((index * 53 % 97) as u32),
                    ],
                )
            })
            .collect();
        let split = split(&places);
        assert!(
            (70..=130).contains(&split.held_out.len()),
            "{}",
            split.held_out.len()
        );
    }

    #[test]
    fn nothing_gives_nothing() {
        assert_eq!(split::<1>(&[]), Split::default());
        assert_eq!(split(&[(7, [0.5])]).fitted.len(), 1);
    }
}
