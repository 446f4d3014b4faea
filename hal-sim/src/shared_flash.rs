//! Flash that a simulated board shares with those who look at it.

use crate::wire::flash::{Flash, FlashError, PAGE_BYTES};
use courier_sensor::update::layout::BANK_BYTES;
use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
use std::cell::RefCell;
use std::rc::Rc;

/// Pages of a bank.
pub const FLASH_PAGES: usize = BANK_BYTES as usize / PAGE_BYTES;

/// A bank of flash that outlives the board's restarts. Clones are the same flash.
#[derive(Clone, Debug)]
pub struct SharedFlash(pub Rc<RefCell<Flash>>);

impl SharedFlash {
    /// Erased.
    #[must_use]
    pub fn erased(seed: u64) -> Self {
        Self(Rc::new(RefCell::new(Flash::new(FLASH_PAGES, seed))))
    }
}

impl ErrorType for SharedFlash {
    type Error = FlashError;
}

impl ReadNorFlash for SharedFlash {
    const READ_SIZE: usize = Flash::READ_SIZE;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashError> {
        self.0.borrow_mut().read(offset, bytes)
    }

    fn capacity(&self) -> usize {
        self.0.borrow().capacity()
    }
}

impl NorFlash for SharedFlash {
    const WRITE_SIZE: usize = Flash::WRITE_SIZE;
    const ERASE_SIZE: usize = Flash::ERASE_SIZE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashError> {
        self.0.borrow_mut().erase(from, to)
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        self.0.borrow_mut().write(offset, bytes)
    }
}
