//! The image as a file, and what the factory writes into the chip.

use crate::peripheral::adc;
use anyhow::{Context, Result, ensure};
use object::read::elf::ElfFile32;
use object::read::elf::ProgramHeader;
use object::{Endianness, Object, ObjectSymbol};
use std::path::{Path, PathBuf};

/// An image.
pub struct Image {
    path: PathBuf,
    bytes: Vec<u8>,
}

impl Image {
    /// Reads it.
    ///
    /// # Errors
    /// There is no such file.
    pub fn open(path: &Path) -> Result<Self> {
        let bytes = std::fs::read(path).with_context(|| path.display().to_string())?;
        let path = path.to_path_buf();
        Ok(Self { path, bytes })
    }

    fn elf(&self) -> Result<ElfFile32<'_, Endianness>> {
        let told = || format!("{}: not an image", self.path.display());
        ElfFile32::parse(&*self.bytes).with_context(told)
    }

    /// A bank of flash as a programmer would leave it: the image's segments where they are stored, the rest erased.
    ///
    /// # Errors
    /// The file is no image, or does not fit.
    pub fn flash(&self, base: u32, bytes: usize) -> Result<Vec<u8>> {
        let elf = self.elf()?;
        let endian = elf.endian();
        let mut flash = vec![0xFF; bytes];
        for header in elf.elf_program_headers() {
            let stored = header.data(endian, &*self.bytes);
            let stored =
                stored.map_err(|()| anyhow::anyhow!("{}: cut off", self.path.display()))?;
            if header.p_type(endian) != object::elf::PT_LOAD || stored.is_empty() {
                continue;
            }
            let at = header.p_paddr(endian).wrapping_sub(base) as usize;
            ensure!(
                at + stored.len() <= bytes,
                "{}: found a segment at {:#010x}, wanted all in bank 1",
                self.path.display(),
                header.p_paddr(endian)
            );
            flash[at..][..stored.len()].copy_from_slice(stored);
        }
        Ok(flash)
    }

    /// Address of a symbol.
    ///
    /// # Errors
    /// There is none of that name.
    pub fn symbol(&self, name: &str) -> Result<u32> {
        let elf = self.elf()?;
        let found = elf.symbols().find(|symbol| symbol.name() == Ok(name));
        let told = || format!("{}: no symbol {name}", self.path.display());
        Ok(found.with_context(told)?.address() as u32)
    }
}

/// Where the chip's own number lies, 12 bytes (RM0440, 48.1).
pub const NUMBER: u32 = 0x1FFF_7590;

/// What the factory writes into the system memory: the chip's number, the size of its flash, the temperature sensor's readings.
pub fn factory_values() -> Vec<(u32, Vec<u8>)> {
    let [low, high] = adc::CALIBRATION.map(|reading| reading.to_le_bytes().to_vec());
    vec![
        // RM0440, 48.1 and 48.2; DS12288, temperature sensor.
        (NUMBER, b"chip-model-1".to_vec()),
        (0x1FFF_75E0, 512u16.to_le_bytes().to_vec()),
        (0x1FFF_75A8, low),
        (0x1FFF_75CA, high),
    ]
}
