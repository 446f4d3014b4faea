//! Wait states of loads from flash: constants, and literals between the instructions (RM0440, 3.3.4 and 3.3.5).
//!
//! The data cache has 8 lines of four rows, 256 bytes. A row of 64 bits that it does not hold costs all wait states, and so does every load
//! while it is off. Not modelled: that a load and a fetch wait for each other.

use std::collections::VecDeque;

/// Bytes of a row, and rows of a line.
const ROW_BYTES: u32 = 8;
const LINE_ROWS: u32 = 4;
/// Lines that it holds.
const LINES: usize = 8;

/// What it holds.
#[derive(Clone, Debug, Default)]
pub struct DataCache {
    /// Lines and which of their rows are there, most recently used first.
    held: VecDeque<(u32, u8)>,
}

impl DataCache {
    /// Cycles that a load waits: `states` are the flash's; `is_on`: the cache is.
    pub fn load(&mut self, address: u32, states: u32, is_on: bool) -> u32 {
        if !is_on {
            self.held.clear();
            return states;
        }
        let row = address / ROW_BYTES;
        let (line, bit) = (row / LINE_ROWS, 1 << (row % LINE_ROWS));
        let place = self.held.iter().position(|(held, _)| *held == line);
        let rows = place
            .and_then(|place| self.held.remove(place))
            .map_or(0, |(_, rows)| rows);
        self.held.push_front((line, rows | bit));
        self.held.truncate(LINES);
        if rows & bit == 0 { states } else { 0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_is_waited_for_once_and_a_line_that_was_not_used_for_long_again() {
        let mut cache = DataCache::default();
        let mut load = |address| cache.load(address, 4, true);
        assert_eq!([load(0), load(4), load(8), load(0)], [4, 0, 4, 0]);
        for line in 1..8 {
            assert_eq!(load(32 * line), 4);
        }
        assert_eq!(load(0), 0, "eight lines are held");
        let ninth = load(32 * 8);
        assert_eq!([ninth, load(0), load(32)], [4, 0, 4]);
    }

    #[test]
    fn a_cache_that_is_off_holds_nothing() {
        let mut cache = DataCache::default();
        assert_eq!(cache.load(0, 4, true), 4);
        assert_eq!(cache.load(0, 4, false), 4);
        assert_eq!(cache.load(0, 4, false), 4);
        assert_eq!(cache.load(0, 4, true), 4);
    }
}
