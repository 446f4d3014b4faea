//! Where a report comes from: the date, this program, its command line, and the hashes of what it read.

use anyhow::{Context, Result};
use recording::Recording;
use report::advice::word;
use report::html::{Origin, stated};
use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};
use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;

/// Files of a recording.
const FILES: [&str; 2] = ["recording.toml", "samples.csv"];

/// Of a report about nothing that was read: the date, the program and its command line.
#[must_use]
pub fn origin() -> Origin {
    let now = OffsetDateTime::now_utc().replace_nanosecond(0);
    let made = now.ok().and_then(|now| now.format(&Rfc3339).ok());
    let words = std::env::args().skip(1).map(|argument| word(&argument));
    let command: Vec<String> = std::iter::once("courier".to_owned()).chain(words).collect();
    Origin {
        made: made.unwrap_or_default(),
        program: concat!("courier ", env!("CARGO_PKG_VERSION")).into(),
        command: command.join(" "),
        ..Origin::default()
    }
}

/// Of a report about a recording; `model` is where its model is written.
///
/// # Errors
/// A file of the recording can no longer be read.
pub fn origin_of(folder: &Path, recording: &Recording, model: Option<&Path>) -> Result<Origin> {
    let one = |file: PathBuf| {
        let name = file.file_name().unwrap_or(file.as_os_str());
        Ok((name.to_string_lossy().into_owned(), hash(&file)?))
    };
    Ok(Origin {
        hashes: files(folder).into_iter().map(one).collect::<Result<_>>()?,
        model: model.map(|path| path.display().to_string()),
        stated: stated(&recording.meta),
        ..origin()
    })
}

/// Of a report about files, and recordings in folders.
///
/// # Errors
/// One can no longer be read.
pub fn origin_of_files(paths: &[PathBuf]) -> Result<Origin> {
    let one = |file: PathBuf| Ok((file.display().to_string(), hash(&file)?));
    Ok(Origin {
        hashes: paths
            .iter()
            .flat_map(|path| files(path))
            .map(one)
            .collect::<Result<_>>()?,
        ..origin()
    })
}

/// The files of a recording in a folder, or the one file that there is.
#[must_use]
pub fn files(path: &Path) -> Vec<PathBuf> {
    match path.is_dir() {
        true => FILES.map(|name| path.join(name)).to_vec(),
        false => vec![path.to_owned()],
    }
}

/// SHA-256 of a file, in hexadecimal.
fn hash(path: &Path) -> Result<String> {
    let told = || format!("{}: wanted a file that can still be read", path.display());
    let bytes = Sha256::digest(std::fs::read(path).with_context(told)?);
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hash_is_that_of_the_bytes() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        std::fs::write(&path, "abc").unwrap();
        // FIPS 180-2, appendix B.1.
        let wanted = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(hash(&path).unwrap(), wanted);
        std::fs::remove_file(&path).unwrap();
        assert!(hash(&path).is_err());
    }

    #[test]
    fn an_origin_tells_when_and_by_what() {
        let origin = origin();
        assert!(
            OffsetDateTime::parse(&origin.made, &Rfc3339).is_ok(),
            "{origin:?}"
        );
        assert!(origin.program.starts_with("courier "), "{origin:?}");
    }
}
