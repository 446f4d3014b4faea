//! The sensor board's image as it ships: what the linker made, with the first stage and a header in the places that it left for them.

use crate::arm::{Arm, TARGET, run};
use crate::image_body::{self, BOARD, FLASH_START};
use anyhow::{Context, Result, ensure};
use board_link::image::{DEVELOPMENT_SEED, Image};
use courier_sensor::update::layout::{HEADER_ROOM, IMAGE_START};
use courier_sensor::update::version::Version;
use object::read::elf::{ElfFile32, ProgramHeader};
use object::{Endianness, Object, ObjectSection, ObjectSegment};
use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// The binary, and the feature, of the first stage.
const FIRST_STAGE: &str = "first-stage";
/// What an erased byte of flash reads as.
const ERASED: u8 = 0xFF;

/// Puts the first stage of the project in `folder`, and a header, into the image that was linked as `linked`; the file that ships, beside it.
///
/// The header is signed with the development key. Nobody asks: what a debug probe writes is checked by no signature.
///
/// # Errors
/// The compiler's; or a part is not as long as its place.
pub fn assemble(arm: &Arm, linked: &Path, folder: &Path, output: &Path) -> Result<PathBuf> {
    let stage = first_stage(arm, folder, output)?;
    let told = || linked.display().to_string();
    let mut image = fs::read(linked).with_context(told)?;
    let body = image_body::body(&image).with_context(told)?;
    let mut header = Image::sign(DEVELOPMENT_SEED, BOARD, Version::OWN, body)?.file();
    header.truncate(HEADER_ROOM as usize);
    let shipped = linked.with_extension("elf");
    for (section, bytes) in [(".first_stage", stage), (".header", header)] {
        let place = place(&image, section, bytes.len()).with_context(told)?;
        image[place].copy_from_slice(&bytes);
    }
    fs::write(&shipped, image).with_context(|| shipped.display().to_string())?;
    Ok(shipped)
}

/// Builds the first stage: its bytes, filled up to its room.
fn first_stage(arm: &Arm, folder: &Path, output: &Path) -> Result<Vec<u8>> {
    let mut command = arm.cargo_in("build", folder, output);
    command.args(["--quiet", "--profile", "firmware", "--bin", FIRST_STAGE]);
    command.args(["--package", "courier-sensor", "--features", FIRST_STAGE]);
    run(&mut command)?;
    let file = output.join(TARGET).join("firmware").join(FIRST_STAGE);
    let told = || file.display().to_string();
    stored(&fs::read(&file).with_context(told)?).with_context(told)
}

/// What of the first stage lies in flash, from the flash's start on.
fn stored(elf: &[u8]) -> Result<Vec<u8>> {
    let elf = ElfFile32::<Endianness>::parse(elf)?;
    let mut stored = vec![ERASED; IMAGE_START as usize];
    for segment in elf.segments() {
        let (place, bytes) = (
            segment.elf_program_header().p_paddr(elf.endian()),
            segment.data()?,
        );
        let place = place.wrapping_sub(FLASH_START) as usize;
        let room = stored.get_mut(place..place + bytes.len());
        let room = room.with_context(|| {
            format!(
                "found the first stage {} bytes long, wanted at most {IMAGE_START}",
                place + bytes.len()
            )
        });
        match bytes {
            [] => {}
            bytes => room?.copy_from_slice(bytes),
        }
    }
    Ok(stored)
}

/// Where a section of so many bytes lies in the file.
fn place(elf: &[u8], name: &str, wanted: usize) -> Result<Range<usize>> {
    let elf = ElfFile32::<Endianness>::parse(elf)?;
    let range = elf.section_by_name(name).and_then(|it| it.file_range());
    let (start, length) = range.with_context(|| format!("found no section {name}, wanted one"))?;
    ensure!(
        length == wanted as u64,
        "found {length} bytes of {name}, wanted {wanted}"
    );
    Ok(start as usize..start as usize + wanted)
}
