//! The independent watchdog of the STM32G4, which the first stage starts and the firmware feeds.

use stm32_metapac::iwdg::vals::{Key, Pr};
use stm32_metapac::{DBGMCU, IWDG};

/// Starts it; it resets the chip unless it is fed within so long. It cannot be stopped again, but stands still while a debugger halts the
/// processor. Its clock over its prescaler is 32 kHz / 32, so a tick is 1 ms.
pub fn start(ticks_ms: u16) {
    DBGMCU.apb1lfzr().modify(|w| w.set_iwdg(true));
    IWDG.kr().write(|w| w.set_key(Key::START));
    IWDG.kr().write(|w| w.set_key(Key::ENABLE));
    IWDG.pr().write(|w| w.set_pr(Pr::DIVIDE_BY32));
    IWDG.rlr().write(|w| w.set_rl(ticks_ms));
    feed();
}

/// Feeds it.
pub fn feed() {
    IWDG.kr().write(|w| w.set_key(Key::RESET));
}
