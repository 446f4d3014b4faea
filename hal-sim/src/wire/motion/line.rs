//! The firmware's end of the motion controller's line, as embedded-io parts.

use super::controller::{BYTE_NS, Controller, TRANSMITTER_BYTES};
use embedded_io::{ErrorKind, ErrorType, Read, ReadReady, Write, WriteReady};
use std::cell::RefCell;
use std::rc::Rc;

/// The firmware's end of the serial line.
pub struct Line(pub(super) Rc<RefCell<Controller>>);

impl Line {
    /// Takes every byte that the controller has begun to send, also those that are still to come, each with the instant at which it
    /// will have arrived, nanoseconds: for a receiver elsewhere.
    pub fn take_coming(&mut self) -> Vec<(u64, u8)> {
        let mut controller = self.0.borrow_mut();
        let now_ns = controller.clock.now_ns();
        controller.run_until(now_ns);
        controller.to_sensor.drain(..).collect()
    }
}

impl ErrorType for Line {
    type Error = ErrorKind;
}

impl ReadReady for Line {
    fn read_ready(&mut self) -> Result<bool, ErrorKind> {
        let mut controller = self.0.borrow_mut();
        let now_ns = controller.clock.now_ns();
        controller.run_until(now_ns);
        Ok(controller
            .to_sensor
            .front()
            .is_some_and(|(at_ns, _)| *at_ns <= now_ns))
    }
}

impl Read for Line {
    /// In place of blocking, virtual time goes on to the next byte; with none under way this is a time-out.
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize, ErrorKind> {
        if buffer.is_empty() {
            return Ok(0);
        }
        self.read_ready()?;
        let mut controller = self.0.borrow_mut();
        let (first_ns, _) = controller
            .to_sensor
            .front()
            .copied()
            .ok_or(ErrorKind::TimedOut)?;
        controller.clock.advance_to_ns(first_ns);
        let now_ns = controller.clock.now_ns();
        let mut taken = 0;
        while let Some((at_ns, byte)) = controller.to_sensor.front().copied()
            && at_ns <= now_ns
            && taken < buffer.len()
        {
            buffer[taken] = byte;
            taken += 1;
            controller.to_sensor.pop_front();
        }
        Ok(taken)
    }
}

impl WriteReady for Line {
    fn write_ready(&mut self) -> Result<bool, ErrorKind> {
        let mut controller = self.0.borrow_mut();
        let now_ns = controller.clock.now_ns();
        controller.run_until(now_ns);
        Ok(controller.to_controller.len() < TRANSMITTER_BYTES)
    }
}

impl Write for Line {
    /// In place of blocking, virtual time goes on until the transmitter has room.
    fn write(&mut self, bytes: &[u8]) -> Result<usize, ErrorKind> {
        if !self.write_ready()?
            && let Some((at_ns, _)) = self.0.borrow().to_controller.front().copied()
        {
            self.0.borrow().clock.advance_to_ns(at_ns);
        }
        self.write_ready()?;
        let mut controller = self.0.borrow_mut();
        let room = TRANSMITTER_BYTES - controller.to_controller.len();
        let now_ns = controller.clock.now_ns();
        let mut at_ns = controller
            .to_controller
            .back()
            .map_or(0, |(at_ns, _)| *at_ns)
            .max(now_ns);
        for &byte in bytes.iter().take(room) {
            at_ns += BYTE_NS;
            controller.to_controller.push_back((at_ns, byte));
        }
        Ok(bytes.len().min(room))
    }

    fn flush(&mut self) -> Result<(), ErrorKind> {
        let last_ns = self
            .0
            .borrow()
            .to_controller
            .back()
            .map_or(0, |(at_ns, _)| *at_ns);
        self.0.borrow().clock.advance_to_ns(last_ns);
        Ok(())
    }
}
