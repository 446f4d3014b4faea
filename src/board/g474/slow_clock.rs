//! The slow oscillator, which the watchdog runs on, by the main clock: TIM16 captures every eighth of its edges. Two clocks that know
//! nothing of each other agree, or one of them is wrong.

use super::clocks::CLOCK_HZ;
use crate::selftest::captured_hz;
use stm32_metapac::timer::vals::CcmrInputCcs;
use stm32_metapac::{RCC, TIM16};

/// TI1SEL of TIM16: the slow oscillator (RM0440, TIM16_TISEL).
const SLOW_OSCILLATOR: u8 = 0b0110;
/// IC1PSC: a capture every eighth edge. At 29.5 kHz that is 46,100 cycles, within the counter's 16 bits.
const EVERY_EIGHTH: u8 = 0b11;
const PERIODS: u32 = 8;
/// Looks for a capture; each takes some ten cycles, so that this is several times eight periods.
const PATIENCE: u32 = 50_000;

/// Frequency of the slow oscillator, hertz; none if it does not run. The watchdog must have been started. Half a millisecond.
pub fn measure_hz() -> Option<u32> {
    RCC.apb2enr().modify(|w| w.set_tim16en(true));
    TIM16.tisel().write(|w| w.set_tisel(0, SLOW_OSCILLATOR));
    TIM16.ccmr_input(0).write(|w| {
        w.set_ccs(0, CcmrInputCcs::TI4); // IC1 on TI1
        w.set_icpsc(0, EVERY_EIGHTH);
    });
    TIM16.ccer().write(|w| w.set_cce(0, true));
    TIM16.cr1().write(|w| w.set_cen(true));
    let captures = capture().and_then(|first| Some([first, capture()?]));
    TIM16.cr1().write(|w| w.set_cen(false));
    captures.and_then(|captures| captured_hz(captures, PERIODS, CLOCK_HZ))
}

/// The next capture; reading it takes its flag back.
fn capture() -> Option<u16> {
    (0..PATIENCE)
        .any(|_| TIM16.sr().read().ccif(0))
        .then(|| TIM16.ccr(0).read().ccr())
}
