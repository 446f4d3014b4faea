//! A process that does not outlive this one, however this one ends.
#![allow(unsafe_code)] // a system call between fork and exec

use std::os::unix::process::CommandExt;
use std::process::Command;

/// The kernel ends the process when this one is gone.
pub fn tie(command: &mut Command) -> &mut Command {
    // SAFETY: prctl is async-signal-safe and touches no memory.
    unsafe {
        command.pre_exec(|| {
            libc::prctl(libc::PR_SET_PDEATHSIG, libc::SIGKILL);
            Ok(())
        })
    }
}
