//! Wait states of the instructions' fetches: the flash's rows, its prefetch and its instruction cache (RM0440, 3.3.4 and 3.3.5).
//!
//! A row is 64 bits with two banks. A row that is neither cached nor prefetched costs all wait states; the next row in a straight line is
//! fetched while the one before is executed. Not modelled: the data's side (constants, the data cache), and what both share of the flash.

use std::collections::VecDeque;

/// Bytes of a row.
const ROW_BYTES: u32 = 8;
/// Rows that the instruction cache holds: 1 KiB.
const CACHED_ROWS: usize = 128;

/// Rows at hand.
#[derive(Clone, Debug, Default)]
pub struct Fetch {
    /// Most recently used first.
    cached: VecDeque<u32>,
    row: Option<u32>,
    /// Cycles spent in the row.
    spent: u32,
}

impl Fetch {
    /// Cycles that a block waits for its instructions: `cycles` are its own, `states` the flash's.
    pub fn block(&mut self, address: u32, bytes: u32, cycles: u32, states: u32) -> u32 {
        let (first, last) = (
            address / ROW_BYTES,
            (address + bytes.max(1) - 1) / ROW_BYTES,
        );
        let each = cycles / (last - first + 1);
        let mut waited = 0;
        for row in first..=last {
            waited += self.enter(row, states);
            self.spent += each;
        }
        waited
    }

    fn enter(&mut self, row: u32, states: u32) -> u32 {
        if self.row == Some(row) {
            return 0;
        }
        let follows = self.row.is_some_and(|before| row == before + 1);
        let (spent, known) = (self.spent, self.cached.iter().position(|held| *held == row));
        self.row = Some(row);
        self.spent = 0;
        if let Some(place) = known {
            self.cached.remove(place);
        }
        self.cached.push_front(row);
        self.cached.truncate(CACHED_ROWS);
        match known {
            Some(_) => 0,
            None if follows => (states + 1).saturating_sub(spent),
            None => states,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_loop_waits_once_and_a_straight_line_for_what_its_own_time_leaves() {
        let mut fetch = Fetch::default();
        // Two rows of four cycles each: all states, then 4 + 1 - 4.
        assert_eq!(fetch.block(0x100, 16, 8, 4), 5);
        assert_eq!(fetch.block(0x100, 16, 8, 4), 0);
        // Slow instructions hide the fetch of the row after theirs.
        assert_eq!(fetch.block(0x200, 16, 40, 4), 4);
        assert_eq!(fetch.block(0x300, 16, 8, 0), 0);
    }

    #[test]
    fn what_was_not_used_for_long_is_fetched_again() {
        let mut fetch = Fetch::default();
        assert_eq!(fetch.block(0, 8, 4, 4), 4);
        for row in 1..=128 {
            let _ = fetch.block(0x1000 + 16 * row, 8, 4, 4);
        }
        assert_eq!(fetch.block(0, 8, 4, 4), 4);
    }
}
