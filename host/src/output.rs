//! Files that commands write: whole or not at all.

use anyhow::{Context, Result};
use std::io::Write as _;
use std::path::Path;

/// Writes `bytes` beside `path` and moves them into place, so that a failure leaves what was there. What is no file, a pipe or a
/// device, is written to where it is.
///
/// # Errors
/// The folder is missing, full or not writable.
pub fn replace_file(path: &Path, bytes: &[u8]) -> Result<()> {
    let folder = path
        .parent()
        .filter(|p| !p.as_os_str().is_empty())
        .unwrap_or(Path::new("."));
    let told = || {
        format!(
            "{}: a file in a folder that can be written was wanted",
            path.display()
        )
    };
    if std::fs::metadata(path).is_ok_and(|there| !there.is_file() && !there.is_dir()) {
        return std::fs::write(path, bytes).with_context(told);
    }
    let mut file = tempfile::NamedTempFile::new_in(folder).with_context(told)?;
    file.write_all(bytes).with_context(told)?;
    file.persist(path).with_context(told)?;
    Ok(())
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn a_pipe_stays_a_pipe_and_gets_what_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status();
        assert!(made.unwrap().success());
        let reader = std::thread::spawn({
            let pipe = pipe.clone();
            move || std::fs::read(pipe).unwrap()
        });
        replace_file(&pipe, b"told").unwrap();
        assert!(!std::fs::metadata(&pipe).unwrap().is_file());
        assert_eq!(reader.join().unwrap(), b"told");
    }
}
