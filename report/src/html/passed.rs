//! How much of a turn a phase really passed, and so which waves over it can be seen.

/// Cells that a turn is cut into.
const CELLS: usize = 64;
/// A cell is passed if it holds this part of what an even spread would give it.
const PASSED: f64 = 0.1;

/// Highest order of waves over a phase (in turns, wrapped or not) that are really seen: half a wave of it is at least as long as the
/// widest piece of the turn that was not passed. Zero where that piece is half a turn or more: then no wave is.
pub fn highest_order(turns: &[f64]) -> usize {
    let mut count = [0_usize; CELLS];
    for turn in turns {
        let cell = (turn.rem_euclid(1.0) * CELLS as f64) as usize;
        count[cell.min(CELLS - 1)] += 1;
    }
    let least = PASSED * turns.len() as f64 / CELLS as f64;
    let passed = |k: usize| count[k % CELLS] > 0 && count[k % CELLS] as f64 >= least;
    let (mut widest, mut open) = (0, 0);
    // Twice around, so that a piece across the start counts as one.
    for k in 0..2 * CELLS {
        open = if passed(k) { 0 } else { open + 1 };
        widest = widest.max(open);
    }
    // Between two neighbouring cells that were passed there is at most one of them.
    CELLS / (2 * (widest + 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn evenly(from: f64, to: f64, n: u32) -> Vec<f64> {
        let at = |k| from + (to - from) * f64::from(k) / f64::from(n);
        (0..n).map(at).collect()
    }

    #[test]
    fn a_whole_turn_shows_all_orders_and_a_part_of_one_few_or_none() {
        assert_eq!(highest_order(&evenly(0.0, 12.0, 5000)), 32);
        assert_eq!(highest_order(&evenly(3.0, 3.9, 5000)), 4);
        assert_eq!(highest_order(&evenly(0.2, 0.75, 5000)), 1);
        assert_eq!(highest_order(&evenly(-0.1, 0.1, 5000)), 0);
        assert_eq!(highest_order(&[]), 0);
    }

    #[test]
    fn a_stray_sample_passes_nothing() {
        let mut turns = evenly(0.0, 0.1, 5000);
        turns.push(0.5);
        assert_eq!(highest_order(&turns), 0);
    }

    #[test]
    fn still_poses_at_random_show_low_orders() {
        let poses: Vec<f64> = (0..100).map(|k| f64::from(k) * 0.618_034).collect();
        assert!(highest_order(&poses) >= 8);
    }
}
