//! The processor: unicorn runs the instructions, this module does what an ARMv7-M does around them.
//!
//! Time passes by blocks of instructions. Between two blocks the peripherals catch up and an exception is taken if one waits; an access to a
//! register sees them as they are at its block's end.

pub mod contention;
pub mod cost;
mod data_cache;
mod fetch;
pub mod frame;
mod maps;
pub mod nvic;
mod shared;
pub mod system;
pub mod times;

pub use crate::memory::{BANK_BYTES, FLASH};

use crate::chip::Chip;
use crate::memory::{RAM, RAM_BYTES};
use crate::peripheral::rcc::Cause;
use crate::rule::{Findings, Rule};
use crate::time::Ticks;
use anyhow::{Result, anyhow, bail};
use cost::Costs;
use data_cache::DataCache;
use frame::{get, set};
use maps::{add_hooks, failed, map_memory, map_registers};
use nvic::{Masks, number};
use shared::{Event, Shared};
use system::System;
use times::Times;
use unicorn_engine::{Arch, Mode, RegisterARM as Reg, Unicorn, uc_error};

/// Cycles of an exception's entry, its return, and of one handler after another (ARM DDI 0439, 3.9.1).
const ENTRY_CYCLES: u64 = 12;
const RETURN_CYCLES: u64 = 10;
const CHAIN_CYCLES: u64 = 6;

/// Where code that hangs is put: the end of RAM, which no image uses; and that code, a branch to itself.
const HANG: u32 = RAM + RAM_BYTES - 8;
const ROUND_AND_ROUND: [u8; 2] = [0xFE, 0xE7];
/// Code that needs stack: push {r0}; a branch to itself.
const RUNS_OVER: [u8; 4] = [0x01, 0xB4, 0xFE, 0xE7];
/// Cycles of a millisecond: at least as many blocks of instructions.
const MILLISECOND_CYCLES: u32 = 170_000;

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// Its time is over.
    Time,
    /// The supply went in the middle of a flash operation.
    PowerLost,
}

/// The chip, running an image.
pub struct Processor {
    uc: Unicorn<'static, Shared>,
    resets: u32,
    /// How long handlers take.
    pub times: Times,
    /// Resets of the image's own asking are no fault.
    pub may_reset: bool,
    /// Cycles that handlers of an exception take besides their own: as if there were more to do in them.
    pub stretch: Option<(u16, u64)>,
    /// The supply dips only: a brown-out reset, and RAM keeps what it held.
    pub dips: bool,
}

impl Processor {
    /// A chip with these bytes in its bank 1, all 256 KiB, after power-on.
    ///
    /// # Errors
    /// Unicorn's.
    pub fn start(code: &[u8], chip: Chip) -> Result<Self> {
        chip.around.banks[0].load(code);
        let cycle = chip.cycle();
        let shared = Shared {
            chip,
            system: System::after_reset(),
            costs: Costs::new(FLASH, code),
            cycles: 0,
            until: 0,
            next: 0,
            event: None,
            masked: false,
            waits: false,
            cycle,
            resumed: false,
            wait_states: false,
            waits_for_dma: false,
            data_cache: DataCache::default(),
            loads_watched: vec![],
            looked_at: 0,
            watched: vec![],
        };
        let mode = Mode::THUMB | Mode::MCLASS;
        let mut uc = Unicorn::new_with_data(Arch::ARM, mode, shared).map_err(failed)?;
        uc.ctl_set_cpu_model(unicorn_engine::ArmCpuModel::CORTEX_M4 as i32)
            .map_err(failed)?;
        map_memory(&mut uc)?;
        map_registers(&mut uc)?;
        add_hooks(&mut uc)?;
        let mut processor = Self {
            uc,
            resets: 0,
            times: Times::default(),
            may_reset: false,
            stretch: None,
            dips: false,
        };
        processor.boot()?;
        Ok(processor)
    }

    /// The peripherals and what they are wired to.
    pub fn chip(&mut self) -> &mut Chip {
        &mut self.uc.get_data_mut().chip
    }

    /// Rules broken so far.
    pub fn findings(&mut self) -> &mut Findings {
        &mut self.chip().findings
    }

