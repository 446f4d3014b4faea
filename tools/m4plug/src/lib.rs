//! QEMU TCG plugin (API version 1, QEMU 7.2 and later 8.x; its header is not needed).
//!
//! `-plugin libm4plug.so,ram=FILE[,count=OFFSET][,bell=ADDRESS,post=OFFSET]`
//!
//! `ram` is the file that backs the guest's memory, offsets are into it.
//! * `count`: counters, kept there for the guest to read like a cycle counter (layout: [`counters`]).
//! * `bell`: when the guest executes the instruction at ADDRESS, the two words at `post` are its hand-over to a host process:
//!   the first is incremented and the guest stands still, its virtual time too, until the second equals it ([`lockstep`]).
#![allow(unsafe_code)] // a C interface and memory shared with another process are what this crate is

mod counters;
mod lockstep;
mod qemu;
mod shared;

use qemu::{Block, Id};
use std::ffi::{CStr, c_char, c_int, c_uint, c_void};
use std::sync::OnceLock;

/// The interface version that this plugin speaks; QEMU looks for the symbol.
#[unsafe(no_mangle)]
#[allow(non_upper_case_globals)]
pub static qemu_plugin_version: c_int = 1;

/// What was asked for on the command line.
struct Setup {
    counters: Option<counters::Counters>,
    bell: Option<lockstep::Bell>,
}

// SAFETY: the pointers inside lead into a mapping that lives as long as the process; QEMU runs one guest processor.
unsafe impl Send for Setup {}
// SAFETY: as above.
unsafe impl Sync for Setup {}

static SETUP: OnceLock<Setup> = OnceLock::new();

/// Called by QEMU once, with the words after the plugin's name.
///
/// # Safety
/// `argv` holds `argc` zero-terminated strings.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn qemu_plugin_install(
    id: Id,
    _info: *const c_void,
    argc: c_int,
    argv: *const *const c_char,
) -> c_int {
    let words = (0..argc as usize).map(|k| {
        // SAFETY: the caller's promise.
        unsafe { CStr::from_ptr(*argv.add(k)) }
            .to_string_lossy()
            .into_owned()
    });
    match parse(words) {
        Ok(setup) => {
            let _ = SETUP.set(setup);
            // SAFETY: QEMU's own function, called where it may be.
            unsafe { qemu::qemu_plugin_register_vcpu_tb_trans_cb(id, translate) };
            0
        }
        Err(why) => {
            eprintln!("m4plug: {why}");
            -1
        }
    }
}

fn parse(words: impl Iterator<Item = String>) -> Result<Setup, String> {
    let (mut ram, mut count, mut bell, mut post) = (None, None, None, None);
    for word in words {
        let (name, value) = word
            .split_once('=')
            .ok_or(format!("found {word:?}, wanted NAME=VALUE"))?;
        let number = || {
            let digits = value.trim_start_matches("0x");
            u64::from_str_radix(digits, 16)
                .map_err(|_| format!("{name}: found {value:?}, wanted a hexadecimal number"))
        };
        match name {
            "ram" => ram = Some(value.to_owned()),
            "count" => count = Some(number()?),
            "bell" => bell = Some(number()? & !1),
            "post" => post = Some(number()?),
            _ => return Err(format!("found {name:?}, wanted ram, count, bell or post")),
        }
    }
    let file = ram.ok_or("ram is missing")?;
    let page = |offset| shared::page(&file, offset);
    let counters = count
        .map(|at| page(at).map(counters::Counters::new))
        .transpose()?;
    let bell = match (bell, post) {
        (Some(address), Some(at)) => Some(lockstep::Bell::new(address, page(at)?)),
        (None, None) => None,
        _ => return Err("bell and post go together".into()),
    };
    Ok(Setup { counters, bell })
}

/// A block of guest code was translated: attach what must happen when it runs.
extern "C" fn translate(_: Id, block: *mut Block) {
    let Some(setup) = SETUP.get() else { return };
    // SAFETY: `block` is valid during this call, which is all these use it for.
    let instructions = unsafe { qemu::instructions(block) };
    if let Some(counters) = &setup.counters {
        counters.attach(block, &instructions);
    }
    if let Some(bell) = &setup.bell {
        for instruction in instructions.iter().filter(|i| i.address == bell.address()) {
            // SAFETY: QEMU's own function; the handle is of the block being translated.
            unsafe {
                qemu::qemu_plugin_register_vcpu_insn_exec_cb(
                    instruction.handle,
                    ring,
                    0,
                    std::ptr::null_mut(),
                );
            }
        }
    }
}

extern "C" fn ring(_: c_uint, _: *mut c_void) {
    if let Some(bell) = SETUP.get().and_then(|setup| setup.bell.as_ref()) {
        bell.ring();
    }
}
