//! What the board's lines do, kept as changes of level.

use crate::line_levels::Lines;
use crate::time::Ticks;

/// A line of the board: its name in a trace.
pub const NAMES: [&str; 9] = [
    "CONVST", "BUSY", "CS0", "CS1", "SCLK0", "SCLK1", "DOUT0", "DOUT1", "RESET",
];
const CONVST: usize = 0;
const BUSY: usize = 1;
const SELECT: usize = 2;
const CLOCK: usize = 4;
const DATA: usize = 6;
const RESET: usize = 8;

/// A line has another level from this instant on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Change {
    /// When.
    pub at: Ticks,
    /// Which, a place in [`NAMES`].
    pub line: usize,
    /// The new level.
    pub high: bool,
}

/// Changes since it was put into the chip.
#[derive(Clone, Debug)]
pub struct Recorder {
    begin: Ticks,
    seen: [Option<bool>; NAMES.len()],
    changes: Vec<Change>,
}

impl Recorder {
    /// A record that begins now; its instants are counted from here.
    pub fn new(begin: Ticks) -> Self {
        Self {
            begin,
            seen: [None; NAMES.len()],
            changes: vec![],
        }
    }

    /// The lines' levels now. What floats is taken as low, a chip select as high: so its pull or its resistor holds it.
    pub fn levels(&mut self, now: Ticks, lines: &Lines) {
        self.level(now, CONVST, lines.convst.unwrap_or(false));
        self.level(now, BUSY, lines.busy);
        self.level(now, RESET, lines.reset.unwrap_or(false));
        for (chip, level) in lines.selected.into_iter().enumerate() {
            self.level(now, SELECT + chip, level.unwrap_or(true));
        }
        for bus in 0..2 {
            // Mode 2: the clock is high between two bytes.
            if self.seen[CLOCK + bus].is_none() {
                self.level(now, CLOCK + bus, true);
            }
        }
    }

    /// A byte has gone over a bus between these instants: eight falling edges of its clock, at which the data are valid.
    pub fn byte(&mut self, bus: usize, [begin, end]: [Ticks; 2], answer: u8) {
        if begin < self.begin {
            return;
        }
        let half = (end - begin) / 16;
        for bit in 0..8 {
            let at = begin + 2 * bit * half;
            self.level(at, DATA + bus, answer >> (7 - bit) & 1 == 1);
            self.level(at + half, CLOCK + bus, false);
            self.level(at + 2 * half, CLOCK + bus, true);
        }
    }

    fn level(&mut self, at: Ticks, line: usize, high: bool) {
        if self.seen[line] != Some(high) {
            self.seen[line] = Some(high);
            let at = at - self.begin;
            self.changes.push(Change { at, line, high });
        }
    }

    /// All changes, in the order of time.
    pub fn changes(mut self) -> Vec<Change> {
        self.changes.sort_by_key(|change| change.at);
        self.changes
    }
}