    /// From now on fetches and loads wait for the flash, or not.
    ///
    /// # Errors
    /// Unicorn's.
    pub fn set_wait_states(&mut self, counted: bool) -> Result<()> {
        self.uc.get_data_mut().wait_states = counted;
        maps::watch_loads(&mut self.uc, counted).map_err(failed)
    }

    /// From now on all accesses wait that DMA may hold up, or none.
    pub fn set_waiting_for_dma(&mut self, counted: bool) {
        let shared = self.uc.get_data_mut();
        shared.waits_for_dma = counted;
        // What was moved before holds up nothing any more.
        let _ = shared.chip.transfers.take_moved();
    }

    /// Resets since power-on.
    pub fn resets(&self) -> u32 {
        self.resets
    }

    /// Cycles since power-on.
    pub fn cycles(&self) -> u64 {
        self.uc.get_data().cycles
    }

    /// Time since power-on.
    pub fn now(&self) -> Ticks {
        self.uc.get_data().chip.now
    }

    /// Where the processor is.
    pub fn program_counter(&self) -> u32 {
        get(&self.uc, Reg::PC)
    }

    /// Runs until the processor is in this exception, 0 for none, and makes it hang there: it goes round in one place, which is returned.
    ///
    /// # Errors
    /// It does not get there within a millisecond.
    pub fn hang(&mut self, exception: u16) -> Result<u32> {
        self.get_into(exception)?;
        self.write_memory(HANG, &ROUND_AND_ROUND)?;
        set(&mut self.uc, Reg::PC, HANG | 1);
        Ok(HANG)
    }

    /// Runs until the processor is in this exception, 0 for none, and makes its stack run over.
    ///
    /// # Errors
    /// As [`hang`](Self::hang).
    pub fn spend_stack(&mut self, exception: u16) -> Result<()> {
        self.get_into(exception)?;
        self.write_memory(HANG, &RUNS_OVER)?;
        set(&mut self.uc, Reg::SP, RAM);
        set(&mut self.uc, Reg::PC, HANG | 1);
        Ok(())
    }

    fn get_into(&mut self, exception: u16) -> Result<()> {
        for _ in 0..MILLISECOND_CYCLES {
            let in_exception = (get(&self.uc, Reg::IPSR) & 0xFF) as u16;
            if in_exception == exception {
                return Ok(());
            }
            self.run(1)?;
        }
        bail!("the processor does not get into exception {exception}")
    }

    /// A core register: 0 to 12, 13 the stack pointer, 14 the link register, 15 the program counter.
    pub fn register(&self, number: usize) -> u32 {
        const NUMBERED: [Reg; 16] = [
            Reg::R0,
            Reg::R1,
            Reg::R2,
            Reg::R3,
            Reg::R4,
            Reg::R5,
            Reg::R6,
            Reg::R7,
            Reg::R8,
            Reg::R9,
            Reg::R10,
            Reg::R11,
            Reg::R12,
            Reg::SP,
            Reg::LR,
            Reg::PC,
        ];
        get(&self.uc, NUMBERED[number])
    }

    /// Bits of a floating-point register, s0 to s15.
    pub fn float_register(&self, number: usize) -> u32 {
        get(&self.uc, frame::SINGLES[number])
    }

    /// Reads memory, as a debug probe does.
    ///
    /// # Errors
    /// There is none.
    pub fn read_memory(&self, address: u32, bytes: &mut [u8]) -> Result<()> {
        let read = self.uc.mem_read(u64::from(address), bytes);
        read.map_err(|_| anyhow!("{address:#010x}: no memory"))
    }

    /// Writes RAM, as a debug probe does.
    ///
    /// # Errors
    /// There is none.
    pub fn write_memory(&mut self, address: u32, bytes: &[u8]) -> Result<()> {
        let written = self.uc.mem_write(u64::from(address), bytes);
        written.map_err(|_| anyhow!("{address:#010x}: no memory"))
    }

    /// The supply goes and comes: RAM holds anything afterwards, unless it [dips](Self::dips) only; flash holds what it held.
    ///
    /// # Errors
    /// Unicorn's.
    pub fn cut_power(&mut self) -> Result<()> {
        if !self.dips {
            // Not zeros, which a start-up that forgets to clear its memory would not notice.
            let noise: Vec<u8> = (0..RAM_BYTES)
                .map(|k| (k.wrapping_mul(0x9E37_79B1) >> 13) as u8)
                .collect();
            self.write_memory(RAM, &noise)?;
        }
        self.reset(Cause::Supply)
    }

