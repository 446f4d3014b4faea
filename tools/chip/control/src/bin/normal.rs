//! 80 MHz, which needs neither the boosted regulator nor a step of the bus's prescaler.
#![no_std]
#![no_main]

use embassy_stm32::rcc::PllMul;

#[cortex_m_rt::entry]
fn main() -> ! {
    control::run(PllMul::MUL40, false)
}
