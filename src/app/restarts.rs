//! Starts in a row that a fault caused, and when to leave alone what is stored.
//!
//! A stored calibration that the firmware fails on would restart the board for ever. After [`SAFE_AFTER`] such starts without a minute of
//! service between them it samples and speaks, with nothing in force, until it is restarted by order or by its supply.

use crate::link::message::{FaultReport, Health, ResetCause};

/// Faults in a row after which a start leaves alone what is stored: once may be a bit that fell over, twice a coincidence.
pub const SAFE_AFTER: u8 = 3;
/// Service without a fault after which the row begins anew, seconds: a record that is faulty shows within the first samples, a session that
/// is faulty within its first poses.
pub const SERVICE_S: u32 = 60;

/// Why the board started, and what was kept from before.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StartReport {
    /// Cause of the last reset.
    pub cause: ResetCause,
    /// Fault record, if there is one.
    pub fault: Option<FaultReport>,
    /// What was tested before.
    pub health: Health,
}

/// Faults in a row at a start, this one included. `before`: what was kept from the start before; none if memory lost it.
pub const fn faults_in_a_row(before: Option<u8>, cause: ResetCause) -> u8 {
    let before = match before {
        Some(before) => before,
        None => 0,
    };
    match cause {
        ResetCause::Watchdog | ResetCause::Panic | ResetCause::HardFault => {
            before.saturating_add(1)
        }
        // The firmware had no part in it, and nobody has looked at the board.
        ResetCause::BrownOut => before,
        ResetCause::PowerOn | ResetCause::Pin | ResetCause::Requested => 0,
    }
}

/// Whether a start after so many faults in a row leaves alone what is stored.
pub const fn is_safe_mode(faults: u8) -> bool {
    faults >= SAFE_AFTER
}

/// A number of faults in a row as it is kept over a reset: with that of the image, which updates count.
pub const fn kept_row(faults: u8, image: u32) -> u32 {
    image << 8 | faults as u32
}

/// The number that was kept by this image. Those of an image that was tried and given up are none of its own: it would come back in safe
/// mode.
pub const fn own_row(kept: u32, image: u32) -> Option<u8> {
    if kept == kept_row(kept as u8, image) {
        Some(kept as u8)
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Faults in a row after these starts.
    fn after(causes: &[ResetCause]) -> u8 {
        let row = |before, cause: &ResetCause| faults_in_a_row(Some(before), *cause);
        causes.iter().fold(0, row)
    }

    #[test]
    fn three_faults_in_a_row_are_safe_mode_and_an_order_ends_it() {
        use ResetCause::*;
        assert!(!is_safe_mode(after(&[Panic, HardFault])));
        assert!(is_safe_mode(after(&[Panic, HardFault, Watchdog])));
        assert!(is_safe_mode(after(&[Panic, BrownOut, Panic, Panic])));
        for ends in [Requested, Pin, PowerOn] {
            assert_eq!(after(&[Panic, Panic, Panic, ends]), 0);
            assert_eq!(after(&[Panic, Panic, ends, Panic]), 1);
        }
        assert_eq!(own_row(kept_row(2, 7), 7), Some(2));
        assert_eq!(own_row(kept_row(2, 8), 7), None, "another image's");
        assert_eq!(faults_in_a_row(None, Panic), 1, "memory was lost");
        assert_eq!(faults_in_a_row(Some(u8::MAX), Panic), u8::MAX);
    }
}
