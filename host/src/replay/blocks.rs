//! Which samples are fitted and which are held out: contiguous blocks, a third of each direction of travel.

/// A sample enters if an output has moved this far since the last one that did, pitches: the sensor's resolution of one
/// part in 5000. A long rest would otherwise outweigh the motion with copies of one place.
const STEP_PITCHES: f64 = 1.0 / 5000.0;
/// The whole path is cut into about this many blocks …
const BLOCKS: f64 = 40.0;
/// … neither so short that neighbours share their error, pitches, nor so long that a block is a pass of its own.
const BLOCK_PITCHES: [f64; 2] = [1.0 / 16.0, 2.0];
/// One block in this many is held out.
const HELD_OUT_EVERY: usize = 3;

/// Indices of samples, each in order of time.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Split {
    /// To be fitted.
    pub fitted: Vec<usize>,
    /// To be judged on.
    pub held_out: Vec<usize>,
}

/// A contiguous run of samples that enter.
struct Block {
    samples: Vec<usize>,
    /// Coordinate that moved most, times two, plus one if it went down.
    direction: usize,
}

/// Splits the samples at `places`, which lists `(sample, outputs in pitches)` in order of time.
///
/// Blocks are cut by path length; in each direction of travel of each coordinate one in three is held out, the
/// way back not at the places of the way there.
pub fn split<const N: usize>(places: &[(usize, [f64; N])]) -> Split {
    let moved = moving(places);
    let path: f64 = moved
        .windows(2)
        .map(|pair| distance(&pair[0].1, &pair[1].1))
        .sum();
    let length = (path / BLOCKS).clamp(BLOCK_PITCHES[0], BLOCK_PITCHES[1]);
    let mut seen = vec![0; 2 * N];
    let mut split = Split::default();
    for block in blocks(&moved, length) {
        let turn = &mut seen[block.direction];
        // Up from one, down from nothing: a way there and back is not held out at the same places.
        let held_out = *turn % HELD_OUT_EVERY == 1 - block.direction % 2;
        *turn += 1;
        if held_out {
            &mut split.held_out
        } else {
            &mut split.fitted
        }
        .extend(block.samples);
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

fn blocks<const N: usize>(moved: &[(usize, [f64; N])], length: f64) -> Vec<Block> {
    let mut blocks = Vec::new();
    let mut begin = 0;
    let mut path = 0.0;
    for end in 1..=moved.len() {
        path += moved
            .get(end)
            .map_or(f64::INFINITY, |next| distance(&moved[end - 1].1, &next.1));
        if path >= length {
            let last = moved.get(end).unwrap_or(&moved[end - 1]);
            blocks.push(Block {
                samples: moved[begin..end].iter().map(|place| place.0).collect(),
                direction: direction(&moved[begin].1, &last.1),
            });
            (begin, path) = (end, 0.0);
        }
    }
    blocks
}

/// Largest difference of any coordinate.
fn distance<const N: usize>(from: &[f64; N], to: &[f64; N]) -> f64 {
    from.iter()
        .zip(to)
        .fold(0.0, |largest, (from, to)| largest.max((to - from).abs()))
}

fn direction<const N: usize>(from: &[f64; N], to: &[f64; N]) -> usize {
    let mut most = 0;
    for coordinate in 1..N {
        if (to[coordinate] - from[coordinate]).abs() > (to[most] - from[most]).abs() {
            most = coordinate;
        }
    }
    2 * most + usize::from(to[most] < from[most])
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
            assert!(breaks <= 7, "{breaks} breaks: no blocks");
        }
    }

    #[test]
    fn no_place_is_held_out_in_both_directions() {
        let places = there_and_back();
        let split = split(&places);
        let tenths = |range: std::ops::Range<usize>| -> Vec<bool> {
            let mut hit = vec![false; 1001];
            for index in split.held_out.iter().filter(|index| range.contains(index)) {
                hit[(places[*index].1[0] * 1000.0).round() as usize] = true;
            }
            hit
        };
        let both = tenths(0..1000)
            .iter()
            .zip(tenths(4000..5000))
            .filter(|(there, back)| **there && *back)
            .count();
        assert!(both < 60, "{both} of 1000 places are held out both ways");
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
            (90..=110).contains(&split.held_out.len()),
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
