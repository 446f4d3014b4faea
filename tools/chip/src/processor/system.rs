//! The processor's own registers: interrupt controller, system control, timer, cycle counter, memory protection.

use super::nvic::{Nvic, number};
use crate::rule::{Findings, Rule};
use crate::time::{NEVER, Ticks};
use std::collections::BTreeMap;

/// Memory that the model has, `[first, end)`: what a protection region may not overlap, as the model has no finer protection.
pub const MEMORY: [(u32, u32); 5] = [
    (0x0000_0000, 0x0008_0000),
    (0x0800_0000, 0x0808_0000),
    (0x1000_0000, 0x1000_8000),
    (0x1FFF_0000, 0x1FFF_8000),
    (0x2000_0000, 0x2002_0000),
];

const CPUID: u32 = 0x410F_C241;

/// What a write asks of the processor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wish {
    /// Nothing.
    Nothing,
    /// SYSRESETREQ.
    Reset,
}

/// The registers.
#[derive(Debug)]
pub struct System {
    /// Interrupt controller.
    pub nvic: Nvic,
    /// Vector table.
    pub vtor: u32,
    /// Configurable fault status.
    pub cfsr: u32,
    /// Hard fault status.
    pub hfsr: u32,
    /// Address of a memory or bus fault.
    pub fault_address: u32,
    plain: BTreeMap<u32, u32>,
    counts: bool,
    counter_zero: u64,
    tick: SysTick,
    region: u32,
    regions: BTreeMap<u32, (u32, u32)>,
}

#[derive(Debug, Default)]
struct SysTick {
    control: u32,
    reload: u32,
    zero_at: Ticks,
    cycle: Ticks,
    due: Option<Ticks>,
}

impl System {
    /// After reset.
    pub fn after_reset() -> Self {
        // Architectural reset values: CCR.STKALIGN, FPCCR.ASPEN and LSPEN.
        let plain = BTreeMap::from([(0xED14, 0x200), (0xEF34, 0xC000_0000)]);
        Self {
            nvic: Nvic::default(),
            vtor: 0,
            cfsr: 0,
            hfsr: 0,
            fault_address: 0,
            plain,
            counts: false,
            counter_zero: 0,
            tick: SysTick::default(),
            region: 0,
            regions: BTreeMap::new(),
        }
    }

    /// When the processor's timer interrupts next.
    pub fn next(&self) -> Ticks {
        self.tick.due.unwrap_or(NEVER)
    }

    /// Does what is due.
    pub fn advance(&mut self, now: Ticks) {
        if let Some(due) = self.tick.due
            && now >= due
        {
            let period = u64::from(self.tick.reload + 1) * self.tick.cycle;
            self.tick.due = Some(due + period);
            self.tick.zero_at = due;
            self.tick.control |= 1 << 16;
            if self.tick.control & 2 != 0 {
                self.nvic.pend(number::SYS_TICK);
            }
        }
    }

    /// A read. `offset` from 0xE000_0000; `cycles` since power-on.
    pub fn read(
        &mut self,
        offset: u32,
        width: usize,
        cycles: u64,
        now: Ticks,
        findings: &mut Findings,
    ) -> u32 {
        if (0xE400..0xE4F0).contains(&offset) || (0xED18..0xED24).contains(&offset) {
            let bytes = (0..width as u32).map(|k| self.nvic.priority(exception_of(offset + k)));
            return bytes
                .rev()
                .fold(0, |word, byte| word << 8 | u32::from(byte));
        }
        let word = |lines: u128| lines.checked_shr((offset & 0x1C) * 8).unwrap_or(0) as u32;
        match offset {
            0x1000 => 0x4000_0000 | u32::from(self.counts),
            0x1004 => cycles.wrapping_sub(self.counter_zero) as u32,
            0xE010 => {
                // COUNTFLAG goes by reading it.
                let control = self.tick.control;
                self.tick.control &= 7;
                control
            }
            0xE014 => self.tick.reload,
            0xE018 => self.tick_value(now),
            0xE100..0xE120 | 0xE180..0xE1A0 => word(self.nvic.enabled()),
            0xE200..0xE220 | 0xE280..0xE2A0 => word(self.nvic.pending_lines()),
            0xE300..0xE320 => word(self.nvic.active_lines()),
            0xED00 => CPUID,
            0xED04 => self.icsr(),
            0xED08 => self.vtor,
            0xED0C => 0xFA05_0000 | self.nvic.group() << 8,
            0xED28 => self.cfsr,
            0xED2C => self.hfsr,
            0xED34 | 0xED38 => self.fault_address,
            0xED90 => 0x0000_0800,
            0xED98 => self.region,
            0xED9C => self.regions.get(&self.region).map_or(0, |(base, _)| *base),
            0xEDA0 => self.regions.get(&self.region).map_or(0, |(_, size)| *size),
            _ if is_plain(offset) => self.plain.get(&offset).copied().unwrap_or(0),
            _ => {
                let detail = format!("{:#010x}: not in the model", 0xE000_0000 + offset);
                findings.add(Rule::Unmodelled, now, detail);
                0
            }
        }
    }

