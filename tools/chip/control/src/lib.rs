//! Somebody else's drivers on the modelled chip: embassy sets the clock, drives CONVST's pin by a timer at 20 kHz, and erases and programs
//! two double words of the flash's second bank.
//!
//! The check `control` of the chip's model looks at what comes of it: so the model does not merely share our reading of the manual. Each
//! image in `src/bin` is another clock.
#![no_std]

use embassy_stm32::Config;
use embassy_stm32::flash::Flash;
use embassy_stm32::gpio::{Level, Output, OutputType, Speed};
use embassy_stm32::rcc::{Pll, PllMul, PllPreDiv, PllRDiv, PllSource, Sysclk};
use embassy_stm32::time::Hertz;
use embassy_stm32::timer::low_level::CountingMode;
use embassy_stm32::timer::simple_pwm::{PwmPin, SimplePwm};
use panic_halt as _;

/// From the flash's start: bank 2.
const BANK_2: u32 = 256 << 10;
const PAGE_BYTES: u32 = 2048;
/// What the check finds there.
const PATTERN: [u8; 16] = *b"control control.";

/// Runs at 2 MHz times `multiplier`, from the internal oscillator's 16 MHz; `boost`: with the regulator that more than 150 MHz need.
pub fn run(multiplier: PllMul, boost: bool) -> ! {
    let mut config = Config::default();
    config.rcc.pll = Some(Pll {
        source: PllSource::HSI,
        prediv: PllPreDiv::DIV4,
        mul: multiplier,
        divp: None,
        divq: None,
        divr: Some(PllRDiv::DIV2),
    });
    config.rcc.sys = Sysclk::PLL1_R;
    config.rcc.boost = boost;
    config.rcc.hsi48 = None;
    let chip = embassy_stm32::init(config);
    let pulse = PwmPin::new(chip.PC6, OutputType::PushPull);
    let mut timer = SimplePwm::new(
        chip.TIM3,
        Some(pulse),
        None,
        None,
        None,
        Hertz(20_000),
        CountingMode::EdgeAlignedUp,
    );
    let mut convst = timer.ch1();
    convst.set_duty_cycle_fraction(1, 100);
    convst.enable();
    let mut lamp = Output::new(chip.PB2, Level::Low, Speed::Low);
    let mut flash = Flash::new_blocking(chip.FLASH);
    let stored = flash
        .blocking_erase(BANK_2, BANK_2 + PAGE_BYTES)
        .and_then(|()| flash.blocking_write(BANK_2, &PATTERN));
    if stored.is_ok() {
        lamp.set_high();
    }
    loop {
        cortex_m::asm::nop();
    }
}
