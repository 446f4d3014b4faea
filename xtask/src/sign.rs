//! `cargo xtask image`: the sensor board's firmware as a file that `courier update` sends, signed (`docs/update.md`).

use crate::arm;
use crate::firmware;
use anyhow::{Context, Result, bail, ensure};
use board_link::image::{DEVELOPMENT_SEED, Image, public_half};
use courier_sensor::update::key;
use courier_sensor::update::layout::{BODY_START, IMAGE_END};
use courier_sensor::update::version::Version;
use object::Endianness;
use object::read::elf::{ElfFile32, ProgramHeader};
use object::{Object, ObjectSegment};
use std::fs::{self, OpenOptions};
use std::io::Write as _;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Name of the board, and of its binary.
pub const BOARD: &str = "g474";
/// Where a bank begins when it is the one that runs (RM0440, memory map), and the RAM that a stack may lie in.
pub const FLASH_START: u32 = 0x0800_0000;
const BODY_ADDRESS: u32 = FLASH_START + BODY_START;
const RAM: Range<u32> = 0x2000_0000..0x2002_0001;
/// What an erased byte of flash reads as.
const ERASED: u8 = 0xFF;
/// Secret keys are 32 bytes in hexadecimal digits.
const SEED_BYTES: usize = 32;

/// What the command's words ask for.
#[derive(Debug, PartialEq, Eq)]
enum Asked {
    /// An image into this file, signed with the secret key in that one.
    Image { out: PathBuf, key: Option<PathBuf> },
    /// A new secret key in this file.
    NewKey(PathBuf),
}

/// The command. Words: `OUT [--key FILE]`, or `--new-key FILE`.
///
/// # Errors
/// The image cannot be built or is none, or a file cannot be read or written.
pub fn run(arguments: &[String]) -> Result<()> {
    match asked(arguments)? {
        Asked::NewKey(file) => new_key(&file),
        Asked::Image { out, key } => image(&out, key.as_deref()),
    }
}

fn asked(arguments: &[String]) -> Result<Asked> {
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words[..] {
        ["--new-key", file] => Ok(Asked::NewKey(file.into())),
        [out] if !out.starts_with('-') => Ok(Asked::Image {
            out: out.into(),
            key: None,
        }),
        [out, "--key", key] if !out.starts_with('-') => Ok(Asked::Image {
            out: out.into(),
            key: Some(key.into()),
        }),
        _ => bail!("found {arguments:?}, wanted OUT [--key FILE], or --new-key FILE"),
    }
}

fn image(out: &Path, key: Option<&Path>) -> Result<()> {
    let seed = match key {
        Some(file) => read_seed(file)?,
        None => DEVELOPMENT_SEED,
    };
    let elf = firmware::build(&arm::ensure()?, BOARD)?;
    let bytes = fs::read(&elf).with_context(|| elf.display().to_string())?;
    let body = body(&bytes).with_context(|| elf.display().to_string())?;
    let image = Image::sign(seed, BOARD, Version::OWN, body)?;
    fs::write(out, image.file()).with_context(|| out.display().to_string())?;
    let whose = match key::is_development(&image.header.key) {
        true => "the development key: anybody can sign with it".to_owned(),
        false => format!("key {}", hex(&image.header.key)),
    };
    println!(
        "{}: {BOARD} {}, {} bytes, signed with {whose}",
        out.display(),
        image.header.version,
        image.body.len()
    );
    Ok(())
}

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

/// Makes a secret key; its public half goes to standard output.
fn new_key(file: &Path) -> Result<()> {
    let mut seed = [0; SEED_BYTES];
    getrandom::fill(&mut seed).map_err(|error| anyhow::anyhow!("random numbers: {error}"))?;
    let mut options = OpenOptions::new();
    // One that is there may be all that can update a board.
    options.write(true).create_new(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    let mut opened = options
        .open(file)
        .with_context(|| file.display().to_string())?;
    writeln!(opened, "{}", hex(&seed))?;
    println!("COURIER_UPDATE_KEY={}", hex(&public_half(seed)));
    Ok(())
}

fn read_seed(file: &Path) -> Result<[u8; SEED_BYTES]> {
    let text = fs::read_to_string(file).with_context(|| file.display().to_string())?;
    key::parse(text.trim()).with_context(|| {
        format!(
            "{}: found something else, wanted a secret key: 64 hexadecimal digits",
            file.display()
        )
    })
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(text: &str) -> Vec<String> {
        text.split_whitespace().map(str::to_owned).collect()
    }

    #[test]
    fn its_words_are_a_file_and_a_key() {
        let image = |key: Option<&str>| Asked::Image {
            out: "a.img".into(),
            key: key.map(PathBuf::from),
        };
        assert_eq!(asked(&words("a.img")).unwrap(), image(None));
        assert_eq!(asked(&words("a.img --key k")).unwrap(), image(Some("k")));
        let new = asked(&words("--new-key k")).unwrap();
        assert_eq!(new, Asked::NewKey("k".into()));
        for wrong in ["", "--key k", "a.img --key", "a.img b", "--new-key"] {
            assert!(asked(&words(wrong)).is_err(), "{wrong}");
        }
    }

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

    #[test]
    fn a_new_key_is_written_once_and_signs() {
        let file = std::env::temp_dir().join(format!("courier-key-{}", std::process::id()));
        let _ = fs::remove_file(&file);
        new_key(&file).unwrap();
        let seed = read_seed(&file).unwrap();
        assert!(new_key(&file).is_err(), "it would be lost");
        assert_eq!(read_seed(&file).unwrap(), seed);
        fs::remove_file(&file).unwrap();
        let image = Image::sign(seed, BOARD, Version::OWN, vec![0; 8]).unwrap();
        assert_eq!(image.header.key, public_half(seed));
    }
}
