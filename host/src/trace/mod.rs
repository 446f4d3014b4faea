//! What a logic analyser has recorded at the sensor board's pins, and whether it is as it should be.
//!
//! `file` reads what the instrument's program has written (`vcd`, `csv`, into `contents`). `lines` tells which channel is which line of the
//! board. `conversions` finds what belongs to one conversion. `judge` decides each step from that, by the `limits`.

mod clock;
mod contents;
mod conversions;
mod csv;
pub mod file;
mod judge;
mod limits;
pub mod lines;
mod measure;
mod signal;
mod vcd;

pub use judge::judge;
pub use lines::{Line, Lines};
pub use measure::megahertz;
pub use signal::{Pulse, Signal};

/// A recording of some channels.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    /// Each channel's name and its level over time.
    pub channels: Vec<(String, Signal)>,
    /// The time that it covers, seconds.
    pub span: Span,
}

/// The time that a recording covers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// Its first instant, seconds of its own.
    pub begin_s: f64,
    /// Its last one.
    pub end_s: f64,
    /// From one look of the instrument's at the levels to the next, seconds: an edge may have been so much earlier than it is recorded.
    pub step_s: f64,
}