    /// A write. `cycle` is the processor's, ticks.
    #[allow(clippy::too_many_arguments)] // what an access is
    pub fn write(
        &mut self,
        offset: u32,
        width: usize,
        value: u32,
        cycles: u64,
        now: Ticks,
        cycle: Ticks,
        findings: &mut Findings,
    ) -> Wish {
        if (0xE400..0xE4F0).contains(&offset) || (0xED18..0xED24).contains(&offset) {
            for k in 0..width as u32 {
                let priority = (value >> (8 * k)) as u8;
                self.nvic.set_priority(exception_of(offset + k), priority);
            }
            return Wish::Nothing;
        }
        // Registers of lines that the chip does not have hold nothing.
        let lines = u128::from(value)
            .checked_shl((offset & 0x1C) * 8)
            .unwrap_or(0);
        match offset {
            0x1000 => self.counts = value & 1 == 1,
            0x1004 => self.counter_zero = cycles.wrapping_sub(u64::from(value)),
            0xE010..=0xE018 => self.write_tick(offset, value, now, cycle),
            0xE100..0xE120 => self.nvic.enable(lines),
            0xE180..0xE1A0 => self.nvic.disable(lines),
            0xE200..0xE220 => each(lines, |line| self.nvic.pend(number::LINE_0 + line)),
            0xE280..0xE2A0 => each(lines, |line| self.nvic.unpend(number::LINE_0 + line)),
            0xED04 => self.write_icsr(value),
            0xED08 => self.vtor = value & !0x7F,
            0xED0C => return self.write_aircr(value),
            0xED28 => self.cfsr &= !value,
            0xED2C => self.hfsr &= !value,
            0xED94 | 0xED98 | 0xED9C | 0xEDA0 => {
                self.write_protection(offset, value, now, findings)
            }
            _ if is_plain(offset) => {
                self.plain.insert(offset, value);
            }
            _ => {
                let detail = format!("{:#010x}: not in the model", 0xE000_0000 + offset);
                findings.add(Rule::Unmodelled, now, detail);
            }
        }
        Wish::Nothing
    }

    fn icsr(&self) -> u32 {
        let pending = self.nvic.held_back().map_or(0, u32::from);
        let bit = |exception, place: u32| u32::from(self.nvic.is_pending(exception)) << place;
        pending << 12
            | bit(number::NMI, 31)
            | bit(number::PEND_SV, 28)
            | bit(number::SYS_TICK, 26)
            | u32::from(self.nvic.pending_lines() != 0) << 22
    }

    fn write_icsr(&mut self, value: u32) {
        let set = [
            (31, number::NMI),
            (28, number::PEND_SV),
            (26, number::SYS_TICK),
        ];
        for (_, exception) in set.iter().filter(|(bit, _)| value >> bit & 1 == 1) {
            self.nvic.pend(*exception);
        }
        let clear = [(27, number::PEND_SV), (25, number::SYS_TICK)];
        for (_, exception) in clear.iter().filter(|(bit, _)| value >> bit & 1 == 1) {
            self.nvic.unpend(*exception);
        }
    }

    fn write_aircr(&mut self, value: u32) -> Wish {
        // Without its key a write means nothing.
        if value >> 16 != 0x05FA {
            return Wish::Nothing;
        }
        self.nvic.set_group(value >> 8 & 7);
        if value & 4 != 0 {
            Wish::Reset
        } else {
            Wish::Nothing
        }
    }

    fn tick_value(&self, now: Ticks) -> u32 {
        match self.tick.due {
            Some(due) if due > now => ((due - now) / self.tick.cycle.max(1)) as u32,
            _ => 0,
        }
    }

    fn write_tick(&mut self, offset: u32, value: u32, now: Ticks, cycle: Ticks) {
        match offset {
            0xE010 => self.tick.control = value & 7,
            0xE014 => self.tick.reload = value & 0x00FF_FFFF,
            _ => self.tick.zero_at = now,
        }
        // The processor's own clock, or an eighth of it.
        self.tick.cycle = if self.tick.control & 4 != 0 {
            cycle
        } else {
            8 * cycle
        };
        let runs = self.tick.control & 1 == 1 && self.tick.reload > 0;
        self.tick.due = runs.then(|| now + u64::from(self.tick.reload + 1) * self.tick.cycle);
    }

    /// The model's memory has no protection of its own: a region must lie where there is nothing anyway.
    fn write_protection(&mut self, offset: u32, value: u32, now: Ticks, findings: &mut Findings) {
        match offset {
            0xED98 => self.region = value & 7,
            0xED9C => {
                if value & 1 << 4 != 0 {
                    self.region = value & 0xF;
                }
                self.regions.entry(self.region).or_default().0 = value & !0x1F;
            }
            0xEDA0 => self.regions.entry(self.region).or_default().1 = value,
            _ => {
                self.plain.insert(offset, value);
            }
        }
        for (base, end) in self.protected() {
            let over = |(first, last): &(u32, u32)| u64::from(*first) < end && base < *last;
            if MEMORY.iter().any(over) {
                let detail = format!("protection of {base:#010x} to {end:#010x}, which is memory");
                findings.add(Rule::Unmodelled, now, detail);
            }
        }
    }

