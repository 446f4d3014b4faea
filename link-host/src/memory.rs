//! Memory of a target that runs meanwhile.

use anyhow::Result;

/// Reads and writes the target's memory. Words are 32 bits, aligned, and arrive whole.
pub trait TargetMemory {
    /// Fills `bytes` from `address` on.
    ///
    /// # Errors
    /// The address is not memory, or the target cannot be reached.
    fn read(&mut self, address: u32, bytes: &mut [u8]) -> Result<()>;

    /// Writes `bytes` from `address` on.
    ///
    /// # Errors
    /// As [`TargetMemory::read`].
    fn write(&mut self, address: u32, bytes: &[u8]) -> Result<()>;

    /// One word.
    ///
    /// # Errors
    /// As [`TargetMemory::read`].
    fn read_word(&mut self, address: u32) -> Result<u32> {
        let mut bytes = [0; 4];
        self.read(address, &mut bytes)?;
        Ok(u32::from_le_bytes(bytes))
    }

    /// One word.
    ///
    /// # Errors
    /// As [`TargetMemory::read`].
    fn write_word(&mut self, address: u32, word: u32) -> Result<()> {
        self.write(address, &word.to_le_bytes())
    }
}
