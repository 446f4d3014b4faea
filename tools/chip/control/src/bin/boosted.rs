//! 170 MHz, which needs the boosted regulator and a step of the bus's prescaler.
#![no_std]
#![no_main]

use embassy_stm32::rcc::PllMul;

#[cortex_m_rt::entry]
fn main() -> ! {
    control::run(PllMul::MUL85, true)
}
