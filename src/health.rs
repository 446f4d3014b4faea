//! Judges what a board has found out about itself: what is not as it should be, and what to do about it. Pure; for hosts.
//!
//! The board reports values ([`Health`]) and judges none of them, so that a limit can change without a new image.

use crate::drivers::g4_flash::options;
use crate::link::message::{ConverterFault, ConverterTest, Health, MemoryTest};
use heapless::Vec;

/// Frequency of the slow oscillator, hertz: 29.5 to 34 kHz over temperature and supply (data sheet DS12288, LSI characteristics).
pub const SLOW_CLOCK_HZ: [u32; 2] = [29_500, 34_000];
/// Most troubles that there can be: one of each kind, and one of each option.
pub const MOST: usize = 9;

/// Something that is not as it should be; its text says what was found and what was wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Trouble {
    /// The stored calibration was left alone.
    #[error(
        "safe mode: {0} starts in a row were caused by faults, so no stored calibration is in force"
    )]
    SafeMode(u8),
    /// The converters' self-test.
    #[error("converters: their self-test at the start found that {0}")]
    Converters(ConverterFault),
    /// Memory.
    #[error("memory: the word at {0:#010x} does not keep what is written")]
    Memory(u32),
    /// The chip's option bytes.
    #[error("option bytes: {0}")]
    Options(OptionFault),
    /// The line that tells of a conversion's end.
    #[error("BUSY: conversions that were started less its pulses: found {0}, wanted 0")]
    Pulses(i32),
    /// Clocks.
    #[error(
        "clock: the slow oscillator has {0} Hz by the main clock, wanted {low} to {high}",
        low = SLOW_CLOCK_HZ[0],
        high = SLOW_CLOCK_HZ[1]
    )]
    Clock(u32),
}

/// An option that is not as the firmware needs it (RM0440, 5.4.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum OptionFault {
    /// One bank: an erase could take the code.
    #[error("found DBANK=0, wanted DBANK=1")]
    OneBank,
    /// The chip starts from the bank that holds the calibrations.
    #[error("found BFB2=1, wanted BFB2=0")]
    OtherBank,
    /// A pin decides whether the firmware starts.
    #[error("found nSWBOOT0={software} nBOOT0={value}, wanted nSWBOOT0=0 nBOOT0=1")]
    BootPin {
        /// nSWBOOT0.
        software: u8,
        /// nBOOT0.
        value: u8,
    },
    /// The chip works on while the supply is too low for the converters.
    #[error("found BOR_LEV={0}, wanted BOR_LEV=4")]
    BrownOut(u8),
}

impl Trouble {
    /// What to do.
    pub const fn remedy(self) -> &'static str {
        match self {
            Self::SafeMode(_) => {
                "`courier log` and the line `last fault` tell what happened; `courier rollback`, `courier import` or `courier calibrate` replaces what is stored, `courier reset` leaves safe mode"
            }
            Self::Converters(_) => {
                "check the converters' supply, RESET, CONVST, BUSY and the bus, then `courier reset`, which tests them again"
            }
            Self::Memory(_) => "the chip is damaged: replace the board",
            Self::Options(_) => "`cargo xtask option-bytes` sets them",
            Self::Pulses(_) => {
                "check the lines CONVST and BUSY and the first converter's supply: a conversion whose pulse is missing is read late or not at all; a converter that is set anew loses some"
            }
            Self::Clock(_) => {
                "one of the chip's two clocks is wrong, and with it rates and times: replace the board"
            }
        }
    }
}

/// Everything that is not as it should be, the most urgent first.
pub fn troubles(health: &Health) -> Vec<Trouble, MOST> {
    let converters = match health.converters {
        ConverterTest::Failed(fault) => Some(Trouble::Converters(fault)),
        ConverterTest::Passed | ConverterTest::NotRun => None,
    };
    let memory = match health.memory {
        MemoryTest::Failed { address } => Some(Trouble::Memory(address)),
        MemoryTest::Passed | MemoryTest::NotRun => None,
    };
    let safe_mode = health.safe_mode;
    let safe_mode = safe_mode.then_some(Trouble::SafeMode(health.faults_in_a_row));
    let [low, high] = SLOW_CLOCK_HZ;
    let clock = health.slow_clock_hz.filter(|hz| !(low..=high).contains(hz));
    let pulses = health.unanswered.filter(|pulses| *pulses != 0);
    let options = health.option_bytes.map(option_faults).unwrap_or_default();
    [safe_mode, converters, memory]
        .into_iter()
        .chain(
            options
                .into_iter()
                .map(|fault| Some(Trouble::Options(fault))),
        )
        .chain([pulses.map(Trouble::Pulses), clock.map(Trouble::Clock)])
        .flatten()
        .collect()
}

