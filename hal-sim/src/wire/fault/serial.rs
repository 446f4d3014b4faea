//! A serial line with faults.

use super::Switch;
use embedded_io::{ErrorKind, ErrorType, Read, ReadReady, Write, WriteReady};

/// Faults of a serial line; an operation is one byte in either direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SerialFault {
    /// Each bit flips with this probability.
    Flips(f64),
    /// The byte is lost.
    Dropped,
    /// The byte becomes another one.
    Noise,
    /// The line reports an error.
    Line,
}

/// A serial line with faults.
pub struct FaultySerial<S> {
    part: S,
    switch: Switch<SerialFault>,
}

impl<S> FaultySerial<S> {
    /// Wraps a line.
    pub fn new(part: S, switch: Switch<SerialFault>) -> Self {
        Self { part, switch }
    }

    /// The byte as it passes, if it does.
    fn pass(&self, byte: u8) -> Result<Option<u8>, ErrorKind> {
        Ok(match self.switch.strike() {
            None => Some(byte),
            Some(SerialFault::Flips(probability)) => {
                let mut bytes = [byte];
                self.switch.flip(&mut bytes, probability);
                Some(bytes[0])
            }
            Some(SerialFault::Dropped) => None,
            Some(SerialFault::Noise) => Some(self.switch.uniform(256.0) as u8),
            Some(SerialFault::Line) => return Err(ErrorKind::Other),
        })
    }
}

impl<S> ErrorType for FaultySerial<S> {
    type Error = ErrorKind;
}

impl<S: ReadReady> ReadReady for FaultySerial<S> {
    fn read_ready(&mut self) -> Result<bool, ErrorKind> {
        self.part
            .read_ready()
            .map_err(|error| embedded_io::Error::kind(&error))
    }
}

impl<S: Read> Read for FaultySerial<S> {
    /// May return 0 where the only byte was lost.
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize, ErrorKind> {
        let read = self
            .part
            .read(buffer)
            .map_err(|error| embedded_io::Error::kind(&error))?;
        let mut kept = 0;
        for index in 0..read {
            if let Some(byte) = self.pass(buffer[index])? {
                buffer[kept] = byte;
                kept += 1;
            }
        }
        Ok(kept)
    }
}

impl<S: WriteReady> WriteReady for FaultySerial<S> {
    fn write_ready(&mut self) -> Result<bool, ErrorKind> {
        self.part
            .write_ready()
            .map_err(|error| embedded_io::Error::kind(&error))
    }
}

impl<S: Write> Write for FaultySerial<S> {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, ErrorKind> {
        let Some(first) = bytes.first() else {
            return Ok(0);
        };
        if let Some(byte) = self.pass(*first)? {
            self.part
                .write(&[byte])
                .map_err(|error| embedded_io::Error::kind(&error))?;
        }
        Ok(1)
    }

    fn flush(&mut self) -> Result<(), ErrorKind> {
        self.part
            .flush()
            .map_err(|error| embedded_io::Error::kind(&error))
    }
}
