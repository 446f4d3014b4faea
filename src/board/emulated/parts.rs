//! SPI devices, pins, serial line and flash as embedded-hal parts: each operation is one question to the host.

use super::mailbox::{Mailbox, Refused};
use super::{ahead, clock};
use crate::emulation::{DATA_BYTES, Operation, Pin, TICK_HZ};
use core::sync::atomic::{AtomicBool, Ordering::Relaxed};
use embedded_hal::digital::{self, InputPin, OutputPin};
use embedded_hal::spi::{self, SpiDevice};
use embedded_io::{ErrorKind, Read, ReadReady, Write, WriteReady};
use embedded_storage::nor_flash::{self, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash};

impl digital::Error for Refused {
    fn kind(&self) -> digital::ErrorKind {
        digital::ErrorKind::Other
    }
}

impl spi::Error for Refused {
    fn kind(&self) -> spi::ErrorKind {
        spi::ErrorKind::Other
    }
}

impl NorFlashError for Refused {
    fn kind(&self) -> NorFlashErrorKind {
        NorFlashErrorKind::Other
    }
}

/// Longest transfer to a converter chip.
const TRANSFER_BYTES: usize = 64;

/// A converter chip's SPI device.
#[derive(Debug)]
pub struct Spi {
    /// Where to ask.
    pub mailbox: Mailbox,
    /// 0 or 1.
    pub chip: u32,
}

impl spi::ErrorType for Spi {
    type Error = Refused;
}

impl SpiDevice for Spi {
    fn transaction(&mut self, operations: &mut [spi::Operation<'_, u8>]) -> Result<(), Refused> {
        // A frame of samples: in place, at every instant.
        if let [spi::Operation::TransferInPlace(words)] = operations
            && ahead::take_transfer(self.chip, words)
        {
            return Ok(());
        }
        let mut bytes = [0; TRANSFER_BYTES];
        let mut at = 0;
        for operation in operations.iter() {
            let length = clocks(operation);
            let place = bytes.get_mut(at..at + length).ok_or(Refused)?;
            let written: &[u8] = match operation {
                spi::Operation::Write(write) | spi::Operation::Transfer(_, write) => write,
                spi::Operation::TransferInPlace(words) => words,
                _ => &[],
            };
            place
                .iter_mut()
                .zip(written)
                .for_each(|(place, byte)| *place = *byte);
            at += length;
        }
        let mut answer = [0; TRANSFER_BYTES];
        let answer = answer.get_mut(..at).ok_or(Refused)?;
        let question = bytes.get(..at).ok_or(Refused)?;
        self.mailbox
            .ask(Operation::Spi, self.chip, question, answer)?;
        let mut rest: &[u8] = answer;
        for operation in operations.iter_mut() {
            let (now, later) = rest.split_at_checked(clocks(operation)).ok_or(Refused)?;
            rest = later;
            let read: &mut [u8] = match operation {
                spi::Operation::Read(read) | spi::Operation::Transfer(read, _) => read,
                spi::Operation::TransferInPlace(words) => words,
                _ => &mut [],
            };
            read.iter_mut()
                .zip(now)
                .for_each(|(place, byte)| *place = *byte);
        }
        Ok(())
    }
}

fn clocks(operation: &spi::Operation<'_, u8>) -> usize {
    match operation {
        spi::Operation::Read(read) => read.len(),
        spi::Operation::Write(write) => write.len(),
        spi::Operation::Transfer(read, write) => read.len().max(write.len()),
        spi::Operation::TransferInPlace(words) => words.len(),
        spi::Operation::DelayNs(_) => 0,
    }
}

/// A line to or from the converters, or the LED.
#[derive(Debug)]
pub struct Line {
    /// Where to ask.
    pub mailbox: Mailbox,
    /// Which.
    pub pin: Pin,
}

impl Line {
    fn set(&mut self, level: u32) -> Result<(), Refused> {
        let argument = 2 * self.pin as u32 + level;
        self.mailbox
            .ask(Operation::SetPin, argument, &[], &mut [])
            .map(|_| ())
    }
}

impl digital::ErrorType for Line {
    type Error = Refused;
}

impl OutputPin for Line {
    fn set_low(&mut self) -> Result<(), Refused> {
        self.set(0)
    }

