//! What the commands need of a board, whichever it is.

use anyhow::Result;
use std::time::Duration;

/// A board's byte channels and its time. Nothing here blocks but [`Wire::pass`].
pub trait Wire {
    /// Takes bytes that the board has sent on a channel; returns how many.
    ///
    /// # Errors
    /// The board cannot be reached.
    fn receive(&mut self, channel: usize, bytes: &mut [u8]) -> Result<usize>;

    /// Gives the board bytes of the command channel; returns how many there was room for.
    ///
    /// # Errors
    /// The board cannot be reached.
    fn send(&mut self, bytes: &[u8]) -> Result<usize>;

    /// Lets the board run for so long of its own time.
    ///
    /// # Errors
    /// The board cannot be reached or has stopped.
    fn pass(&mut self, time: Duration) -> Result<()>;
}
