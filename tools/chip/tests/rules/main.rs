//! Each rule is tripped by what it forbids, and by nothing that keeps it: a file a peripheral, as in `src/peripheral`.
//!
//! A test of a rule stands in a module with the rule's name: `cargo xtask chip` reads the tests' names, and fails if a rule has none.

/// Tests, each of a fault that trips the rule whose module it stands in.
macro_rules! trips {
    ($($rule:ident { $($name:ident: $fault:expr;)+ })+) => {
        $(mod $rule {
            #[allow(unused_imports)] // some faults need nothing but the chip
            use super::*;
            $(#[test]
            fn $name() {
                crate::bench::trip(stringify!($rule), $fault);
            })+
        })+
    };
}

/// Address of a register.
macro_rules! at {
    ($($register:tt)+) => { (stm32_metapac::$($register)+.as_ptr() as usize) as u32 };
}

mod access;
mod adc;
mod bench;
mod check_sum;
mod clock;
mod dma;
mod flash;
mod option_bytes;
mod pins;
mod processor;
mod spi;
mod steps;
mod supervision;
mod swap;
