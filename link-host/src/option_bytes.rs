//! The STM32G4's option bytes through a debug probe: read, and set as the firmware needs them.
//!
//! Order of steps and keys as RM0440, 5.4.2. The processor must be halted: the firmware may be writing its flash.

use crate::memory::TargetMemory;
use anyhow::{Result, ensure};

/// Registers of the flash controller.
const KEYS: u32 = 0x4002_2008;
const OPTION_KEYS: u32 = 0x4002_200C;
const STATUS: u32 = 0x4002_2010;
const CONTROL: u32 = 0x4002_2014;
const OPTIONS: u32 = 0x4002_2020;

/// Keys that unlock the control register, then the option bytes.
const UNLOCK: [u32; 2] = [0x4567_0123, 0xCDEF_89AB];
const UNLOCK_OPTIONS: [u32; 2] = [0x0819_2A3B, 0x4C5D_6E7F];
/// Bits of the status register: an operation is under way; all error flags.
const BUSY: u32 = 1 << 16;
const ERRORS: u32 = 0xC3FA;
/// Bits of the control register.
const START_OPTIONS: u32 = 1 << 17;
const LAUNCH: u32 = 1 << 27;
const OPTIONS_LOCKED: u32 = 1 << 30;
const LOCKED: u32 = 1 << 31;
/// Read protection's byte when there is none (level 0). Any other is left alone: a wrong value here can close the chip for good.
const OPEN: u32 = 0xAA;
/// Looks at the busy bit: programming takes some 25 ms, a look through a probe 0.1 ms or more.
const PATIENCE: u32 = 10_000;

/// The option register, FLASH_OPTR.
///
/// # Errors
/// The chip cannot be reached.
pub fn read(memory: &mut impl TargetMemory) -> Result<u32> {
    memory.read_word(OPTIONS)
}

/// Writes the option bytes; they count from the next [`launch`].
///
/// # Errors
/// The chip cannot be reached, is protected against reading, or does not take them.
pub fn program(memory: &mut impl TargetMemory, options: u32) -> Result<()> {
    for (whose, register) in [("the chip's", read(memory)?), ("the new", options)] {
        ensure!(
            register & 0xFF == OPEN,
            "option bytes: found {whose} read protection at {:#04x}, wanted level 0 ({OPEN:#04x}): nothing is set on a protected chip",
            register & 0xFF
        );
    }
    idle(memory)?;
    memory.write_word(STATUS, ERRORS)?;
    // A key that is not asked for counts as a wrong one, which locks until a reset.
    for (bit, register, keys) in [
        (LOCKED, KEYS, UNLOCK),
        (OPTIONS_LOCKED, OPTION_KEYS, UNLOCK_OPTIONS),
    ] {
        if memory.read_word(CONTROL)? & bit != 0 {
            keys.iter()
                .try_for_each(|key| memory.write_word(register, *key))?;
        }
    }
    let control = memory.read_word(CONTROL)?;
    ensure!(
        control & (LOCKED | OPTIONS_LOCKED) == 0,
        "option bytes: found them locked (FLASH_CR {control:#010x}), wanted a chip after a reset"
    );
    memory.write_word(OPTIONS, options)?;
    memory.write_word(CONTROL, control | START_OPTIONS)?;
    idle(memory)?;
    let errors = memory.read_word(STATUS)? & ERRORS;
    ensure!(
        errors == 0,
        "option bytes: found FLASH_SR {errors:#x}, wanted no error"
    );
    Ok(())
}

/// Lets the chip restart with the option bytes as programmed. The reset may end the connection in the middle of this.
pub fn launch(memory: &mut impl TargetMemory) {
    let _ = memory.write_word(CONTROL, LAUNCH);
}

