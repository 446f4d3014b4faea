//! How often something may be written, so that the flash lasts: a fault that repeats is not written each time.
//!
//! A page endures 10,000 erases (data sheet DS12288), and four pages hold some 150 entries. Without restarts an entry every
//! [`REFILL_S`] is written at most: 32 years. A board that restarts every ten minutes for ever, with three entries each time, has worn the
//! log out after 9 years; one that restarts more often writes nothing once it has done so [`MOST_SHORT_STARTS`] times.

/// Seconds until another entry may be written, beyond the first eight.
pub const REFILL_S: u32 = 600;
/// Entries that may be written at once.
const MOST: u8 = 8;
/// A start that has lasted for so long, seconds, is no longer a short one.
pub const SETTLED_S: u32 = 600;
/// Short starts in a row that are written at once; of the next nothing is written before it is settled.
pub const MOST_SHORT_STARTS: u32 = 8;
/// A supply that flickers starts the board again and again: a start that no fault caused is written after so long, seconds.
pub const START_S: u32 = 10;

/// Entries that may be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pace {
    left: u8,
    refilled_s: u32,
}

impl Default for Pace {
    fn default() -> Self {
        Self {
            left: MOST,
            refilled_s: 0,
        }
    }
}

impl Pace {
    /// Takes one at a time since start, if there is one.
    pub fn take(&mut self, uptime_s: u32) -> bool {
        let refills = uptime_s.saturating_sub(self.refilled_s) / REFILL_S;
        self.refilled_s += refills * REFILL_S;
        self.left = refills
            .saturating_add(u32::from(self.left))
            .min(u32::from(MOST)) as u8;
        match self.left.checked_sub(1) {
            Some(left) => {
                self.left = left;
                true
            }
            None => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_repeats_is_written_eight_times_and_then_every_ten_minutes() {
        let mut pace = Pace::default();
        let day_s = 86_400;
        let written = (0..day_s).filter(|uptime_s| pace.take(*uptime_s)).count() as u32;
        assert_eq!(written, u32::from(MOST) + (day_s - 1) / REFILL_S);
        assert!(pace.take(day_s * 10), "after a rest again");
    }
}
