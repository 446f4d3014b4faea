//! Pages of the file that backs the guest's memory.

use std::fs::OpenOptions;
use std::os::fd::AsRawFd;

const PAGE: u64 = 4096;

/// Maps the page of `file` that holds `offset` and returns a pointer to `offset`. The mapping is never given back.
pub fn page(file: &str, offset: u64) -> Result<*mut u8, String> {
    let opened = OpenOptions::new()
        .read(true)
        .write(true)
        .open(file)
        .map_err(|e| format!("{file}: {e}"))?;
    let length = opened.metadata().map_err(|e| format!("{file}: {e}"))?.len();
    if offset % 8 != 0 || offset + 256 > length || offset % PAGE + 256 > PAGE {
        return Err(format!(
            "{file}: no room for 256 bytes at {offset:#x} within one page"
        ));
    }
    let start = offset / PAGE * PAGE;
    // SAFETY: a new mapping of a file that is long enough.
    let base = unsafe {
        let protection = libc::PROT_READ | libc::PROT_WRITE;
        libc::mmap(
            std::ptr::null_mut(),
            PAGE as usize,
            protection,
            libc::MAP_SHARED,
            opened.as_raw_fd(),
            start as i64,
        )
    };
    if base == libc::MAP_FAILED {
        return Err(format!(
            "{file}: cannot be mapped: {}",
            std::io::Error::last_os_error()
        ));
    }
    // SAFETY: within the page, checked above.
    Ok(unsafe { base.cast::<u8>().add((offset % PAGE) as usize) })
}
