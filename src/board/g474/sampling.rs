//! The sampling instants: TIM3 makes CONVST's pulse, TIM2 counts the pulses, BUSY's falling edge is the interrupt.
//!
//! TIM8 counts BUSY's pulses, so that one that is missing is known, whatever the processor saw. BUSY lies on its channel 3, which can be
//! no clock; but channels 1, 2 and 3 together can, by exclusive or (TI1S), and the other two lie on no pin.
//!
//! The edge of CONVST comes from the timer alone: no software can move it. TIM2 tells how many there were, so that a missed
//! one is known. A converter that is silent makes no edge of BUSY; the background then calls the interrupt by hand.

use super::clocks::CLOCK_HZ;
use crate::drivers::converter::timing::{BUSY_BELOW_NS, CONVST_HIGH_NS};
use stm32_metapac::timer::vals::{CcmrInputCcs, Mms, Ocm, Sms, Ti1s, Ts};
use stm32_metapac::{EXTI, RCC, SYSCFG, TIM2, TIM3, TIM8};

/// EXTI line of BUSY (PC8), and port C's number in SYSCFG.
const BUSY_LINE: usize = 8;
const PORT_C: u8 = 2;
/// CONVST is high so long.
const PULSE_CYCLES: u16 = cycles(CONVST_HIGH_NS);

/// BUSY's pulse is over so long after its conversion's start: twice what it may take.
const SETTLED_CYCLES: u16 = cycles(2 * BUSY_BELOW_NS);
/// Looks at both counts until none falls into a pulse or over an instant: each takes some twenty cycles, a pulse 680 at most.
const LOOKS: u32 = 100;

const fn cycles(ns: u32) -> u16 {
    (CLOCK_HZ / 1_000_000 * ns / 1000) as u16
}

/// Number of the first instant: its pulse begins with the timer, before the first period that TIM2 counts.
pub const FIRST: u32 = 0;

/// Starts the timers and lets BUSY interrupt.
pub fn start(rate_hz: u32) {
    SYSCFG
        .exticr(BUSY_LINE / 4)
        .modify(|w| w.set_exti(BUSY_LINE % 4, PORT_C));
    EXTI.ftsr(0).modify(|w| w.set_line(BUSY_LINE, true));
    EXTI.imr(0).modify(|w| w.set_line(BUSY_LINE, true));
    RCC.apb1enr1().modify(|w| {
        w.set_tim2en(true);
        w.set_tim3en(true);
    });
    // TIM2 is clocked by TIM3's update, its internal trigger 2 (RM0440, table 253).
    TIM2.smcr().modify(|w| {
        w.set_ts(Ts::ITR2);
        w.set_sms(Sms::EXT_CLOCK_MODE);
    });
    TIM2.cr1().modify(|w| w.set_cen(true));
    count_answers();
    TIM3.arr()
        .write(|w| w.set_arr(u16::try_from(CLOCK_HZ / rate_hz - 1).unwrap_or(u16::MAX)));
    TIM3.ccr(0).write(|w| w.set_ccr(PULSE_CYCLES));
    TIM3.ccmr_output(0).modify(|w| w.set_ocm(0, Ocm::PWM_MODE1));
    TIM3.ccer().modify(|w| w.set_cce(0, true));
    TIM3.cr2().modify(|w| w.set_mms(Mms::UPDATE));
    TIM3.cr1().modify(|w| w.set_cen(true));
}

/// TIM8 is clocked by BUSY's falling edges (RM0440, 28.3: external clock mode 1, and the input's exclusive or).
fn count_answers() {
    RCC.apb2enr().modify(|w| w.set_tim8en(true));
    TIM8.cr2().modify(|w| w.set_ti1s(Ti1s::XOR));
    TIM8.ccmr_input(0)
        .modify(|w| w.set_ccs(0, CcmrInputCcs::TI4)); // IC1 on TI1
    TIM8.ccer().modify(|w| w.set_ccp(0, true));
    TIM8.smcr().modify(|w| {
        w.set_ts(Ts::TI1FP1);
        w.set_sms(Sms::EXT_CLOCK_MODE);
    });
    TIM8.cr1().modify(|w| w.set_cen(true));
}

/// Conversions that were started and pulses of BUSY so far, modulo 2^16; none if instants came at every look.
pub fn asked_and_answered() -> Option<[u16; 2]> {
    let look = |_| {
        let asked = instants();
        let is_settled = is_settled();
        let answered = TIM8.cnt().read().cnt();
        let conversions = asked.wrapping_sub(FIRST).wrapping_add(1) as u16;
        (is_settled && asked == instants()).then_some([conversions, answered])
    };
    (0..LOOKS).find_map(look)
}

/// Whether the newest instant's conversion is over, and BUSY with it.
#[inline(always)]
pub fn is_settled() -> bool {
    TIM3.cnt().read().cnt() >= SETTLED_CYCLES
}

/// Number of the newest sampling instant, from [`FIRST`], modulo 2^32.
#[inline(always)]
pub fn instants() -> u32 {
    TIM2.cnt().read()
}

/// Takes back the interrupt; false if BUSY did not ask for it.
#[inline(always)]
pub fn acknowledge() -> bool {
    let asked = EXTI.pr(0).read().line(BUSY_LINE);
    EXTI.pr(0).write(|w| w.set_line(BUSY_LINE, true));
    asked
}
