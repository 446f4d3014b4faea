//! What unicorn is told of the chip: memory, registers, and what to call when.

use super::shared::{Event, Shared};
use super::system::Wish;
use crate::memory::{BANK_BYTES, FLASH, RAM, RAM_BYTES};
use crate::rule::Rule;
use anyhow::{Result, anyhow};
use std::sync::LazyLock;
use unicorn_engine::{HookType, Prot, Unicorn, uc_error};

/// Where the bank lies that code runs from: the chip boots from address 0.
const NEAR: [u32; 2] = [0, FLASH];
/// Where the other one lies.
const FAR: u32 = 0x0804_0000;
/// SRAM1 and SRAM2: data alone, until code runs there ([`run_from_data`]).
const DATA_BYTES: u32 = 96 << 10;
const CCM: u32 = 0x1000_0000;
const CCM_BYTES: u32 = 32 << 10;
const SYSTEM_MEMORY: u32 = 0x1FFF_0000;
const SYSTEM_MEMORY_BYTES: u32 = 0x8000;
const PERIPHERALS: (u32, u32) = (0x4000_0000, 0x2000_0000);
const SYSTEM: (u32, u32) = (0xE000_0000, 0x0010_0000);

/// Cycles that an access to a peripheral adds to its instruction: the bridge's (one to two on the AHB, three on the APB).
const ACCESS_CYCLES: u64 = 2;
/// QEMU's numbers of what reaches the interrupt hook: supervisor call, breakpoint, return from an exception.
const QEMU_SVC: u32 = 2;
const QEMU_BREAKPOINT: u32 = 7;
const QEMU_EXCEPTION_RETURN: u32 = 8;

/// An error of unicorn's.
pub fn failed(error: uc_error) -> anyhow::Error {
    anyhow!("unicorn: {error:?}")
}

/// Flash, RAM and the factory's values.
pub fn map_memory(uc: &mut Unicorn<'static, Shared>) -> Result<()> {
    let code_only = Prot::READ | Prot::EXEC;
    for base in NEAR {
        uc.mem_map(base.into(), BANK_BYTES.into(), code_only)
            .map_err(failed)?;
    }
    for (base, bytes) in [(CCM, CCM_BYTES), (RAM + DATA_BYTES, RAM_BYTES - DATA_BYTES)] {
        uc.mem_map(base.into(), bytes.into(), Prot::ALL)
            .map_err(failed)?;
    }
    let data = Prot::READ | Prot::WRITE;
    uc.mem_map(RAM.into(), DATA_BYTES.into(), data)
        .map_err(failed)?;
    uc.mem_map(SYSTEM_MEMORY.into(), SYSTEM_MEMORY_BYTES.into(), Prot::READ)
        .map_err(failed)?;
    for (address, bytes) in crate::image::factory_values() {
        uc.mem_write(address.into(), &bytes).map_err(failed)?;
    }
    let read = |uc: &mut Unicorn<Shared>, offset: u64, width: usize| {
        let shared = uc.get_data_mut();
        shared.chip.note_read_while_written();
        shared.wait_for_bank();
        let value = shared.chip.read_far(offset as u32, width);
        after_access(uc.get_data_mut());
        u64::from(value)
    };
    let write = |uc: &mut Unicorn<Shared>, offset: u64, width: usize, value: u64| {
        let shared = uc.get_data_mut();
        shared.chip.write_far(offset as u32, width, value as u32);
        after_access(uc.get_data_mut());
    };
    uc.mmio_map(FAR.into(), BANK_BYTES.into(), Some(read), Some(write))
        .map_err(failed)
}

/// Code runs from RAM that holds data, if it is there that it runs: from now on it may. Each store then takes unicorn a long way round, in
/// case it changes code.
pub fn run_from_data(uc: &mut Unicorn<Shared>, address: u32) -> bool {
    (RAM..RAM + DATA_BYTES).contains(&address)
        && uc
            .mem_protect(RAM.into(), DATA_BYTES.into(), Prot::ALL)
            .is_ok()
}

/// Makes memory of the bank that code runs from now, if it is not that already.
pub fn map_banks(uc: &mut Unicorn<Shared>) -> Result<(), uc_error> {
    let (code, torn) = {
        let bank = uc.get_data().chip.flash.near_bank();
        (bank.bytes(), bank.torn())
    };
    if uc.mem_read_as_vec(FLASH.into(), code.len())? != code {
        for base in NEAR {
            uc.mem_write(base.into(), &code)?;
        }
        let shared = uc.get_data_mut();
        shared.costs.flash_changed(FLASH, &code);
        shared.data_cache = Default::default();
        shared.chip.transfers.set_code(&code);
    }
    for hook in std::mem::take(&mut uc.get_data_mut().watched) {
        uc.remove_hook(hook)?;
    }
    for offset in torn {
        for base in NEAR {
            let first = u64::from(base + offset);
            let hook = uc.add_mem_hook(
                HookType::MEM_READ,
                first,
                first + 7,
                move |uc, _, _, _, _| {
                    let shared = uc.get_data_mut();
                    let near = shared.chip.flash.near();
                    shared.chip.flash.note_double_error(near, offset);
                    shared.plan();
                    true
                },
            )?;
            uc.get_data_mut().watched.push(hook);
        }
    }
    Ok(())
}

