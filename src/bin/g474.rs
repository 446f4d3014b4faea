//! The `g474` image; everything is in the library.
#![no_std]
#![no_main]

#[cortex_m_rt::entry]
fn main() -> ! {
    courier_sensor::board::g474::main()
}