    fn reset(&mut self, cause: Cause) -> Result<()> {
        self.resets += 1;
        let shared = self.uc.get_data_mut();
        shared.chip.reset(cause)?;
        shared.system = System::after_reset();
        shared.costs.forget_ccm();
        shared.event = None;
        shared.masked = false;
        self.times.restart();
        self.boot()
    }

    /// Registers after reset, stack and program counter from the vector table.
    fn boot(&mut self) -> Result<()> {
        maps::map_banks(&mut self.uc).map_err(failed)?;
        for register in [
            Reg::PRIMASK,
            Reg::FAULTMASK,
            Reg::BASEPRI,
            Reg::IPSR,
            Reg::CONTROL,
        ] {
            set(&mut self.uc, register, 0);
        }
        set(&mut self.uc, Reg::EPSR, 1 << 24);
        set(&mut self.uc, Reg::APSR_NZCV, 0);
        let (stack, start) = (self.word(FLASH)?, self.word(FLASH + 4)?);
        set(&mut self.uc, Reg::MSP, stack);
        set(&mut self.uc, Reg::LR, u32::MAX);
        set(&mut self.uc, Reg::PC, start);
        self.uc.get_data_mut().plan();
        Ok(())
    }

    fn word(&self, address: u32) -> Result<u32> {
        let mut bytes = [0; 4];
        self.read_memory(address, &mut bytes)?;
        Ok(u32::from_le_bytes(bytes))
    }

    fn masks(&self) -> Masks {
        Masks {
            primask: get(&self.uc, Reg::PRIMASK) & 1 == 1,
            faultmask: get(&self.uc, Reg::FAULTMASK) & 1 == 1,
            basepri: get(&self.uc, Reg::BASEPRI) as u8,
        }
    }

    /// Runs for so long.
    ///
    /// # Errors
    /// The processor can go on no more.
    pub fn run(&mut self, duration: Ticks) -> Result<End> {
        let until = self.now() + duration;
        self.uc.get_data_mut().until = until;
        self.uc.get_data_mut().plan();
        loop {
            self.serve()?;
            let shared = self.uc.get_data();
            if shared.chip.flash.power_lost() {
                return Ok(End::PowerLost);
            }
            if shared.chip.now >= until {
                maps::store(&mut self.uc);
                return Ok(End::Time);
            }
            self.blocks()?;
        }
    }

    /// Instructions, until something is to be served.
    fn blocks(&mut self) -> Result<()> {
        maps::store(&mut self.uc);
        let start = u64::from(self.program_counter() | 1);
        let shared = self.uc.get_data_mut();
        shared.resumed = true;
        shared.look();
        let Err(error) = self.uc.emu_start(start, u64::MAX, 0, 0) else {
            self.sleep();
            return Ok(());
        };
        let at = self.program_counter();
        match error {
            _ if self.uc.get_data().event.is_some() => Ok(()),
            uc_error::FETCH_PROT if maps::run_from_data(&mut self.uc, at) => Ok(()),
            uc_error::INSN_INVALID | uc_error::EXCEPTION => {
                self.uc.get_data_mut().event = Some(Event::Undefined);
                Ok(())
            }
            other => bail!("unicorn: {other:?} at {at:#010x}"),
        }
    }

    /// The processor has stopped by itself (WFI): time passes to the next instant at which something happens.
    fn sleep(&mut self) {
        let shared = self.uc.get_data_mut();
        while !shared.is_due() {
            let cycles = (shared.next - shared.chip.now).div_ceil(shared.chip.cycle());
            shared.pass(cycles.max(1));
        }
    }

    /// What a block left to do: returns, faults, resets, and the exception that comes next.
    fn serve(&mut self) -> Result<()> {
        match self.uc.get_data_mut().event.take() {
            None => {}
            Some(Event::ExceptionReturn) => return self.leave(),
            Some(Event::Supervisor) => self.uc.get_data_mut().system.nvic.pend(number::SVC),
            Some(Event::Fault(address)) => self.fault(address),
            Some(Event::Undefined) => self.undefined(),
            Some(Event::Reset) => return self.wished_reset(),
        }
        let masks = self.masks();
        let shared = self.uc.get_data_mut();
        let next = shared.system.nvic.candidate(masks);
        shared.masked = next.is_none() && shared.system.nvic.held_back().is_some();
        match next {
            Some(exception) => self.enter(exception),
            None => Ok(()),
        }
    }

