//! What the orders of a turn add, as the interrupt reads it: a table over the turn.

use super::pair::Reading;
use super::turn::LearnedTurn;
use crate::model::Unit;

/// What is added to a place, at `ENTRIES` (2 and up) places of a turn that are as far from each other, with straight lines between. With
/// sixteen entries a wave of the highest order they leave 2 % of it, with eight 8 %.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TurnTable<const ENTRIES: usize> {
    periods: u32,
    /// Periods of the signal.
    entries: [f32; ENTRIES],
}

impl<const ENTRIES: usize> TurnTable<ENTRIES> {
    /// Of what was learned. Background only: `ENTRIES` times the orders, some 10 operations each.
    #[must_use]
    pub fn new<const UNKNOWNS: usize>(learned: &LearnedTurn<UNKNOWNS>) -> Self {
        const { assert!(ENTRIES >= 2) };
        let mut entries = [0.0; ENTRIES];
        for (n, entry) in entries.iter_mut().enumerate() {
            *entry = learned.at(Unit::from_turns(n as f32 / ENTRIES as f32));
        }
        Self {
            periods: learned.periods,
            entries,
        }
    }

    /// What is to be added to the place of a reading, periods of the signal; `turn_start` as it was learned with. In the interrupt:
    /// a division of integers, then a handful of operations. No panic on any reading.
    #[must_use]
    pub fn at(&self, reading: &Reading, turn_start: i32) -> f32 {
        let place = reading.of_turn(self.periods, turn_start) * ENTRIES as f32;
        let index = place as i32 - i32::from(place < 0.0);
        let first = index.rem_euclid(ENTRIES as i32) as usize;
        let next = if first + 1 < ENTRIES { first + 1 } else { 0 };
        let [low, high] =
            [first, next].map(|index| self.entries.get(index).copied().unwrap_or(0.0));
        low + (place - index as f32) * (high - low)
    }
}
