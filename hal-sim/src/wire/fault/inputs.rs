//! Faults before the converters: sensor, cable, amplifier, supply.

use super::Switch;
use crate::wire::ad7606c::CHANNELS;

/// What can be wrong with what stands at the converters' inputs; an operation is one conversion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InputFault {
    /// One channel stays at a value: 0 is a dead one, an end of the range a saturated one.
    Stuck {
        /// 0 or 1.
        chip: usize,
        /// 0 to 7.
        channel: usize,
        /// Counts at ±5 V full scale.
        counts: i16,
    },
    /// All channels stay where they were.
    Frozen,
    /// No conversion starts: BUSY stays low and the last results are read again.
    Off,
}

/// Counts as they come after the fault; none: nothing is converted.
pub(crate) fn spoil(
    switch: &Switch<InputFault>,
    fresh: [[i16; CHANNELS]; 2],
    last: &mut [[i16; CHANNELS]; 2],
) -> Option<[[i16; CHANNELS]; 2]> {
    let mut counts = fresh;
    match switch.strike() {
        None => {}
        Some(InputFault::Stuck {
            chip,
            channel,
            counts: stuck,
        }) => {
            if let Some(place) = counts.get_mut(chip).and_then(|chip| chip.get_mut(channel)) {
                *place = stuck;
            }
        }
        Some(InputFault::Frozen) => counts = *last,
        Some(InputFault::Off) => return None,
    }
    *last = counts;
    Some(counts)
}