    fn wished_reset(&mut self) -> Result<()> {
        let chip = &self.uc.get_data().chip;
        let (expired, loads) = (chip.watchdog_expired(), chip.loads_options());
        let (now, pc, may_reset) = (self.now(), self.program_counter(), self.may_reset);
        if !expired && !loads && !may_reset {
            self.findings()
                .add(Rule::Reset, now, format!("by the image, at {pc:#010x}"));
        }
        self.reset(match (expired, loads) {
            (true, _) => Cause::Watchdog,
            (false, true) => Cause::Options,
            (false, false) => Cause::Software,
        })
    }

    fn vector(&mut self, exception: u16) -> Result<u32> {
        let table = self.uc.get_data().system.vtor;
        self.word(table + 4 * u32::from(exception))
    }

    fn enter(&mut self, exception: u16) -> Result<()> {
        let vector = self.vector(exception)?;
        self.times.enter(exception, self.cycles());
        let stretched = self.stretch.filter(|(of, _)| *of == exception);
        let shared = self.uc.get_data_mut();
        shared.system.nvic.enter(exception);
        shared.pass(ENTRY_CYCLES + stretched.map_or(0, |(_, cycles)| cycles));
        if !frame::enter(&mut self.uc, exception, vector) {
            // The frame lies where there is no memory: MSTKERR, and a hard fault comes next.
            let system = &mut self.uc.get_data_mut().system;
            system.cfsr |= 1 << 4;
            if exception != number::HARD_FAULT {
                self.hard_fault("the stack lies where there is no memory");
            }
        }
        self.uc.get_data_mut().plan();
        Ok(())
    }

    fn leave(&mut self) -> Result<()> {
        let back = get(&self.uc, Reg::PC) | 1;
        let exception = (get(&self.uc, Reg::IPSR) & 0xFF) as u16;
        let shared = self.uc.get_data_mut();
        shared.system.nvic.leave(exception);
        shared.plan();
        let masks = self.masks();
        let next = self.uc.get_data().system.nvic.candidate(masks);
        if let Some(next) = next {
            let vector = self.vector(next)?;
            self.times.leave(self.cycles());
            self.times.enter(next, self.cycles());
            let stretched = self.stretch.filter(|(of, _)| *of == next);
            let shared = self.uc.get_data_mut();
            shared.system.nvic.enter(next);
            shared.pass(CHAIN_CYCLES + stretched.map_or(0, |(_, cycles)| cycles));
            frame::chain(&mut self.uc, next, vector, back);
            return Ok(());
        }
        self.uc.get_data_mut().pass(RETURN_CYCLES);
        self.times.leave(self.cycles());
        if !frame::leave(&mut self.uc, back) {
            bail!("the return from exception {exception} finds no memory");
        }
        Ok(())
    }

    /// A memory access that nothing answers. The firmware enables no fault but the hard one.
    fn fault(&mut self, address: u32) {
        let pc = self.program_counter();
        let system = &mut self.uc.get_data_mut().system;
        system.fault_address = address;
        system.cfsr |= match system.protects(address) {
            // MMARVALID and DACCVIOL.
            true => 0x82,
            // BFARVALID and PRECISERR.
            false => 0x8200,
        };
        self.hard_fault(&format!("{address:#010x} is accessed at {pc:#010x}"));
    }

    fn undefined(&mut self) {
        let pc = self.program_counter();
        // UNDEFINSTR.
        self.uc.get_data_mut().system.cfsr |= 1 << 16;
        self.hard_fault(&format!("no instruction at {pc:#010x}"));
    }

    fn hard_fault(&mut self, why: &str) {
        let now = self.now();
        self.findings().add(Rule::Fault, now, why.into());
        let system = &mut self.uc.get_data_mut().system;
        system.hfsr |= 1 << 30;
        system.nvic.pend(number::HARD_FAULT);
    }
}
