//! The few functions of QEMU's plugin interface that are used, and the instructions of a block as decoded.

use std::ffi::{c_int, c_uint, c_void};
use thumb::{Instruction, decode};

/// A plugin's own number.
pub type Id = u64;

/// A translation block, opaque.
#[repr(C)]
pub struct Block(());

/// An instruction of one, opaque.
#[repr(C)]
pub struct Handle(());

/// Called when a block or an instruction runs.
pub type Callback = extern "C" fn(c_uint, *mut c_void);

unsafe extern "C" {
    pub fn qemu_plugin_register_vcpu_tb_trans_cb(id: Id, callback: extern "C" fn(Id, *mut Block));
    pub fn qemu_plugin_register_vcpu_tb_exec_cb(
        block: *mut Block,
        callback: Callback,
        flags: c_int,
        user: *mut c_void,
    );
    pub fn qemu_plugin_register_vcpu_insn_exec_cb(
        handle: *mut Handle,
        callback: Callback,
        flags: c_int,
        user: *mut c_void,
    );
    pub fn qemu_plugin_register_vcpu_insn_exec_inline(
        handle: *mut Handle,
        operation: c_int,
        pointer: *mut c_void,
        value: u64,
    );
    fn qemu_plugin_tb_n_insns(block: *const Block) -> usize;
    fn qemu_plugin_tb_get_insn(block: *const Block, index: usize) -> *mut Handle;
    fn qemu_plugin_insn_data(handle: *const Handle) -> *const u8;
    fn qemu_plugin_insn_vaddr(handle: *const Handle) -> u64;
}

/// One instruction of the block being translated.
pub struct Translated {
    /// For QEMU's functions, during this translation only.
    pub handle: *mut Handle,
    /// Where it lies in the guest.
    pub address: u64,
    /// What it is.
    pub instruction: Instruction,
}

/// All instructions of a block.
///
/// # Safety
/// `block` is the one that QEMU is translating.
pub unsafe fn instructions(block: *mut Block) -> Vec<Translated> {
    // SAFETY: the caller's promise. An instruction's data holds its 2 or 4 bytes; QEMU 7.2 can claim 2 too many for the one
    // before a page's end, so the length comes from the first halfword (those from 0xe800 up have a second).
    unsafe {
        let count = qemu_plugin_tb_n_insns(block);
        (0..count)
            .map(|index| {
                let handle = qemu_plugin_tb_get_insn(block, index);
                let data = qemu_plugin_insn_data(handle);
                let size = if *data.add(1) >= 0xe8 { 4 } else { 2 };
                let instruction = decode(std::slice::from_raw_parts(data, size));
                Translated {
                    handle,
                    address: qemu_plugin_insn_vaddr(handle),
                    instruction,
                }
            })
            .collect()
    }
}