fn idle(memory: &mut impl TargetMemory) -> Result<()> {
    for _ in 0..PATIENCE {
        if memory.read_word(STATUS)? & BUSY == 0 {
            return Ok(());
        }
    }
    anyhow::bail!("option bytes: found the flash busy, wanted it idle")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The controller as the manual has it, busy for some looks after a start.
    struct Controller {
        options: u32,
        next: u32,
        control: u32,
        keys: [usize; 2],
        busy: u32,
        programmed: u32,
        error: u32,
    }

    impl Controller {
        fn new(options: u32) -> Self {
            Self {
                options,
                next: options,
                control: LOCKED | OPTIONS_LOCKED,
                keys: [0; 2],
                busy: 3,
                programmed: 0,
                error: 0,
            }
        }

        fn key(&mut self, which: usize, keys: [u32; 2], bit: u32, word: u32) {
            assert_ne!(self.control & bit, 0, "a key that is not asked for");
            assert_eq!(word, keys[self.keys[which]], "a wrong key");
            self.keys[which] += 1;
            if self.keys[which] == 2 {
                self.control &= !bit;
            }
        }
    }

    impl TargetMemory for Controller {
        fn read(&mut self, _: u32, _: &mut [u8]) -> Result<()> {
            unreachable!("registers are words")
        }

        fn write(&mut self, _: u32, _: &[u8]) -> Result<()> {
            unreachable!("registers are words")
        }

        fn read_word(&mut self, address: u32) -> Result<u32> {
            Ok(match address {
                OPTIONS => self.next,
                CONTROL => self.control,
                STATUS if self.busy > 0 => {
                    self.busy -= 1;
                    BUSY
                }
                STATUS => self.error,
                other => panic!("{other:#x} is read"),
            })
        }

        fn write_word(&mut self, address: u32, word: u32) -> Result<()> {
            match address {
                KEYS => self.key(0, UNLOCK, LOCKED, word),
                OPTION_KEYS => {
                    assert_eq!(self.control & LOCKED, 0, "the control register first");
                    self.key(1, UNLOCK_OPTIONS, OPTIONS_LOCKED, word);
                }
                STATUS => assert_eq!(word, ERRORS),
                OPTIONS => {
                    assert_eq!(self.control & OPTIONS_LOCKED, 0, "unlocked first");
                    self.next = word;
                }
                CONTROL if word & START_OPTIONS != 0 => {
                    assert_eq!(self.busy, 0);
                    (self.programmed, self.busy) = (self.next, 3);
                }
                CONTROL if word & LAUNCH != 0 => {
                    assert_eq!(self.busy, 0);
                    self.options = self.programmed;
                    anyhow::bail!("the chip is in reset");
                }
                other => panic!("{other:#x} is written"),
            }
            Ok(())
        }
    }

    const FACTORY: u32 = 0xFFEF_F8AA;
    const WANTED: u32 = FACTORY & !(1 << 26) | 4 << 8;

    #[test]
    fn option_bytes_are_set_in_the_manuals_order_and_count_after_the_launch() {
        let mut chip = Controller::new(FACTORY);
        assert_eq!(read(&mut chip).unwrap(), FACTORY);
        program(&mut chip, WANTED).unwrap();
        assert_eq!((chip.programmed, chip.options), (WANTED, FACTORY));
        launch(&mut chip);
        assert_eq!(chip.options, WANTED);
        // Firmware that was halted while its flash was unlocked.
        let mut chip = Controller::new(FACTORY);
        chip.control &= !LOCKED;
        program(&mut chip, WANTED).unwrap();
        assert_eq!(chip.programmed, WANTED);
    }

    #[test]
    fn a_protected_chip_an_error_and_a_flash_that_stays_busy_are_refused() {
        let closed = FACTORY & !0xFF | 0xBB;
        for (chip, options) in [
            (closed, closed),
            (closed, WANTED),
            (FACTORY, closed),
            (FACTORY, 0),
        ] {
            let mut chip = Controller::new(chip);
            let told = program(&mut chip, options).unwrap_err().to_string();
            assert!(told.contains("read protection"), "{told}");
            assert_eq!(chip.keys, [0; 2], "nothing was touched");
        }
        let mut chip = Controller::new(FACTORY);
        chip.error = 1 << 15;
        let told = program(&mut chip, WANTED).unwrap_err().to_string();
        assert!(told.contains("FLASH_SR 0x8000"), "{told}");
        let mut chip = Controller::new(FACTORY);
        chip.busy = u32::MAX;
        assert!(
            program(&mut chip, WANTED)
                .unwrap_err()
                .to_string()
                .contains("busy")
        );
    }
}
