//! Which exception comes next: pending, enabled and active ones, and their priorities (ARMv7-M ARM, B1.5).
//!
//! Exceptions have their architectural numbers: 2 NMI, 3 hard fault, 11 SVC, 14 PendSV, 15 SysTick, 16 and more the chip's lines.

/// Exception numbers of the processor's own.
pub mod number {
    /// Non-maskable interrupt.
    pub const NMI: u16 = 2;
    /// Hard fault.
    pub const HARD_FAULT: u16 = 3;
    /// Supervisor call.
    pub const SVC: u16 = 11;
    /// Pendable service call.
    pub const PEND_SV: u16 = 14;
    /// The processor's timer.
    pub const SYS_TICK: u16 = 15;
    /// The chip's line 0.
    pub const LINE_0: u16 = 16;
}

/// Bits of a priority that the chip has: the upper four (RM0440, 14.1).
const PRIORITY_BITS: u8 = 0xF0;
/// Priority of no exception at all: everything may interrupt.
const THREAD: i16 = 256;

/// Masks of the processor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Masks {
    /// PRIMASK.
    pub primask: bool,
    /// FAULTMASK.
    pub faultmask: bool,
    /// BASEPRI; 0 masks nothing.
    pub basepri: u8,
}

/// State of the interrupt controller.
#[derive(Clone, Debug)]
pub struct Nvic {
    enabled: u128,
    pending: u128,
    active: u128,
    /// Lines that are up: they pend again when their handler returns.
    lines: u128,
    priority: [u8; 128],
    /// Bits of a priority that do not preempt (AIRCR.PRIGROUP).
    subpriority: u8,
}

impl Default for Nvic {
    fn default() -> Self {
        // The processor's own exceptions are always enabled.
        Self {
            enabled: 0xFFFF,
            pending: 0,
            active: 0,
            lines: 0,
            priority: [0; 128],
            subpriority: 0,
        }
    }
}

impl Nvic {
    /// Enables lines.
    pub fn enable(&mut self, lines: u128) {
        self.enabled |= lines << number::LINE_0;
    }

    /// Disables lines.
    pub fn disable(&mut self, lines: u128) {
        self.enabled &= !(lines << number::LINE_0);
    }

    /// Lines that are enabled.
    pub fn enabled(&self) -> u128 {
        self.enabled >> number::LINE_0
    }

    /// Makes an exception pending.
    pub fn pend(&mut self, exception: u16) {
        self.pending |= 1 << exception;
    }

    /// Takes that back.
    pub fn unpend(&mut self, exception: u16) {
        self.pending &= !(1 << exception);
    }

    /// Whether an exception is pending.
    pub fn is_pending(&self, exception: u16) -> bool {
        self.pending >> exception & 1 == 1
    }

    /// Lines that are pending.
    pub fn pending_lines(&self) -> u128 {
        self.pending >> number::LINE_0
    }

    /// Lines that are active.
    pub fn active_lines(&self) -> u128 {
        self.active >> number::LINE_0
    }

    /// Whether any exception is active.
    pub fn in_handler(&self) -> bool {
        self.active != 0
    }

    /// Levels of the chip's lines: one that has come up pends, and one whose handler runs pends again at its end.
    pub fn set_lines(&mut self, lines: u128) {
        let lines = lines << number::LINE_0;
        self.lines = lines;
        self.pending |= lines & !self.active;
    }

    /// Priority of an exception, as its register has it.
    pub fn priority(&self, exception: u16) -> u8 {
        self.priority[usize::from(exception) & 127]
    }

    /// Sets it.
    pub fn set_priority(&mut self, exception: u16, priority: u8) {
        self.priority[usize::from(exception) & 127] = priority & PRIORITY_BITS;
    }

    /// AIRCR.PRIGROUP: how many lower bits of a priority do not preempt, less one.
    pub fn set_group(&mut self, group: u32) {
        self.subpriority = ((2u32 << group) - 1) as u8;
    }

    /// AIRCR.PRIGROUP.
    pub fn group(&self) -> u32 {
        u32::from(self.subpriority)
            .trailing_ones()
            .saturating_sub(1)
    }

    fn level(&self, exception: u16) -> i16 {
        match exception {
            number::NMI => -2,
            number::HARD_FAULT => -1,
            other => i16::from(self.priority(other)),
        }
    }

    fn preempting(&self, level: i16) -> i16 {
        if level < 0 {
            level
        } else {
            level & !i16::from(self.subpriority)
        }
    }

