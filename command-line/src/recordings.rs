//! A recording by its path, whichever form it has: a folder, or one Parquet or MCAP file where this build has the feature `parquet` or
//! `mcap`.

use recording::{Error, Existing, META_FILE, Meta, Recording, SAMPLES_FILE, Writer};
use std::path::{Path, PathBuf};

/// What a recording in one file is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Its name ends in `.parquet`.
    Parquet,
    /// Its name ends in `.mcap`.
    Mcap,
}

/// The form of a path that names one file and no folder, by the end of its name.
#[must_use]
pub fn form(path: &Path) -> Option<Form> {
    let ending = path.extension()?.to_str()?.to_ascii_lowercase();
    let form = match ending.as_str() {
        "parquet" => Form::Parquet,
        "mcap" => Form::Mcap,
        _ => return None,
    };
    (!path.is_dir()).then_some(form)
}

/// True of a path where a recording is, and no log of another program's. Without its feature a file of one of the forms is taken for one, so
/// that reading it says what is missing.
#[must_use]
pub fn is_recording(path: &Path) -> bool {
    path.is_dir()
        || match form(path) {
            Some(Form::Parquet) => parquet::is_recording(path),
            Some(Form::Mcap) => mcap::is_recording(path),
            None => false,
        }
}

/// The recordings that some paths stand for: a folder that is none itself stands for those in it, by their names.
#[must_use]
pub fn within(paths: &[PathBuf]) -> Vec<PathBuf> {
    paths.iter().flat_map(|path| in_one(path)).collect()
}

fn in_one(path: &Path) -> Vec<PathBuf> {
    let holds_files = |folder: &Path| {
        let mut names = [META_FILE, SAMPLES_FILE].iter();
        names.any(|name| folder.join(name).exists())
    };
    let is_one =
        |entry: &PathBuf| holds_files(entry) || form(entry).is_some_and(|_| is_recording(entry));
    let entries = path.read_dir().into_iter().flatten().flatten();
    let mut found: Vec<PathBuf> = entries.map(|entry| entry.path()).filter(is_one).collect();
    if holds_files(path) || found.is_empty() {
        return vec![path.to_path_buf()];
    }
    found.sort();
    found
}

/// Reads and checks the recording at `path`.
///
/// # Errors
/// As [`Recording::read`]; a file of a form and a build that does not read it.
pub fn read(path: &Path) -> Result<Recording, Error> {
    match form(path) {
        Some(Form::Parquet) => parquet::read(path),
        Some(Form::Mcap) => mcap::read(path),
        None => Recording::read(path),
    }
}

/// Writes a recording as a Parquet file that takes less, with its numbers as decimals.
///
/// # Errors
/// The path is no such file's, a build that does not write it, or a failure to write.
pub fn write_compact(path: &Path, recording: &Recording, existing: Existing) -> Result<(), Error> {
    if form(path) != Some(Form::Parquet) {
        let wanted = "a file whose name ends in .parquet, which --compact is of";
        return Err(Error::new(path, "another form", wanted));
    }
    parquet_compact(path, recording, existing)
}

#[cfg(feature = "parquet")]
fn parquet_compact(path: &Path, recording: &Recording, existing: Existing) -> Result<(), Error> {
    columnar::check_existing(path, existing)?;
    recording.check(path)?;
    columnar::write_compact(&recording.meta, &recording.samples, path, existing)
}

#[cfg(not(feature = "parquet"))]
fn parquet_compact(path: &Path, recording: &Recording, existing: Existing) -> Result<(), Error> {
    parquet::create(path, &recording.meta, existing, &[]).map(drop)
}

/// Begins a recording in one file.
pub(crate) fn create(
    form: Form,
    path: &Path,
    meta: &Meta,
    existing: Existing,
    logged: &[&str],
) -> Result<Writer, Error> {
    match form {
        Form::Parquet => parquet::create(path, meta, existing, logged),
        Form::Mcap => mcap::create(path, meta, existing, logged),
    }
}

/// One form: that of a crate where the build has its feature, and refusals that say how to have it where not.
macro_rules! form {
    ($module:ident, $feature:literal, $library:ident, $named:literal, $with:literal) => {
        #[cfg(feature = $feature)]
        mod $module {
            use recording::{Error, Existing, Meta, Writer};
            use std::path::Path;

            pub(super) use $library::{is_recording, read};

            pub(super) fn create(
                path: &Path,
                meta: &Meta,
                existing: Existing,
                logged: &[&str],
            ) -> Result<Writer, Error> {
                $library::check_existing(path, existing)?;
                Ok(Writer::keeping(
                    path,
                    meta,
                    existing,
                    logged,
                    $library::write,
                ))
            }
        }

        #[cfg(not(feature = $feature))]
        mod $module {
            use recording::{Error, Existing, Meta, Recording, Writer};
            use std::path::Path;

            fn missing(path: &Path) -> Error {
                let wanted = concat!(
                    "a folder, or a courier with ",
                    $with,
                    ": `cargo install --path host --features ",
                    $feature,
                    "`"
                );
                Error::new(path, concat!("the name of ", $named), wanted)
            }

            pub(super) fn is_recording(_: &Path) -> bool {
                true
            }

            pub(super) fn read(path: &Path) -> Result<Recording, Error> {
                Err(missing(path))
            }

            pub(super) fn create(
                path: &Path,
                _: &Meta,
                _: Existing,
                _: &[&str],
            ) -> Result<Writer, Error> {
                Err(missing(path))
            }
        }
    };
}

form!(parquet, "parquet", columnar, "a Parquet file", "Parquet");
form!(mcap, "mcap", bag, "an MCAP file", "MCAP");

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_tells_the_form_and_a_folder_stays_a_folder() {
        let folder = tempfile::tempdir().unwrap();
        for (name, wanted) in [
            ("a.parquet", Some(Form::Parquet)),
            ("a.PARQUET", Some(Form::Parquet)),
            ("a.mcap", Some(Form::Mcap)),
            ("parquet", None),
            ("a.parquet.csv", None),
        ] {
            assert_eq!(form(&folder.path().join(name)), wanted, "{name}");
        }
        let odd = folder.path().join("b.parquet");
        std::fs::create_dir(&odd).unwrap();
        assert!(form(&odd).is_none() && is_recording(&odd));
    }

    /// A folder of recordings stands for them; a recording, an empty folder and what is not there stand for themselves.
    #[test]
    fn a_folder_of_recordings_stands_for_them() {
        let hall = tempfile::tempdir().unwrap();
        let of = |name: &str| hall.path().join(name);
        assert_eq!(within(&[hall.path().into()]), [hall.path()]);
        for (name, file) in [("c2", META_FILE), ("c1", SAMPLES_FILE), ("notes", "a.txt")] {
            std::fs::create_dir(of(name)).unwrap();
            std::fs::write(of(name).join(file), "").unwrap();
        }
        assert_eq!(within(&[hall.path().into()]), [of("c1"), of("c2")]);
        let named = [of("c1"), of("c9")];
        assert_eq!(within(&named), named);
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
