//! `cargo xtask image`: the sensor board's firmware as a file that `courier update` sends, signed (`docs/update.md`).

use crate::arm;
use crate::firmware;
use crate::image_body::{BOARD, body};
use anyhow::{Context, Result, bail};
use board_link::image::{DEVELOPMENT_SEED, Image, public_half};
use courier_sensor::update::key;
use courier_sensor::update::version::Version;
use std::fs::{self, OpenOptions};
use std::io::Write as _;
use std::path::{Path, PathBuf};

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
