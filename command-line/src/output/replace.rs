//! Writes files whole or not at all.

use anyhow::{Context, Result, ensure};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// Writes `bytes` beside `path` and moves them into place, so that a failure leaves what was there. What is no file, a pipe or a
/// device, is written to where it is.
///
/// # Errors
/// The folder is missing, full or not writable.
pub fn replace_file(path: &Path, bytes: &[u8]) -> Result<()> {
    check_folder_of(path)?;
    let told = || {
        format!(
            "{}: a file in a folder that can be written was wanted",
            path.display()
        )
    };
    let Some(place) = place(path) else {
        return std::fs::write(path, bytes).with_context(told);
    };
    let file = beside(&place, bytes).with_context(told)?;
    file.persist(&place)
        .map_err(|failed| failed.error)
        .with_context(told)?;
    Ok(())
}

/// As [`replace_file`], where nothing may be lost: what is there already is left alone.
///
/// # Errors
/// Something is there, or as [`replace_file`].
pub fn new_file(path: &Path, bytes: &[u8]) -> Result<()> {
    check_folder_of(path)?;
    let told = || format!("{}: wanted a new file, or --force", path.display());
    let file = beside(path, bytes).with_context(told)?;
    file.persist_noclobber(path)
        .map_err(|failed| failed.error)
        .with_context(told)?;
    Ok(())
}

/// Where the file is that `path` names, links followed; none: it is there and is no file.
fn place(path: &Path) -> Option<PathBuf> {
    match std::fs::metadata(path) {
        Ok(there) if there.is_file() => std::fs::canonicalize(path).ok(),
        Ok(there) if !there.is_dir() => None,
        _ => Some(path.to_owned()),
    }
}

/// Refuses a path in whose folder no file can be: before work of which the result would be lost.
///
/// # Errors
/// The folder is none or is missing, or there is a folder in the file's place.
pub fn check_folder_of(path: &Path) -> Result<()> {
    let folder = folder_of(path);
    ensure!(
        folder.is_dir() && !path.is_dir(),
        "{}: found {}, wanted a file in a folder that is there",
        path.display(),
        if path.is_dir() {
            "a folder"
        } else {
            "no folder for it"
        }
    );
    Ok(())
}

fn folder_of(path: &Path) -> &Path {
    path.parent()
        .filter(|folder| !folder.as_os_str().is_empty())
        .unwrap_or(Path::new("."))
}

/// A file in the folder of `path` with these bytes, which vanishes unless it is moved into place. Its permissions are those of the
/// file that it is to replace, or of any that the user makes.
fn beside(path: &Path, bytes: &[u8]) -> std::io::Result<NamedTempFile> {
    let mut file = recording::unfinished_file(folder_of(path))?;
    if let Ok(there) = std::fs::metadata(path) {
        file.as_file().set_permissions(there.permissions())?;
    }
    file.write_all(bytes)?;
    Ok(file)
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt;

    fn mode(path: &Path) -> u32 {
        std::fs::metadata(path).unwrap().permissions().mode() & 0o777
    }

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

    #[test]
    fn a_link_stays_a_link_and_its_file_gets_what_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let [file, link] = ["file", "link"].map(|name| folder.path().join(name));
        std::fs::write(&file, "before").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        replace_file(&link, b"told").unwrap();
        assert!(std::fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(std::fs::read(&file).unwrap(), b"told");
    }

    /// A plain write beside it tells what the umask of whoever runs this allows.
    #[test]
    fn a_file_may_be_read_by_whom_the_user_lets_read() {
        let folder = tempfile::tempdir().unwrap();
        let [plain, new, replaced] =
            ["plain", "new", "replaced"].map(|name| folder.path().join(name));
        std::fs::write(&plain, "").unwrap();
        new_file(&new, b"").unwrap();
        assert_eq!(mode(&new), mode(&plain));
        replace_file(&new, b"again").unwrap();
        assert_eq!(mode(&new), mode(&plain));

        std::fs::write(&replaced, "").unwrap();
        std::fs::set_permissions(&replaced, PermissionsExt::from_mode(0o640)).unwrap();
        replace_file(&replaced, b"again").unwrap();
        assert_eq!(mode(&replaced), 0o640);
    }

    #[test]
    fn a_new_file_replaces_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("there");
        std::fs::write(&path, "before").unwrap();
        let error = format!("{:#}", new_file(&path, b"told").unwrap_err());
        assert!(error.contains("--force"), "{error}");
        assert_eq!(std::fs::read(&path).unwrap(), b"before");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
