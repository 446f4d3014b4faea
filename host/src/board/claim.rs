//! One command at a time for what several could reach: a board's flash in a file, a debug probe.
//!
//! A claim is a locked file beside what is claimed; the system gives the lock back however the command ends. Who holds it is
//! written in the file.

use anyhow::{Context, Result, bail};
use same_file::Handle;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read as _, Write as _};
use std::path::{Path, PathBuf};

/// A claim on something; given back when it is dropped.
#[derive(Debug)]
pub struct Claim {
    path: PathBuf,
    /// Locked for as long as it is open.
    _file: File,
}

/// Longest text in the file that is believed, bytes.
const HOLDER_BYTES: u64 = 400;

impl Claim {
    /// Claims the file `path`; `what` names it for people.
    ///
    /// # Errors
    /// Another command has it, which is named, or its folder cannot be written.
    pub fn of_file(path: &Path, what: &str) -> Result<Self> {
        // Links lead to one file, and that is claimed.
        let path = std::fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        let name = path
            .file_name()
            .with_context(|| format!("{what}: found no file name, wanted a file"))?;
        let lock = path.with_file_name(format!(".{}.lock", name.to_string_lossy()));
        Self::take(lock, what)
    }

    /// Claims something that is no file and has this name on this machine.
    ///
    /// # Errors
    /// As [`Claim::of_file`].
    pub fn of_name(name: &str, what: &str) -> Result<Self> {
        let plain: String = name
            .chars()
            .map(|c| if c.is_ascii_alphanumeric() { c } else { '-' })
            .collect();
        let lock = std::env::temp_dir().join(format!("courier-{plain}.lock"));
        Self::take(lock, what)
    }

    fn take(path: PathBuf, what: &str) -> Result<Self> {
        let wanted = || {
            format!(
                "{what}: {}: wanted a file that can be locked",
                path.display()
            )
        };
        loop {
            let mut file = OpenOptions::new()
                .create(true)
                .truncate(false)
                .read(true)
                .write(true)
                .open(&path)
                .with_context(wanted)?;
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => bail!(
                    "{what}: found it in use by {}, wanted it free: try again when that has ended",
                    holder(&mut file)
                ),
                Err(TryLockError::Error(error)) => return Err(error).with_context(wanted),
            }
            // Whoever had it before may have taken its file away after it was opened here: that lock is worth nothing.
            let here = Handle::from_file(file.try_clone().with_context(wanted)?);
            if Handle::from_path(&path).ok() != here.ok() {
                continue;
            }
            file.set_len(0).with_context(wanted)?;
            write!(file, "{}", this_command()).with_context(wanted)?;
            return Ok(Self { path, _file: file });
        }
    }
}

impl Drop for Claim {
    fn drop(&mut self) {
        // Before the lock is given back. One that stays is taken over by the next command.
        let _ = std::fs::remove_file(&self.path);
    }
}

/// What the holder wrote; where a locked file cannot be read, nothing is known.
fn holder(file: &mut File) -> String {
    let mut text = String::new();
    match file.take(HOLDER_BYTES).read_to_string(&mut text) {
        Ok(1..) => text,
        _ => "another command".to_owned(),
    }
}

fn this_command() -> String {
    let words: Vec<String> = std::env::args_os()
        .skip(1)
        .map(|word| word.to_string_lossy().into_owned())
        .collect();
    let text = format!(
        "process {}, courier {}",
        std::process::id(),
        words.join(" ")
    );
    text.chars().filter(|c| !c.is_control()).take(200).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_claim_is_refused_to_others_until_it_is_given_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("flash.bin");
        let first = Claim::of_file(&path, "--sim-flash: flash.bin").unwrap();
        let error = Claim::of_file(&path, "--sim-flash: flash.bin")
            .unwrap_err()
            .to_string();
        for word in [
            "flash.bin: found it in use by process",
            &std::process::id().to_string(),
        ] {
            assert!(error.contains(word), "{error}");
        }
        Claim::of_file(&folder.path().join("other.bin"), "other").unwrap();
        drop(first);
        drop(Claim::of_file(&path, "again").unwrap());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    /// A command that was killed leaves its file, but no lock.
    #[test]
    fn a_file_that_was_left_behind_is_taken_over() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("flash.bin");
        let left = folder.path().join(".flash.bin.lock");
        std::fs::write(
            left,
            "process 1, courier import a.json, and more than the next one writes",
        )
        .unwrap();
        drop(Claim::of_file(&path, "flash").unwrap());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