/// What differs in an option register (FLASH_OPTR) from what the firmware needs.
pub fn option_faults(register: u32) -> Vec<OptionFault, 4> {
    let bit = |mask: u32| u8::from(register & mask != 0);
    let (software, value) = (bit(options::BOOT0_BY_PIN), bit(options::BOOT0_VALUE));
    let level = (register >> options::BROWN_OUT_SHIFT & 7) as u8;
    [
        (bit(options::DUAL_BANK) == 0).then_some(OptionFault::OneBank),
        (bit(options::BOOT_BANK_2) == 1).then_some(OptionFault::OtherBank),
        ((software, value) != (0, 1)).then_some(OptionFault::BootPin { software, value }),
        (level != options::BROWN_OUT_LEVEL).then_some(OptionFault::BrownOut(level)),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// An option register as the firmware needs it; every other bit as it was.
pub const fn wanted_options(register: u32) -> u32 {
    let cleared = options::BOOT_BANK_2 | options::BOOT0_BY_PIN | 7 << options::BROWN_OUT_SHIFT;
    let level = (options::BROWN_OUT_LEVEL as u32) << options::BROWN_OUT_SHIFT;
    register & !cleared | options::DUAL_BANK | options::BOOT0_VALUE | level
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::string::ToString;

    /// As the factory delivers the chip (RM0440, 5.7.8).
    const FACTORY: u32 = 0xFFEF_F8AA;

    #[test]
    fn each_option_is_named_and_set() {
        let good = wanted_options(FACTORY);
        assert_eq!(option_faults(good), []);
        assert_eq!(wanted_options(good), good);
        let pin = OptionFault::BootPin {
            software: 1,
            value: 1,
        };
        assert_eq!(option_faults(FACTORY), [pin, OptionFault::BrownOut(0)]);
        let changed = [
            (options::DUAL_BANK, "DBANK=0"),
            (options::BOOT_BANK_2, "BFB2=1"),
            (options::BOOT0_BY_PIN, "nSWBOOT0=1"),
            (options::BOOT0_VALUE, "nBOOT0=0"),
            (1 << options::BROWN_OUT_SHIFT, "BOR_LEV=5"),
        ];
        for (bit, wanted) in changed {
            let faults = option_faults(good ^ bit);
            assert_eq!(faults.len(), 1, "{faults:?}");
            assert!(faults[0].to_string().contains(wanted), "{}", faults[0]);
            assert_eq!(wanted_options(good ^ bit), good);
        }
        // Read protection and the watchdog's options are nobody's business here.
        assert_eq!(wanted_options(FACTORY) ^ FACTORY, 1 << 26 | 4 << 8);
    }

    #[test]
    fn a_healthy_board_has_no_trouble_and_each_fault_is_one() {
        let healthy = Health {
            converters: ConverterTest::Passed,
            memory: MemoryTest::Passed,
            option_bytes: Some(wanted_options(FACTORY)),
            slow_clock_hz: Some(32_000),
            unanswered: Some(0),
            faults_in_a_row: 2,
            safe_mode: false,
        };
        assert_eq!(troubles(&healthy), []);
        assert_eq!(
            troubles(&Health::default()),
            [],
            "what is not known is none"
        );
        let failed = ConverterTest::Failed(ConverterFault::BusyStuck);
        let faults = [
            Health {
                converters: failed,
                ..healthy
            },
            Health {
                memory: MemoryTest::Failed { address: 4 },
                ..healthy
            },
            Health {
                option_bytes: Some(FACTORY ^ 1 << 26),
                ..healthy
            },
            Health {
                unanswered: Some(1),
                ..healthy
            },
            Health {
                unanswered: Some(-1),
                ..healthy
            },
            Health {
                slow_clock_hz: Some(29_499),
                ..healthy
            },
            Health {
                slow_clock_hz: Some(34_001),
                ..healthy
            },
            Health {
                safe_mode: true,
                ..healthy
            },
        ];
        for fault in faults {
            let found = troubles(&fault);
            assert_eq!(found.len(), 1, "{fault:?}: {found:?}");
            assert!(!found[0].remedy().is_empty());
        }
        for hz in SLOW_CLOCK_HZ {
            let fine = Health {
                slow_clock_hz: Some(hz),
                ..healthy
            };
            assert_eq!(troubles(&fine), []);
        }
    }

    #[test]
    fn there_is_room_for_every_trouble_at_once() {
        let all = Health {
            converters: ConverterTest::Failed(ConverterFault::Chip(1)),
            memory: MemoryTest::Failed { address: 0 },
            option_bytes: Some(options::BOOT_BANK_2),
            slow_clock_hz: Some(0),
            unanswered: Some(7),
            faults_in_a_row: 3,
            safe_mode: true,
        };
        assert_eq!(troubles(&all).len(), MOST);
    }
}
