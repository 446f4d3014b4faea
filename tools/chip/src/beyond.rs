//! What the parts at the chip's pins themselves lead to.

/// What lies behind the converters and at the far end of the serial line.
pub trait Beyond {
    /// A byte goes to the motion controller: its start bit is at this instant.
    fn send(&mut self, byte: u8, now_ns: u64);

    /// A byte that the motion controller has sent and that has arrived by now.
    fn receive(&mut self, now_ns: u64) -> Option<u8>;

    /// Temperature of the board, degrees Celsius.
    fn temperature_c(&self) -> f64;

    /// Whether a reference mark grounds its input, since the last conversion.
    fn at_mark(&self) -> bool;

    /// The edge of CONVST that comes next is the timer's, or software's.
    fn conversion(&mut self, _by_timer: bool) {}
}
