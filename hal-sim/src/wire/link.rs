//! The debug link's byte channels between a simulated board and a host in the same process.
//!
//! Sized like the board's own buffers, so that a slow host loses what it would lose there.

use courier_sensor::app::console::Ports;
use courier_sensor::app::intake::Telemetry;
use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;

/// Bytes of the command and the reply channel.
pub const COMMAND_BYTES: usize = 1024;
/// Bytes of the telemetry channel.
pub const TELEMETRY_BYTES: usize = 8192;

#[derive(Debug, Default)]
struct Channels {
    commands: VecDeque<u8>,
    replies: VecDeque<u8>,
    telemetry: VecDeque<u8>,
}

/// All three channels. Clones are the same; the board's ends are [`Ports`] and [`Telemetry`], the host's the methods here.
#[derive(Clone, Debug, Default)]
pub struct LinkWire(Rc<RefCell<Channels>>);

impl LinkWire {
    /// Empty channels.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Gives command bytes; how many there was room for.
    pub fn write_commands(&self, bytes: &[u8]) -> usize {
        put(&mut self.0.borrow_mut().commands, bytes, COMMAND_BYTES)
    }

    /// Takes reply bytes; how many.
    pub fn read_replies(&self, bytes: &mut [u8]) -> usize {
        take(&mut self.0.borrow_mut().replies, bytes)
    }

    /// Takes telemetry bytes; how many.
    pub fn read_telemetry(&self, bytes: &mut [u8]) -> usize {
        take(&mut self.0.borrow_mut().telemetry, bytes)
    }
}

impl Ports for LinkWire {
    fn read_commands(&mut self, bytes: &mut [u8]) -> usize {
        take(&mut self.0.borrow_mut().commands, bytes)
    }

    fn write_replies(&mut self, bytes: &[u8]) -> usize {
        put(&mut self.0.borrow_mut().replies, bytes, COMMAND_BYTES)
    }
}

impl Telemetry for LinkWire {
    fn write(&mut self, bytes: &[u8]) -> bool {
        let mut channels = self.0.borrow_mut();
        let room = TELEMETRY_BYTES - channels.telemetry.len();
        if bytes.len() > room {
            return false;
        }
        channels.telemetry.extend(bytes);
        true
    }
}

fn put(queue: &mut VecDeque<u8>, bytes: &[u8], capacity: usize) -> usize {
    let taken = bytes.len().min(capacity - queue.len());
    queue.extend(&bytes[..taken]);
    taken
}

fn take(queue: &mut VecDeque<u8>, bytes: &mut [u8]) -> usize {
    let taken = bytes.len().min(queue.len());
    for (place, byte) in bytes.iter_mut().zip(queue.drain(..taken)) {
        *place = byte;
    }
    taken
}
