//! The levels of the board's lines, as they were last seen.

use crate::time::Ticks;

/// Levels of the driven lines.
#[derive(Clone, Debug, Default)]
pub struct Lines {
    pub(crate) convst: Option<bool>,
    pub(crate) convst_since: Ticks,
    pub(crate) reset: Option<bool>,
    pub(crate) selected: [Option<bool>; 2],
    pub(crate) busy: bool,
    pub(crate) bus_checked: [bool; 2],
    pub(crate) serial_checked: bool,
}
