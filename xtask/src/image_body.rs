//! What goes into a bank of the board's flash behind an image's header.

use anyhow::{Result, ensure};
use courier_sensor::update::layout::{BODY_START, IMAGE_END};
use object::Endianness;
use object::read::elf::{ElfFile32, ProgramHeader};
use object::{Object, ObjectSegment};
use std::ops::Range;

/// Name of the board, and of its binary.
pub const BOARD: &str = "g474";
/// Where a bank begins when it is the one that runs (RM0440, memory map), and the RAM that a stack may lie in.
pub const FLASH_START: u32 = 0x0800_0000;
const BODY_ADDRESS: u32 = FLASH_START + BODY_START;
const RAM: Range<u32> = 0x2000_0000..0x2002_0001;
/// What an erased byte of flash reads as.
const ERASED: u8 = 0xFF;

/// What goes into flash behind the header, of an image that is linked to lie there.
///
/// # Errors
/// It is no such image.
pub fn body(elf: &[u8]) -> Result<Vec<u8>> {
    let elf = ElfFile32::<Endianness>::parse(elf)?;
    let mut segments = vec![];
    for segment in elf.segments() {
        let place = segment.elf_program_header().p_paddr(elf.endian());
        // First stage and header have places of their own before it.
        if !(FLASH_START..BODY_ADDRESS).contains(&place) {
            segments.push((place, segment.data()?));
        }
    }
    let body = placed(&segments)?;
    check_vectors(&body)?;
    Ok(body)
}

/// Bytes with their places in flash, put together; gaps are as erased.
fn placed(segments: &[(u32, &[u8])]) -> Result<Vec<u8>> {
    let room = BODY_ADDRESS..FLASH_START + IMAGE_END;
    let mut body = vec![];
    for (start, bytes) in segments.iter().filter(|(_, bytes)| !bytes.is_empty()) {
        let end = start + bytes.len() as u32;
        ensure!(
            room.contains(start) && end <= room.end,
            "found bytes at {start:#x} to {end:#x}, wanted them within {:#x} to {:#x}",
            room.start,
            room.end
        );
        let (from, to) = ((start - room.start) as usize, (end - room.start) as usize);
        body.resize(body.len().max(to), ERASED);
        body[from..to].copy_from_slice(bytes);
    }
    Ok(body)
}

/// The vectors come first: the stack's start in RAM, and the reset's address in the body.
fn check_vectors(body: &[u8]) -> Result<()> {
    let word = |place: usize| {
        let bytes = body.get(place..).and_then(<[u8]>::first_chunk);
        u32::from_le_bytes(*bytes.unwrap_or(&[0; 4]))
    };
    let (stack, reset) = (word(0), word(4));
    let code = BODY_ADDRESS..BODY_ADDRESS + body.len() as u32;
    ensure!(
        RAM.contains(&stack) && reset % 2 == 1 && code.contains(&reset),
        "found {stack:#x} and {reset:#x} as its first words, wanted a stack in RAM and a Thumb address in the image"
    );
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_are_put_where_they_lie_and_none_beyond_the_image() {
        let start = BODY_ADDRESS;
        let body = placed(&[(start + 8, &[1, 2]), (start, &[3]), (0, &[])]).unwrap();
        assert_eq!(body, [3, 255, 255, 255, 255, 255, 255, 255, 1, 2]);
        for place in [FLASH_START, start - 1, FLASH_START + IMAGE_END - 1] {
            assert!(placed(&[(place, &[0; 2])]).is_err(), "{place:#x}");
        }
    }

    #[test]
    fn vectors_are_a_stack_in_ram_and_code_in_the_image() {
        let body = |stack: u32, reset: u32| {
            let mut body = vec![0; 100];
            body[..4].copy_from_slice(&stack.to_le_bytes());
            body[4..8].copy_from_slice(&reset.to_le_bytes());
            check_vectors(&body).is_ok()
        };
        assert!(body(0x2000_1000, BODY_ADDRESS + 9));
        assert!(!body(0x0800_1000, BODY_ADDRESS + 9));
        assert!(!body(0x2000_1000, BODY_ADDRESS + 8));
        assert!(!body(0x2000_1000, FLASH_START + 9));
        assert!(check_vectors(&[]).is_err());
    }
}
