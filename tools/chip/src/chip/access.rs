//! Reads and writes by the processor: what every access must be, and the unit that it goes to.

use super::Chip;
use crate::peripheral::{Access, Unit, adc};
use crate::registers::{self, MAP, Register};
use crate::rule::Rule;

impl Chip {
    /// What every access must be: to a register that there is, with its clock on.
    fn look_up(&mut self, address: u32) -> Option<(Register, Unit)> {
        let Some(register) = MAP.find(address).copied() else {
            let detail = format!("{address:#010x}: no register of the chip's tables");
            self.findings.add(Rule::Unmodelled, self.now, detail);
            return None;
        };
        let Some(unit) = register.unit else {
            let detail = format!(
                "{}.{}: not in the model",
                register.peripheral, register.name
            );
            self.findings.add(Rule::Unmodelled, self.now, detail);
            return None;
        };
        if let Some((enable, bit)) = register.clock
            && !self.rcc.enabled(enable, bit)
        {
            let detail = format!("{}.{}", register.peripheral, register.name);
            self.findings.add(Rule::PeripheralClock, self.now, detail);
            return None;
        }
        Some((register, unit))
    }

    /// A read by the processor, of `width` bytes.
    pub fn read(&mut self, address: u32, width: usize) -> u32 {
        let Some((register, unit)) = self.look_up(address & !3) else {
            return 0;
        };
        self.changed |= has_effects(&register, unit);
        let value = self.with(|chip, access| match unit {
            Unit::Adc12Common => chip.adc1.common.0,
            _ => chip.unit(unit).read(&register, access),
        });
        if is_data(&register) {
            self.settle();
        }
        match width {
            4 => value,
            _ => value >> (8 * (address & 3)) & ((1u64 << (8 * width)) - 1) as u32,
        }
    }

    /// True if a read since the last call may have changed anything.
    pub fn take_changed(&mut self) -> bool {
        std::mem::take(&mut self.changed)
    }

    /// A write by the processor, of `width` bytes.
    pub fn write(&mut self, address: u32, width: usize, value: u32) {
        let Some((register, unit)) = self.look_up(address & !3) else {
            return;
        };
        self.with(|chip, access| {
            let name = || format!("{}.{}", register.peripheral, register.name);
            if !register.writable {
                return access.broken(Rule::ReadOnly, name());
            }
            if !is_data(&register) {
                // 16-bit registers of a timer may be written as such (RM0440, 30.5).
                let halves = width == 2 && matches!(unit, Unit::Tim2 | Unit::Tim3);
                if width != 4 && !halves {
                    access.broken(Rule::AccessWidth, format!("{}: {width} bytes", name()));
                }
                let before = match unit {
                    Unit::Adc12Common => chip.adc1.common.0,
                    _ => chip.unit(unit).peek(&register),
                };
                let changed = (before ^ value) & !register.bits;
                if changed != 0 {
                    access.broken(Rule::ReservedBit, format!("{}: bits {changed:#x}", name()));
                }
            } else if matches!(unit, Unit::Spi(_)) && width != 1 {
                let detail = format!("{}.dr: two bytes in one write", register.peripheral);
                access.broken(Rule::AccessWidth, detail);
            }
            match unit {
                Unit::Adc12Common => adc::write_common(&mut chip.adc1, &register, value, access),
                Unit::Crc if is_data(&register) => chip.crc.write_data(value, width, access),
                _ => chip.unit(unit).write(&register, value, access),
            }
            chip.watch_clocks(unit, access);
            chip.watch_banks(access);
            chip.transfers.watch(access);
        });
        if unit == Unit::Rcc && register.name.contains("rstr") {
            registers::set_back(register.name, value)
                .into_iter()
                .for_each(|unit| self.set_back(unit));
            self.with(Self::watch_banks);
        }
        // The unit for check values starts nothing and moves no line, and is written tens of thousands of times at each start.
        if unit != Unit::Crc {
            self.settle();
        }
    }

    /// Clock, regulator and flash must fit one another after each change of one of them.
    fn watch_clocks(&mut self, unit: Unit, access: &mut Access) {
        self.rcc.watchdog_runs = self.iwdg.runs();
        self.tim16.oscillates = self.iwdg.runs();
        if unit == Unit::Pwr {
            let level = self.flash.options().bor_lev();
            self.pwr.check_warning(level, access);
        }
        if !matches!(unit, Unit::Rcc | Unit::Pwr | Unit::Flash) {
            return;
        }
        access.clocks = self.rcc.clocks();
        let hz = access.clocks.hclk_hz;
        let (fastest_hz, a_state_hz) = self.pwr.limits_hz();
        if hz > fastest_hz {
            let detail = format!("{hz} Hz, the regulator's range allows {fastest_hz} Hz");
            access.broken(Rule::VoltageRange, detail);
        }
        let states = u32::from(self.flash.acr().latency().to_bits());
        if hz > (states + 1) * a_state_hz {
            let detail = format!("{states} wait states at {hz} Hz");
            access.broken(Rule::FlashLatency, detail);
        }
    }

    /// The banks change places where the system configuration says so.
    fn watch_banks(&mut self, access: &mut Access) {
        let swapped = self.syscfg.banks_swapped();
        if swapped == self.flash.swapped() {
            return;
        }
        if FLASH_PLACES
            .iter()
            .any(|place| place.contains(&self.running_at))
        {
            let detail = format!(
                "the banks change places under the code at {:#010x}",
                self.running_at
            );
            access.broken(Rule::BankSwap, detail);
        }
        self.flash.swap(access);
        self.remapped = true;
    }

    /// True once after the banks have changed places.
    pub fn take_remapped(&mut self) -> bool {
        std::mem::take(&mut self.remapped)
    }

    /// A read of the bank that no code runs from, and how long it has to wait.
    pub fn read_far(&mut self, offset: u32, width: usize) -> u32 {
        // The bank answers when it is done (RM0440, 5.3.4).
        self.note_read_while_written();
        let until = self.flash.busy_until();
        if until > self.now {
            self.advance_to(until);
        }
        let mut bytes = [0; 4];
        self.flash.read_far(offset, &mut bytes[..width]);
        u32::from_le_bytes(bytes)
    }

    /// Breaks a rule if the other bank is erased or programmed, and is read now.
    pub fn note_read_while_written(&mut self) {
        self.with(|chip, access| chip.flash.note_read_while_written(access));
    }

    /// A store into it.
    pub fn write_far(&mut self, offset: u32, width: usize, value: u32) {
        self.with(|chip, access| chip.flash.write_far(offset, value, width, access));
        self.settle();
    }
}

/// Where code in flash lies: at address 0 as well.
const FLASH_PLACES: [std::ops::Range<u32>; 2] = [0..0x0008_0000, 0x0800_0000..0x0808_0000];

/// Whether a read of a register may change more than what the processor gets: one of data, or of a unit with flags that a read takes back.
fn has_effects(register: &Register, unit: Unit) -> bool {
    is_data(register) || matches!(unit, Unit::Spi(_) | Unit::Tim16 | Unit::Usart1 | Unit::Adc1)
}

/// Registers whose reads and writes move data, in a width of the data's own.
fn is_data(register: &Register) -> bool {
    matches!(
        register.name,
        "dr16" | "dr32" | "dr8" | "rdr" | "tdr" | "dr"
    )
}
