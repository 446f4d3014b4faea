//! Bank 2 of the chip's flash: `hal-sim`'s, in this program or the host's.

use crate::host::Host;
use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};
use hal_sim::board::SharedFlash;
use hal_sim::wire::flash::{FlashError, PAGE_BYTES, WORD_BYTES};
use link_host::chip::protocol::{Answer, FlashEnd, Question};

/// The bank. Clones are the same. The host's is kept here as a copy, and every operation is the host's first.
#[derive(Clone, Debug)]
pub struct Bank {
    here: SharedFlash,
    host: Option<Host>,
}

impl Bank {
    /// A bank in this program.
    pub fn new(here: SharedFlash) -> Self {
        Self { here, host: None }
    }

    /// The host's bank, as it is now.
    pub fn of_host(host: Host) -> Self {
        let mut bank = Self {
            here: SharedFlash::erased(0),
            host: Some(host),
        };
        bank.power_up();
        bank
    }

    /// The supply has come.
    pub fn power_up(&mut self) {
        let mut here = self.here.0.borrow_mut();
        here.power_up();
        if let Some(host) = &self.host {
            here.take_over(host.bank());
        }
    }

    /// Erases the page at this offset.
    ///
    /// # Errors
    /// `hal-sim`'s.
    pub fn erase(&mut self, offset: u32) -> Result<(), FlashError> {
        self.at_host(Question::Erase(offset))?;
        self.here.erase(offset, offset + PAGE_BYTES as u32)
    }

    /// Programs the double word at this offset.
    ///
    /// # Errors
    /// `hal-sim`'s.
    pub fn program(&mut self, offset: u32, data: [u8; WORD_BYTES]) -> Result<(), FlashError> {
        self.at_host(Question::Program(offset, data))?;
        self.here.write(offset, &data)
    }

    fn at_host(&self, question: Question) -> Result<(), FlashError> {
        let Some(host) = &self.host else {
            return Ok(());
        };
        match host.ask(question) {
            Answer::Flash(FlashEnd::Well) => Ok(()),
            Answer::Flash(FlashEnd::Off) => Err(FlashError::Off),
            Answer::Flash(FlashEnd::WrittenTwice) => Err(FlashError::WrittenTwice),
            _ => Err(FlashError::Failed),
        }
    }

    /// Reads; true if a double word's check bits are wrong: it reads as it is then.
    pub fn read(&mut self, offset: u32, bytes: &mut [u8]) -> bool {
        let mut bank = self.here.0.borrow_mut();
        let torn = bank.read(offset, bytes) == Err(FlashError::Uncorrectable);
        if torn {
            bytes.copy_from_slice(&bank.bytes()[offset as usize..][..bytes.len()]);
        }
        torn
    }
}
