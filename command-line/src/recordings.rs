//! A recording by its path, whichever form it has: a folder, or one Parquet or MCAP file where this build has the feature `parquet` or
//! `mcap`.

use recording::{Error, Existing, Meta, Recording, Writer};
use std::path::Path;

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