    /// The regions that are on, `[first, end)`; none while the unit is off.
    fn protected(&self) -> impl Iterator<Item = (u32, u64)> + '_ {
        let is_on = self.plain.get(&0xED94).copied().unwrap_or(0) & 1 == 1;
        let regions = self
            .regions
            .values()
            .filter(move |(_, size)| is_on && size & 1 == 1);
        regions.map(|(base, size)| (*base, u64::from(*base) + (2u64 << (size >> 1 & 0x1F))))
    }

    /// Whether a region forbids an access there.
    pub fn protects(&self, address: u32) -> bool {
        self.protected()
            .any(|(base, end)| address >= base && u64::from(address) < end)
    }
}

/// Registers that keep what is written and do nothing in the model: system control, debug, protection's control, the floating-point unit's.
fn is_plain(offset: u32) -> bool {
    matches!(
        offset,
        0xED10
            | 0xED14
            | 0xED24
            | 0xED88
            | 0xED94
            | 0xEDFC
            | 0xEDF0
            | 0xEF34
            | 0xEF38
            | 0xEF3C
            | 0xE008
    )
}

/// The exception whose priority a byte of the registers is.
fn exception_of(offset: u32) -> u16 {
    match offset {
        0xED18..0xED24 => (offset - 0xED18 + 4) as u16,
        _ => (offset - 0xE400) as u16 + number::LINE_0,
    }
}

fn each(mut lines: u128, mut work: impl FnMut(u16)) {
    while lines != 0 {
        work(lines.trailing_zeros() as u16);
        lines &= lines - 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn system() -> (System, Findings) {
        (System::after_reset(), Findings::default())
    }

    #[test]
    fn priorities_are_bytes_and_lines_are_bits() {
        let (mut system, mut findings) = system();
        let _ = system.write(0xE400 + 23, 1, 0x80, 0, 0, 8, &mut findings);
        assert_eq!(system.nvic.priority(16 + 23), 0x80);
        assert_eq!(
            system.read(0xE400 + 20, 4, 0, 0, &mut findings),
            0x8000_0000
        );
        let _ = system.write(0xE104, 4, 1 << 5, 0, 0, 8, &mut findings);
        assert_eq!(system.nvic.enabled(), 1 << 37);
        let _ = system.write(0xE184, 4, 1 << 5, 0, 0, 8, &mut findings);
        assert_eq!(system.nvic.enabled(), 0);
        assert!(findings.list().is_empty());
    }

    #[test]
    fn reset_wants_its_key_and_the_timer_interrupts_at_its_period() {
        let (mut system, mut findings) = system();
        let mut write = |system: &mut System, offset, value| {
            system.write(offset, 4, value, 0, 0, 8, &mut findings)
        };
        assert_eq!(write(&mut system, 0xED0C, 4), Wish::Nothing);
        assert_eq!(write(&mut system, 0xED0C, 0x05FA_0004), Wish::Reset);
        let _ = write(&mut system, 0xE014, 99);
        let _ = write(&mut system, 0xE010, 7);
        assert_eq!(system.next(), 800);
        system.advance(800);
        assert!(system.nvic.is_pending(number::SYS_TICK));
        assert_eq!(system.next(), 1600);
    }

    #[test]
    fn protection_over_memory_is_not_silently_ignored() {
        let (mut system, mut findings) = system();
        let mut write = |offset, value| {
            let _ = system.write(offset, 4, value, 0, 0, 8, &mut findings);
            findings.list().len()
        };
        // 16 KiB below RAM, as the firmware's guard; then 16 KiB at RAM's start.
        assert_eq!(write(0xED9C, 0x1FFF_C010), 0);
        assert_eq!(write(0xEDA0, 13 << 1 | 1), 0);
        assert_eq!(write(0xED94, 5), 0);
        assert_eq!(write(0xED9C, 0x2000_0010), 1);
    }

    #[test]
    fn a_region_forbids_its_own_addresses_while_the_unit_is_on() {
        let (mut system, mut findings) = system();
        for (offset, value) in [(0xED9C, 0x1FFF_C010), (0xEDA0, 13 << 1 | 1)] {
            let _ = system.write(offset, 4, value, 0, 0, 8, &mut findings);
        }
        assert!(!system.protects(0x1FFF_FFFC), "the unit is off");
        let _ = system.write(0xED94, 4, 5, 0, 0, 8, &mut findings);
        let found = [0x1FFF_BFFC, 0x1FFF_C000, 0x1FFF_FFFC, 0x2000_0000];
        assert_eq!(
            found.map(|at| system.protects(at)),
            [false, true, true, false]
        );
    }
}
