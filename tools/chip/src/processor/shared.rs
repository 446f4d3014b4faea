//! What unicorn's hooks work on: chip, processor's registers, time.

use super::contention;
use super::cost::Costs;
use super::data_cache::DataCache;
use super::nvic::number;
use super::system::System;
use crate::chip::Chip;
use crate::time::Ticks;
use unicorn_engine::UcHookId;

/// Code below it lies in flash, above it in a RAM.
const CODE_END: u32 = 0x1000_0000;

/// Operations of the flash before waits for it are cut short: a commit has some forty, its page's erase among them.
const OPERATIONS_IN_FULL: u64 = 64;

/// Why the processor has stopped between two blocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// A handler returns.
    ExceptionReturn,
    /// SVC.
    Supervisor,
    /// An access to this address found nothing.
    Fault(u32),
    /// An instruction that is none.
    Undefined,
    /// A reset is asked for.
    Reset,
}

/// What unicorn's hooks work on.
pub struct Shared {
    /// The peripherals.
    pub chip: Chip,
    /// The processor's own registers.
    pub system: System,
    /// Time of a block.
    pub costs: Costs,
    /// Cycles since power-on.
    pub cycles: u64,
    /// Where a run ends.
    pub until: Ticks,
    /// The next instant at which a block must not just go on.
    pub next: Ticks,
    /// What a block left to do.
    pub event: Option<Event>,
    /// Something waits that a mask holds back: it is looked at after each block.
    pub masked: bool,
    /// Whether an exception waits that would be taken without the masks: as of the last [`Shared::look`].
    pub waits: bool,
    /// The processor's cycle, ticks: as of the last [`Shared::plan`].
    pub cycle: Ticks,
    /// Instructions have just been started, and none has run yet.
    pub resumed: bool,
    /// Whether fetches wait for the flash.
    pub wait_states: bool,
    /// Whether all accesses wait that DMA may hold up.
    pub waits_for_dma: bool,
    /// What loads from the flash find.
    pub data_cache: DataCache,
    /// Hooks on loads from the bank that code runs from, while wait states count.
    pub loads_watched: Vec<UcHookId>,
    /// The block of instructions that looked at the flash controller's status last.
    pub looked_at: u32,
    /// Hooks on pages of the bank that code runs from in which a double word is torn.
    pub watched: Vec<UcHookId>,
}

impl Shared {
    /// A block is about to run: its time passes. True if the processor is to stop before it; after a stop one block always runs.
    pub fn block(&mut self, address: u32, bytes: u32) -> bool {
        if self.is_due() && !self.resumed {
            return true;
        }
        self.resumed = false;
        self.chip.running_at = address;
        let cycles = self.costs.block(address, bytes, self.states()) + self.held_up(address);
        self.pass(u64::from(cycles));
        false
    }

    /// Wait states that count: those of the flash where the code lies, if they are asked for.
    fn states(&self) -> u32 {
        match self.wait_states {
            true => u32::from(self.chip.flash.acr().latency().to_bits()),
            false => 0,
        }
    }

    /// The processor loads from the bank that code runs from.
    pub fn load(&mut self, address: u32) {
        let is_on = self.chip.flash.acr().dcen();
        let waits = self.data_cache.load(address, self.states(), is_on);
        if waits > 0 {
            self.pass(u64::from(waits));
        }
    }

    /// The processor waits for the bank that is erased or programmed, from which it reads.
    pub fn wait_for_bank(&mut self) {
        let until = self.chip.flash.busy_until();
        if until > self.chip.now {
            self.pass((until - self.chip.now).div_ceil(self.cycle));
        }
    }

    /// Cycles that DMA may hold this block up, by what it has moved since the one before, if waiting counts.
    fn held_up(&mut self, address: u32) -> u32 {
        if !self.waits_for_dma {
            return 0;
        }
        let moved = self.chip.transfers.take_moved();
        contention::of_block(moved, address < CODE_END, self.states())
    }

    /// Cycles that DMA may hold up an access to a register, if waiting counts.
    pub fn held_up_at(&self, address: u32) -> u64 {
        let serves = self.waits_for_dma && self.chip.transfers.serves();
        contention::of_access(address, serves)
    }

    /// Code has looked at the flash controller's status. If it waits there, nothing else happens until the next instant: time goes on to
    /// that. The first operations are waited for look by look, so that a wait that gives up too early is seen.
    pub fn wait_for_flash(&mut self) {
        let before = std::mem::replace(&mut self.looked_at, self.chip.running_at);
        let end = self.next.min(self.chip.flash.busy_until());
        if before == self.looked_at
            && !self.is_due()
            && end > self.chip.now
            && self.chip.flash.operations() >= OPERATIONS_IN_FULL
        {
            self.pass((end - self.chip.now) / self.cycle);
        }
    }

    /// Lets time pass.
    pub fn pass(&mut self, cycles: u64) {
        self.cycles += cycles;
        let now = self.chip.now + cycles * self.cycle;
        if now < self.next {
            self.chip.now = now;
        } else {
            self.catch_up(now);
        }
    }

    fn catch_up(&mut self, now: Ticks) {
        self.chip.advance_to(now);
        self.system.advance(now);
        self.plan();
    }

    /// Interrupt lines and the next instant, after anything may have changed.
    pub fn plan(&mut self) {
        self.system.nvic.set_lines(self.chip.interrupt_lines());
        self.next = self.chip.next().min(self.system.next()).min(self.until);
        if self.chip.flash.take_double_error() {
            self.system.nvic.pend(number::NMI);
        }
        if self.chip.watchdog_expired() || self.chip.loads_options() {
            self.event = Some(Event::Reset);
        }
        self.cycle = self.chip.cycle();
        self.look();
    }

    /// Looks for an exception that waits. To be called whenever the interrupt controller may have changed: each block asks what was found.
    pub fn look(&mut self) {
        self.waits = self.system.nvic.held_back().is_some();
    }

    /// Whether the processor is to stop between two blocks.
    pub fn is_due(&self) -> bool {
        self.event.is_some()
            || self.masked
            || self.chip.now >= self.until
            || self.chip.flash.power_lost()
            || self.waits
    }
}
