//! The flash controller's registers, for the firmware and for the first stage, each of which has a bank's memory of its own.
#![allow(unsafe_code)] // the banks are memory

use crate::drivers::g4_flash::{BankNumber, Controller};
use core::ptr::write_volatile;
use stm32_metapac::FLASH;
use stm32_metapac::flash::regs::{Acr, Cr, Sr};

/// A bank's memory.
pub trait Memory {
    /// Which bank it is.
    fn number(&self) -> BankNumber;
    /// Whether the supply is too low to write.
    fn supply_is_low(&self) -> bool;
    /// Address of an offset, at which it can be programmed.
    fn address_to_program(&mut self, offset: u32) -> u32;
    /// Reads from an offset; true if a double word's check bits were wrong.
    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> bool;
}

/// The controller, for one of the banks.
pub struct Registers<M>(pub M);

/// The option bytes' register.
pub fn options() -> u32 {
    FLASH.optr().read().0
}

impl<M: Memory> Controller for Registers<M> {
    fn number(&mut self) -> BankNumber {
        self.0.number()
    }

    fn status(&mut self) -> u32 {
        FLASH.sr().read().0
    }

    fn clear_status(&mut self, flags: u32) {
        FLASH.sr().write_value(Sr(flags));
    }

    fn control(&mut self) -> u32 {
        FLASH.cr().read().0
    }

    fn set_control(&mut self, bits: u32) {
        FLASH.cr().write_value(Cr(bits));
    }

    fn access(&mut self) -> u32 {
        FLASH.acr().read().0
    }

    fn set_access(&mut self, bits: u32) {
        FLASH.acr().write_value(Acr(bits));
    }

    fn options(&mut self) -> u32 {
        options()
    }

    fn key(&mut self, key: u32) {
        FLASH.keyr().write_value(key);
    }

    fn supply_is_low(&mut self) -> bool {
        self.0.supply_is_low()
    }

    fn program(&mut self, offset: u32, [low, high]: [u32; 2]) {
        let address = self.0.address_to_program(offset);
        // SAFETY: a double word within the bank, as the bank has checked; the controller is unlocked and waits for it.
        unsafe {
            write_volatile(address as *mut u32, low);
            write_volatile((address + 4) as *mut u32, high);
        }
    }

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> bool {
        self.0.read(offset, bytes)
    }
}