    fn set_high(&mut self) -> Result<(), Refused> {
        self.set(1)
    }
}

impl InputPin for Line {
    fn is_high(&mut self) -> Result<bool, Refused> {
        let level = self
            .mailbox
            .ask(Operation::GetPin, self.pin as u32, &[], &mut [])?;
        Ok(level != 0)
    }

    fn is_low(&mut self) -> Result<bool, Refused> {
        self.is_high().map(|high| !high)
    }
}

/// Whether the host had bytes for the serial line at the last conversion: what a receive interrupt is on the real board.
pub static BYTES_WAIT: AtomicBool = AtomicBool::new(true);

/// Bytes taken from the host at a time.
const SERIAL_BYTES: usize = 64;

/// The serial line to the motion controller.
#[derive(Debug)]
pub struct Serial {
    mailbox: Mailbox,
    received: heapless::Deque<u8, SERIAL_BYTES>,
}

impl Serial {
    /// Nothing received yet.
    pub const fn new(mailbox: Mailbox) -> Self {
        Self {
            mailbox,
            received: heapless::Deque::new(),
        }
    }

    fn fill(&mut self) -> Result<(), ErrorKind> {
        let mut bytes = [0; SERIAL_BYTES];
        let answer = self.mailbox.ask(Operation::SerialRead, 0, &[], &mut bytes);
        let count = answer.map_err(|Refused| ErrorKind::Other)? as usize;
        for byte in bytes.iter().take(count) {
            let _ = self.received.push_back(*byte); // was empty, and is as large
        }
        Ok(())
    }
}

impl embedded_io::ErrorType for Serial {
    type Error = ErrorKind;
}

impl ReadReady for Serial {
    fn read_ready(&mut self) -> Result<bool, ErrorKind> {
        if self.received.is_empty() && BYTES_WAIT.load(Relaxed) {
            self.fill()?;
        }
        Ok(!self.received.is_empty())
    }
}

impl Read for Serial {
    /// Never waits: with nothing received it is a time-out.
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize, ErrorKind> {
        if buffer.is_empty() {
            return Ok(0);
        }
        if !self.read_ready()? {
            return Err(ErrorKind::TimedOut);
        }
        let mut count = 0;
        for place in buffer {
            let Some(byte) = self.received.pop_front() else {
                break;
            };
            *place = byte;
            count += 1;
        }
        Ok(count)
    }
}

impl WriteReady for Serial {
    fn write_ready(&mut self) -> Result<bool, ErrorKind> {
        Ok(true)
    }
}

impl Write for Serial {
    fn write(&mut self, bytes: &[u8]) -> Result<usize, ErrorKind> {
        let bytes = bytes.get(..bytes.len().min(DATA_BYTES)).unwrap_or(bytes);
        let taken = self.mailbox.ask(Operation::SerialWrite, 0, bytes, &mut []);
        taken
            .map(|count| count as usize)
            .map_err(|Refused| ErrorKind::Other)
    }

    fn flush(&mut self) -> Result<(), ErrorKind> {
        Ok(())
    }
}

/// Erasing a page takes 22 ms, programming a double word 82 µs (STM32G474 data sheet, typical); interrupts are served
/// meanwhile, since code does not run from this bank.
const ERASE_TICKS: u32 = TICK_HZ / 1000 * 22;
const PROGRAM_TICKS: u32 = TICK_HZ / 1_000_000 * 82;

/// The flash that the calibration's slots are in; geometry of the G474's second bank.
#[derive(Debug)]
pub struct Flash {
    /// Where to ask.
    pub mailbox: Mailbox,
}

impl nor_flash::ErrorType for Flash {
    type Error = Refused;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Refused> {
        let mut at = offset;
        for part in bytes.chunks_mut(DATA_BYTES) {
            self.mailbox.ask(Operation::FlashRead, at, &[], part)?;
            at += part.len() as u32;
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        256 << 10
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = 8;
    const ERASE_SIZE: usize = 2048;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Refused> {
        let mut at = from;
        while at < to {
            self.mailbox
                .ask(Operation::FlashErase, at, &[], &mut [0; 0])?;
            clock::wait(ERASE_TICKS);
            at += Self::ERASE_SIZE as u32;
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Refused> {
        let mut at = offset;
        for part in bytes.chunks(DATA_BYTES) {
            self.mailbox.ask(Operation::FlashWrite, at, part, &mut [])?;
            clock::wait(PROGRAM_TICKS * (part.len() / Self::WRITE_SIZE) as u32);
            at += part.len() as u32;
        }
        Ok(())
    }
}
