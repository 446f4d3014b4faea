//! The emulated board's RAM: a file that QEMU maps as guest memory and this process maps as well.
#![allow(unsafe_code)] // memory shared with another process

use crate::memory::TargetMemory;
use anyhow::{Context, Result, ensure};
use courier_sensor::emulation::{RAM_BASE, RAM_BYTES};
use std::fs::OpenOptions;
use std::os::fd::AsRawFd;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering::SeqCst, fence};
use std::time::Duration;

/// The mapped RAM; its file is removed when this is dropped.
#[derive(Debug)]
pub struct SharedRam {
    base: *mut u8,
    path: PathBuf,
}

impl SharedRam {
    /// A new file of zeros, mapped.
    ///
    /// # Errors
    /// It cannot be made or mapped.
    pub fn create() -> Result<Self> {
        static NUMBER: AtomicU64 = AtomicU64::new(0);
        let memory = Path::new("/dev/shm");
        let folder = if memory.is_dir() {
            memory.to_path_buf()
        } else {
            std::env::temp_dir()
        };
        let number = NUMBER.fetch_add(1, SeqCst);
        let path = folder.join(format!("courier-board-{}-{number}", std::process::id()));
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(true)
            .open(&path);
        let file = file.with_context(|| path.display().to_string())?;
        file.set_len(RAM_BYTES as u64)
            .with_context(|| path.display().to_string())?;
        // SAFETY: a new shared mapping of a file of this length.
        let base = unsafe {
            let protection = libc::PROT_READ | libc::PROT_WRITE;
            libc::mmap(
                std::ptr::null_mut(),
                RAM_BYTES,
                protection,
                libc::MAP_SHARED,
                file.as_raw_fd(),
                0,
            )
        };
        ensure!(
            base != libc::MAP_FAILED,
            "{}: {}",
            path.display(),
            std::io::Error::last_os_error()
        );
        Ok(Self {
            base: base.cast(),
            path,
        })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Takes the file's name away; who has it open keeps the memory.
    pub fn unlink(&self) {
        let _ = std::fs::remove_file(&self.path);
    }

    fn place(&self, address: u32, length: usize) -> Result<*mut u8> {
        let offset = address.wrapping_sub(RAM_BASE) as usize;
        let inside = offset
            .checked_add(length)
            .is_some_and(|end| end <= RAM_BYTES);
        ensure!(
            inside,
            "{address:#x}: {length} bytes are not in the board's RAM"
        );
        // SAFETY: within the mapping, checked above.
        Ok(unsafe { self.base.add(offset) })
    }

    /// A word that both sides use at the same time.
    ///
    /// # Errors
    /// It is not in the RAM or not aligned.
    pub fn word(&self, address: u32) -> Result<&AtomicU32> {
        ensure!(address.is_multiple_of(4), "{address:#x}: not aligned");
        let place = self.place(address, 4)?;
        // SAFETY: aligned, within the mapping, which lives as long as the reference; shared as atomics.
        Ok(unsafe { &*place.cast() })
    }

    /// Wakes who sleeps on a word.
    pub fn wake(word: &AtomicU32) {
        // SAFETY: a futex call on a mapped word.
        unsafe { libc::syscall(libc::SYS_futex, word.as_ptr(), libc::FUTEX_WAKE, 1) };
    }

    /// Sleeps until a word is no longer `seen`, somebody wakes it, or `most` is over.
    pub fn sleep(word: &AtomicU32, seen: u32, most: Duration) {
        let nap = libc::timespec {
            tv_sec: most.as_secs() as i64,
            tv_nsec: i64::from(most.subsec_nanos()),
        };
        // SAFETY: a futex call on a mapped word; the time lives through it.
        unsafe { libc::syscall(libc::SYS_futex, word.as_ptr(), libc::FUTEX_WAIT, seen, &nap) };
    }
}

impl TargetMemory for SharedRam {
    fn read(&mut self, address: u32, bytes: &mut [u8]) -> Result<()> {
        let place = self.place(address, bytes.len())?;
        fence(SeqCst);
        // SAFETY: `place` says that so many bytes are there; the board stands still or the rings' indices keep it away.
        unsafe { std::ptr::copy_nonoverlapping(place, bytes.as_mut_ptr(), bytes.len()) };
        Ok(())
    }

    fn write(&mut self, address: u32, bytes: &[u8]) -> Result<()> {
        let place = self.place(address, bytes.len())?;
        // SAFETY: as above.
        unsafe { std::ptr::copy_nonoverlapping(bytes.as_ptr(), place, bytes.len()) };
        fence(SeqCst);
        Ok(())
    }

    fn read_word(&mut self, address: u32) -> Result<u32> {
        Ok(self.word(address)?.load(SeqCst))
    }

    fn write_word(&mut self, address: u32, word: u32) -> Result<()> {
        self.word(address)?.store(word, SeqCst);
        Ok(())
    }
}

impl Drop for SharedRam {
    fn drop(&mut self) {
        // SAFETY: the mapping made in `create`; no reference into it outlives this.
        unsafe { libc::munmap(self.base.cast(), RAM_BYTES) };
        self.unlink();
    }
}