    /// Priority that the processor runs at.
    fn running(&self, masks: Masks) -> i16 {
        let active = bits(self.active).map(|exception| self.preempting(self.level(exception)));
        let by_mask = match masks {
            Masks {
                faultmask: true, ..
            } => -1,
            Masks { primask: true, .. } => 0,
            Masks { basepri: 0, .. } => THREAD,
            Masks { basepri, .. } => self.preempting(i16::from(basepri)),
        };
        active.fold(by_mask, i16::min)
    }

    /// The exception that is taken now, if any: the highest priority, then the lowest number.
    pub fn candidate(&self, masks: Masks) -> Option<u16> {
        let waiting = bits(self.pending & self.enabled);
        let first = waiting.min_by_key(|exception| (self.level(*exception), *exception))?;
        (self.preempting(self.level(first)) < self.running(masks)).then_some(first)
    }

    /// The exception that would be taken without the masks.
    pub fn held_back(&self) -> Option<u16> {
        self.candidate(Masks::default())
    }

    /// An exception is entered.
    pub fn enter(&mut self, exception: u16) {
        self.unpend(exception);
        self.active |= 1 << exception;
    }

    /// An exception's handler returns.
    pub fn leave(&mut self, exception: u16) {
        self.active &= !(1 << exception);
        self.pending |= self.lines & 1 << exception;
    }
}

fn bits(mut set: u128) -> impl Iterator<Item = u16> {
    std::iter::from_fn(move || {
        let lowest = (set != 0).then(|| set.trailing_zeros() as u16)?;
        set &= set - 1;
        Some(lowest)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lines 3 (priority 0) and 5 (priority 0x80), both enabled.
    fn two_lines() -> Nvic {
        let mut nvic = Nvic::default();
        nvic.enable(1 << 3 | 1 << 5);
        nvic.set_priority(16 + 5, 0x80);
        nvic
    }

    #[test]
    fn the_higher_priority_comes_first_and_is_not_interrupted() {
        let mut nvic = two_lines();
        nvic.pend(16 + 5);
        nvic.pend(16 + 3);
        assert_eq!(nvic.candidate(Masks::default()), Some(19));
        nvic.enter(19);
        assert_eq!(nvic.candidate(Masks::default()), None);
        nvic.leave(19);
        assert_eq!(nvic.candidate(Masks::default()), Some(21));
        nvic.enter(21);
        nvic.pend(16 + 3);
        assert_eq!(nvic.candidate(Masks::default()), Some(19), "preempts");
    }

    #[test]
    fn masks_hold_back_what_they_should() {
        let mut nvic = two_lines();
        nvic.pend(16 + 5);
        let basepri = |basepri| Masks {
            basepri,
            ..Masks::default()
        };
        assert_eq!(nvic.candidate(basepri(0x80)), None);
        assert_eq!(nvic.candidate(basepri(0x90)), Some(21));
        nvic.pend(16 + 3);
        assert_eq!(nvic.candidate(basepri(0x80)), Some(19));
        let primask = Masks {
            primask: true,
            ..Masks::default()
        };
        assert_eq!(nvic.candidate(primask), None);
        nvic.pend(number::NMI);
        assert_eq!(nvic.candidate(primask), Some(number::NMI));
    }

    #[test]
    fn a_line_that_stays_up_pends_again_and_one_that_is_off_is_never_taken() {
        let mut nvic = two_lines();
        nvic.set_lines(1 << 3);
        assert_eq!(nvic.candidate(Masks::default()), Some(19));
        nvic.enter(19);
        nvic.set_lines(1 << 3);
        nvic.leave(19);
        assert_eq!(nvic.candidate(Masks::default()), Some(19));
        nvic.enter(19);
        nvic.set_lines(0);
        nvic.leave(19);
        assert_eq!(nvic.candidate(Masks::default()), None);
        nvic.pend(16 + 4);
        assert_eq!(nvic.candidate(Masks::default()), None);
    }

    #[test]
    fn equal_priorities_go_by_number_and_groups_do_not_preempt() {
        let mut nvic = two_lines();
        nvic.set_priority(16 + 3, 0x90);
        nvic.pend(16 + 3);
        nvic.pend(16 + 5);
        assert_eq!(nvic.candidate(Masks::default()), Some(21));
        nvic.enter(21);
        nvic.set_priority(16 + 3, 0x70);
        assert_eq!(nvic.candidate(Masks::default()), Some(19));
        nvic.set_group(7);
        assert_eq!(nvic.candidate(Masks::default()), None);
    }
}