/// From now on loads from the bank that code runs from take time, or none. While they do, unicorn takes a long way round for each load.
pub fn watch_loads(uc: &mut Unicorn<Shared>, watched: bool) -> Result<(), uc_error> {
    for hook in std::mem::take(&mut uc.get_data_mut().loads_watched) {
        uc.remove_hook(hook)?;
    }
    if watched {
        for base in NEAR {
            let (first, last) = (u64::from(base), u64::from(base + BANK_BYTES - 1));
            let hook =
                uc.add_mem_hook(HookType::MEM_READ, first, last, |uc, _, address, _, _| {
                    uc.get_data_mut().load(address as u32 % FLASH);
                    true
                })?;
            uc.get_data_mut().loads_watched.push(hook);
        }
    }
    // What was translated before knows nothing of it.
    uc.ctl_flush_tb()
}

/// Registers of the peripherals and of the processor.
pub fn map_registers(uc: &mut Unicorn<'static, Shared>) -> Result<()> {
    let read = |uc: &mut Unicorn<Shared>, offset: u64, width: usize| {
        let shared = uc.get_data_mut();
        let address = PERIPHERALS.0 + offset as u32;
        let held_up = shared.held_up_at(address);
        let value = shared.chip.read(address, width);
        if address == *FLASH_STATUS {
            shared.wait_for_flash();
        }
        store(uc);
        after_read(uc.get_data_mut(), held_up);
        u64::from(value)
    };
    let write = |uc: &mut Unicorn<Shared>, offset: u64, width: usize, value: u64| {
        let shared = uc.get_data_mut();
        let address = PERIPHERALS.0 + offset as u32;
        let held_up = shared.held_up_at(address);
        // The enable bit of a channel is bit 0.
        if DMA1.contains(&address) && value & 1 == 1 {
            load_sources(uc);
        }
        let shared = uc.get_data_mut();
        shared.chip.write(address, width, value as u32);
        if uc.get_data_mut().chip.take_remapped() {
            // Memory that is mapped can be written.
            let _ = map_banks(uc);
        }
        after_access(uc.get_data_mut());
        uc.get_data_mut().pass(held_up);
    };
    let (base, bytes) = PERIPHERALS;
    uc.mmio_map(base.into(), bytes.into(), Some(read), Some(write))
        .map_err(failed)?;
    let read = |uc: &mut Unicorn<Shared>, offset: u64, width: usize| {
        let value = system_read(uc.get_data_mut(), offset as u32, width);
        after_read(uc.get_data_mut(), 0);
        u64::from(value)
    };
    let write = |uc: &mut Unicorn<Shared>, offset: u64, width: usize, value: u64| {
        system_write(uc.get_data_mut(), offset as u32, width, value as u32);
        after_access(uc.get_data_mut());
    };
    let (base, bytes) = SYSTEM;
    uc.mmio_map(base.into(), bytes.into(), Some(read), Some(write))
        .map_err(failed)
}

/// An access may not stop the processor: unicorn would begin its instruction anew. The hook before the next block does.
fn after_access(shared: &mut Shared) {
    shared.plan();
    shared.pass(ACCESS_CYCLES);
}

/// The same after a read, which seldom changes anything: code that waits for the flash reads its status millions of times.
fn after_read(shared: &mut Shared, held_up: u64) {
    if shared.chip.take_changed() {
        shared.plan();
    }
    shared.pass(ACCESS_CYCLES + held_up);
}

fn system_read(shared: &mut Shared, offset: u32, width: usize) -> u32 {
    let address = SYSTEM.0 + offset;
    if crate::registers::is_peripheral(address) {
        return shared.chip.read(address, width);
    }
    let (now, cycles) = (shared.chip.now, shared.cycles);
    let findings = &mut shared.chip.findings;
    shared.system.read(offset, width, cycles, now, findings)
}

