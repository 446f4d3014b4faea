//! A bank of the chip's flash: `hal-sim`'s, in this program or the host's.

use crate::host::Host;
use anyhow::{Result, ensure};
use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};
use hal_sim::board::SharedFlash;
use hal_sim::wire::flash::{Contents, FlashError, PAGE_BYTES, WORD_BYTES};
use link_host::chip::protocol::{Answer, FlashEnd, Question};
use std::cell::RefCell;
use std::rc::Rc;

/// What an erased byte reads as.
const ERASED: u8 = 0xFF;

/// Steps of `hal-sim`'s flash to an operation.
const STEPS: u64 = 8;

/// What is done to a bank.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operation {
    /// The page at this offset is erased.
    Erase(u32),
    /// The double word at this offset is programmed.
    Program(u32, [u8; WORD_BYTES]),
}

/// Operations in their order, with the index of the bank. Clones are the same.
pub type Log = Rc<RefCell<Vec<(usize, Operation)>>>;

/// The bank. Clones are the same. The host's is kept here as a copy, and every operation is the host's first.
#[derive(Clone, Debug)]
pub struct Bank {
    here: SharedFlash,
    host: Option<Host>,
    noted: Rc<RefCell<Option<(usize, Log)>>>,
}

impl Bank {
    /// A bank in this program.
    pub fn new(here: SharedFlash) -> Self {
        Self {
            here,
            host: None,
            noted: Rc::default(),
        }
    }

    /// The host's bank, as it is now.
    ///
    /// # Errors
    /// It is one of another size.
    pub fn of_host(host: Host) -> Result<Self> {
        let mut bank = Self {
            here: SharedFlash::erased(0),
            host: Some(host),
            noted: Rc::default(),
        };
        bank.power_up()?;
        Ok(bank)
    }

    /// The supply has come.
    ///
    /// # Errors
    /// The host's bank is one of another size.
    pub fn power_up(&mut self) -> Result<()> {
        self.here.0.borrow_mut().power_up();
        match &self.host {
            Some(host) => self.take_over(host.power_up()),
            None => Ok(()),
        }
    }

    /// The host has changed its bank by itself. Code that runs from it goes on as it was until the next reset.
    ///
    /// # Errors
    /// The host's bank is one of another size.
    pub fn look_again(&mut self) -> Result<()> {
        match &self.host {
            Some(host) => self.take_over(host.bank()),
            None => Ok(()),
        }
    }

    fn take_over(&self, contents: Contents) -> Result<()> {
        let mut here = self.here.0.borrow_mut();
        let wanted = here.bytes().len();
        let found = [
            contents.bytes.len(),
            contents.programmed.len(),
            contents.torn.len(),
        ];
        ensure!(
            found == [wanted, wanted / WORD_BYTES, wanted / WORD_BYTES],
            "found a flash of {} bytes, wanted a bank of {wanted}",
            found[0]
        );
        here.take_over(contents);
        Ok(())
    }

    /// From now on what is done to it is noted, under this index.
    pub fn note_in(&self, index: usize, log: &Log) {
        *self.noted.borrow_mut() = Some((index, log.clone()));
    }

    fn note(&self, operation: Operation) {
        if let Some((index, log)) = &*self.noted.borrow() {
            log.borrow_mut().push((*index, operation));
        }
    }

    /// Writes what a debug probe would: double words that are not as erased.
    pub fn load(&self, bytes: &[u8]) {
        let mut here = self.here.0.borrow_mut();
        let words = bytes.chunks(WORD_BYTES).zip((0..).step_by(WORD_BYTES));
        for (word, place) in words.filter(|(word, _)| word.iter().any(|byte| *byte != ERASED)) {
            here.force(place, word);
        }
    }

    /// All bytes, as they are.
    pub fn bytes(&self) -> Vec<u8> {
        self.here.0.borrow().bytes().to_vec()
    }

    /// Operations that it has carried out.
    pub fn operations(&self) -> u64 {
        self.here.0.borrow().steps() / STEPS
    }

    /// Offsets of the double words whose check bits are wrong.
    pub fn torn(&self) -> Vec<u32> {
        let here = self.here.0.borrow();
        let torn = here.torn().iter().zip((0..).step_by(WORD_BYTES));
        torn.filter_map(|(torn, offset)| torn.then_some(offset))
            .collect()
    }

    /// Erases the page at this offset.
    ///
    /// # Errors
    /// `hal-sim`'s.
    pub fn erase(&mut self, offset: u32) -> Result<(), FlashError> {
        self.note(Operation::Erase(offset));
        self.at_host(Question::Erase(offset))?;
        self.here.erase(offset, offset + PAGE_BYTES as u32)
    }

    /// Programs the double word at this offset.
    ///
    /// # Errors
    /// `hal-sim`'s.
    pub fn program(&mut self, offset: u32, data: [u8; WORD_BYTES]) -> Result<(), FlashError> {
        self.note(Operation::Program(offset, data));
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
