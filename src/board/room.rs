//! Makes a session in the memory that all kinds of sessions share, in its place.
//!
//! An assignment would make the new session on the stack first: 57 KiB. A session of zeros is a valid value, of which the compiler is
//! asked below, so memory is cleared instead.
#![allow(unsafe_code)] // the layout of an enum, and values made of zeros

use crate::app::task::Task;
use crate::calibration::Service;
use crate::calibration::Session;
use crate::calibration::joint::JointSession;
use core::mem::MaybeUninit;

// SAFETY: the compiler looks at every constant: one that is no valid value of its type is an error (E0080).
const _: Session = unsafe { MaybeUninit::zeroed().assume_init() };
// SAFETY: as above.
const _: JointSession = unsafe { MaybeUninit::zeroed().assume_init() };
// SAFETY: as above.
const _: Service = unsafe { MaybeUninit::zeroed().assume_init() };

/// A platen session of zeros.
pub fn platen(task: &mut Task) {
    clear(task, Task::PLATEN);
}

/// A joint session of zeros.
pub fn joint(task: &mut Task) {
    clear(task, Task::JOINT);
}

/// What runs between calibrations, of zeros.
pub fn watch(task: &mut Task) {
    clear(task, Task::WATCH);
}

fn clear(task: &mut Task, tag: u8) {
    let place = core::ptr::from_mut(task).cast::<u8>();
    // SAFETY: `Task` is `repr(u8)`: its first byte says which variant it is (Rust reference, "primitive representation of field-carrying
    // enums"), and the variant's session may be zeros, see the constants above. Nothing in a task is ever dropped.
    unsafe {
        place.write_bytes(0, size_of::<Task>());
        place.write(tag);
    }
}