fn system_write(shared: &mut Shared, offset: u32, width: usize, value: u32) {
    let address = SYSTEM.0 + offset;
    if crate::registers::is_peripheral(address) {
        return shared.chip.write(address, width, value);
    }
    let (now, cycles, cycle) = (shared.chip.now, shared.cycles, shared.chip.cycle());
    let findings = &mut shared.chip.findings;
    let wish = shared
        .system
        .write(offset, width, value, cycles, now, cycle, findings);
    if wish == Wish::Reset {
        shared.event = Some(Event::Reset);
    }
}

/// Puts into memory what DMA has brought: before the processor goes on after a stop, when it reads a register, by which it may learn of a
/// transfer's end, and when this much waits ([`MANY`]).
pub fn store(uc: &mut Unicorn<Shared>) {
    if uc.get_data().chip.transfers.stored() == 0 {
        return;
    }
    let mut stored = uc.get_data_mut().chip.transfers.take_stored();
    // Bytes of one place stay in their order.
    stored.sort_by_key(|(address, _)| *address);
    for run in stored.chunk_by(|(before, _), (address, _)| before + 1 == *address) {
        let bytes: Vec<u8> = run.iter().map(|(_, byte)| *byte).collect();
        let _ = uc.mem_write(run[0].0.into(), &bytes);
    }
}

/// The flash controller's status register (RM0440, 3.7.5).
static FLASH_STATUS: LazyLock<u32> = LazyLock::new(|| crate::registers::address("FLASH") + 0x10);
/// DMA1's registers (stm32-metapac).
const DMA1: std::ops::Range<u32> = 0x4002_0000..0x4002_0400;

/// Tells the controller what lies in RAM where its channels take what they send: before one is switched on, from when on it may change no
/// more. Its direction must have been set by a store before that.
fn load_sources(uc: &mut Unicorn<Shared>) {
    let sources: Vec<_> = uc.get_data().chip.transfers.sources_in_ram().collect();
    for (channel, memory, bytes) in sources {
        let mut found = vec![0; bytes];
        if uc.mem_read(memory.into(), &mut found).is_ok() {
            let transfers = &mut uc.get_data_mut().chip.transfers;
            transfers.set_source(channel, memory, found);
        }
    }
}

/// Bytes of DMA's that wait at most, so that code sees them that looks at memory alone.
const MANY: usize = 16;

/// Code in the CCM RAM is what start-up has copied there: it is looked at when it first runs.
fn learn_ccm(uc: &mut Unicorn<Shared>, address: u32) {
    if (CCM..CCM + CCM_BYTES).contains(&address) && !uc.get_data().costs.knows_ccm() {
        let mut code = vec![0; CCM_BYTES as usize];
        if uc.mem_read(CCM.into(), &mut code).is_ok() {
            uc.get_data_mut().costs.learn_ccm(CCM, code);
        }
    }
}

/// Time after each block, and what unicorn cannot do itself.
pub fn add_hooks(uc: &mut Unicorn<'static, Shared>) -> Result<()> {
    uc.add_block_hook(1, 0, |uc, address, bytes| {
        if uc.get_data().chip.transfers.stored() >= MANY {
            store(uc);
        }
        learn_ccm(uc, address as u32);
        if uc.get_data_mut().block(address as u32, bytes) {
            let _ = uc.emu_stop();
        }
    })
    .map_err(failed)?;
    uc.add_intr_hook(|uc, number| {
        uc.get_data_mut().event = Some(match number {
            QEMU_EXCEPTION_RETURN => Event::ExceptionReturn,
            QEMU_SVC => Event::Supervisor,
            QEMU_BREAKPOINT => Event::Undefined,
            _ => Event::Undefined,
        });
        let _ = uc.emu_stop();
    })
    .map_err(failed)?;
    for (first, last) in FAULTY {
        uc.add_mem_hook(
            HookType::MEM_INVALID,
            first.into(),
            last.into(),
            |uc, _, address, _, _| {
                note_fault(uc.get_data_mut(), address as u32);
                false
            },
        )
        .map_err(failed)?;
    }
    Ok(())
}

/// Where an access can find nothing or be forbidden, first and last byte: everywhere but in RAM. Unicorn takes a long way round for each
/// store to a place that such a hook covers.
const FAULTY: [(u32, u32); 3] = [
    (0, CCM - 1),
    (CCM + CCM_BYTES, RAM - 1),
    (RAM + RAM_BYTES, u32::MAX),
];

/// An access that nothing answers, or a store where code lies.
fn note_fault(shared: &mut Shared, address: u32) {
    if (FLASH..FAR).contains(&address) {
        let detail = format!("a store to {address:#010x}, in the bank that code runs from");
        let now = shared.chip.now;
        shared.chip.findings.add(Rule::FlashSameBank, now, detail);
    }
    shared.event = Some(Event::Fault(address));
}
