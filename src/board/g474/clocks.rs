//! 170 MHz from the internal oscillator: 16 MHz / 4 * 85 / 2, voltage range 1 boosted (RM0440, 6.1.5 and 7.2.4).

use stm32_metapac::flash::vals::Latency;
use stm32_metapac::rcc::vals::{Hpre, Pllm, Plln, Pllr, Pllsrc, Sw};
use stm32_metapac::{FLASH, PWR, RCC};

/// Frequency of processor, buses and timers.
pub const CLOCK_HZ: u32 = 170_000_000;

/// PWR_CR5.R1MODE: zero boosts voltage range 1, which more than 150 MHz need (RM0440, 6.4.21; ST's stm32g474xx.h). stm32-metapac
/// 21 has this bit at place 0.
const R1MODE: u32 = 1 << 8;

/// Switches the clock over. To be called once, first of all.
pub fn start() {
    RCC.apb1enr1().modify(|w| w.set_pwren(true));
    RCC.apb2enr().modify(|w| w.set_syscfgen(true));
    PWR.cr5().modify(|w| w.0 &= !R1MODE);
    FLASH.acr().modify(|w| {
        w.set_latency(Latency::WS4);
        w.set_prften(true);
        w.set_icen(true);
        w.set_dcen(true);
    });
    while FLASH.acr().read().latency() != Latency::WS4 {}
    RCC.cr().modify(|w| w.set_hsion(true));
    while !RCC.cr().read().hsirdy() {}
    RCC.pllcfgr().write(|w| {
        w.set_pllsrc(Pllsrc::HSI);
        w.set_pllm(Pllm::DIV4);
        w.set_plln(Plln::MUL85);
        w.set_pllr(Pllr::DIV2);
        w.set_pllren(true);
    });
    RCC.cr().modify(|w| w.set_pllon(true));
    while !RCC.cr().read().pllrdy() {}
    // Above 80 MHz the bus clock goes over half its speed for 1 us.
    RCC.cfgr().modify(|w| w.set_hpre(Hpre::DIV2));
    RCC.cfgr().modify(|w| w.set_sw(Sw::PLL1_R));
    while RCC.cfgr().read().sws() != Sw::PLL1_R {}
    cortex_m::asm::delay(CLOCK_HZ / 1_000_000);
    RCC.cfgr().modify(|w| w.set_hpre(Hpre::DIV1));
}

/// Waits by counting cycles.
#[derive(Debug)]
pub struct Delay;

impl embedded_hal::delay::DelayNs for Delay {
    fn delay_ns(&mut self, ns: u32) {
        // 4.3 s at most: 0.73e9 cycles.
        const A_MICROSECOND: u32 = CLOCK_HZ / 1_000_000;
        let cycles = ns / 1000 * A_MICROSECOND + (ns % 1000 * A_MICROSECOND).div_ceil(1000);
        cortex_m::asm::delay(cycles);
    }
}
