//! In the place of the emulated board's shared RAM where the system is not Linux: there is none, so nothing here is ever reached.

use crate::memory::TargetMemory;
use anyhow::{Result, bail};
use std::path::Path;
use std::sync::atomic::AtomicU32;
use std::time::Duration;

/// No memory.
#[derive(Debug)]
pub enum SharedRam {}

impl SharedRam {
    /// Refuses.
    ///
    /// # Errors
    /// Always.
    pub fn create() -> Result<Self> {
        super::supported()?;
        bail!("the emulated board: found no memory shared with QEMU, wanted Linux")
    }

    /// The file.
    pub fn path(&self) -> &Path {
        match *self {}
    }

    /// Takes the file's name away.
    pub fn unlink(&self) {
        match *self {}
    }

    /// A word that both sides use at the same time.
    ///
    /// # Errors
    /// Never reached.
    pub fn word(&self, _address: u32) -> Result<&AtomicU32> {
        match *self {}
    }

    /// Wakes who sleeps on a word: nobody.
    pub fn wake(_word: &AtomicU32) {}

    /// Sleeps until somebody wakes it: not at all.
    pub fn sleep(_word: &AtomicU32, _seen: u32, _most: Duration) {}
}

impl TargetMemory for SharedRam {
    fn read(&mut self, _address: u32, _bytes: &mut [u8]) -> Result<()> {
        match *self {}
    }

    fn write(&mut self, _address: u32, _bytes: &[u8]) -> Result<()> {
        match *self {}
    }

    fn read_word(&mut self, _address: u32) -> Result<u32> {
        match *self {}
    }

    fn write_word(&mut self, _address: u32, _word: u32) -> Result<()> {
        match *self {}
    }
}
