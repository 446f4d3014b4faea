//! The image for the emulated board; everything is in the library.
#![no_std]
#![no_main]

#[cortex_m_rt::entry]
fn main() -> ! {
    courier_sensor::board::emulated::main()
}
