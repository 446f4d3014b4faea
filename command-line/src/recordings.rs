//! A recording by its path, whichever form it has: a folder, or one Parquet file where this build has the feature `parquet`.

use recording::{Error, Recording};
use std::path::Path;

/// What the name of a recording in one file ends in.
const EXTENSION: &str = "parquet";

/// True of a path that names one file and no folder.
#[must_use]
pub fn is_file(path: &Path) -> bool {
    let ending = path.extension().and_then(|ending| ending.to_str());
    ending.is_some_and(|ending| ending.eq_ignore_ascii_case(EXTENSION)) && !path.is_dir()
}

/// True of a path where a recording is, and no log of another program's. Without the feature a Parquet file is taken for one, so
/// that reading it says what is missing.
#[must_use]
pub fn is_recording(path: &Path) -> bool {
    path.is_dir() || is_file(path) && form::is_recording(path)
}

/// Reads and checks the recording at `path`.
///
/// # Errors
/// As [`Recording::read`]; a Parquet file and a build that reads none.
pub fn read(path: &Path) -> Result<Recording, Error> {
    match is_file(path) {
        true => form::read(path),
        false => Recording::read(path),
    }
}

/// The file's form, in a build that has it.
#[cfg(feature = "parquet")]
pub(crate) mod form {
    use recording::{Error, Existing, Meta, Writer};
    use std::path::Path;

    pub(crate) use columnar::{is_recording, read};

    pub(crate) fn create(
        path: &Path,
        meta: &Meta,
        existing: Existing,
        logged: &[&str],
    ) -> Result<Writer, Error> {
        columnar::check_existing(path, existing)?;
        Ok(Writer::keeping(
            path,
            meta,
            existing,
            logged,
            columnar::write,
        ))
    }
}

/// What stands in its place where the build has it not.
#[cfg(not(feature = "parquet"))]
pub(crate) mod form {
    use recording::{Error, Existing, Meta, Recording, Writer};
    use std::path::Path;

    fn missing(path: &Path) -> Error {
        Error::new(
            path,
            "the name of a Parquet file",
            "a folder, or a courier with Parquet: `cargo install --path host --features parquet`",
        )
    }

    pub(crate) fn is_recording(_: &Path) -> bool {
        true
    }

    pub(crate) fn read(path: &Path) -> Result<Recording, Error> {
        Err(missing(path))
    }

    pub(crate) fn create(path: &Path, _: &Meta, _: Existing, _: &[&str]) -> Result<Writer, Error> {
        Err(missing(path))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_tells_the_form_and_a_folder_stays_a_folder() {
        let folder = tempfile::tempdir().unwrap();
        for (name, wanted) in [
            ("a.parquet", true),
            ("a.PARQUET", true),
            ("parquet", false),
            ("a.parquet.csv", false),
        ] {
            assert_eq!(is_file(&folder.path().join(name)), wanted, "{name}");
        }
        let odd = folder.path().join("b.parquet");
        std::fs::create_dir(&odd).unwrap();
        assert!(!is_file(&odd) && is_recording(&odd));
    }

    #[test]
    #[cfg(not(feature = "parquet"))]
    fn a_build_without_it_says_how_to_build_with_it() {
        let told = read(Path::new("a.parquet")).unwrap_err().to_string();
        assert_eq!(
            told,
            "a.parquet: found the name of a Parquet file, wanted a folder, or a courier with Parquet: `cargo install --path host --features parquet`"
        );
    }
}
