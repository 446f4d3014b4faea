//! A copy of the project's sources in which a text can be exchanged. What has not changed keeps its date, so that cargo builds anew
//! only what has.

use super::mutations::{Edit, Mutation};
use anyhow::{Context, Result, ensure};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// Folders that hold what is built or recorded, not sources.
const LEFT_OUT: [&str; 3] = ["target", ".git", "node_modules"];

/// Every file of a project, by its path from the root.
pub type Files = BTreeMap<PathBuf, Vec<u8>>;

/// Reads all sources in `folder`.
///
/// # Errors
/// A file cannot be read.
pub fn read(folder: &Path) -> Result<Files> {
    let mut files = Files::new();
    read_into(folder, Path::new(""), &mut files)?;
    Ok(files)
}

fn read_into(root: &Path, inside: &Path, files: &mut Files) -> Result<()> {
    let folder = root.join(inside);
    let entries = fs::read_dir(&folder).with_context(|| folder.display().to_string())?;
    for entry in entries {
        let entry = entry.with_context(|| folder.display().to_string())?;
        let name = inside.join(entry.file_name());
        if entry.path().is_dir() {
            if !LEFT_OUT.iter().any(|left| entry.file_name() == *left) {
                read_into(root, &name, files)?;
            }
        } else if entry.path().is_file() {
            let bytes = fs::read(entry.path()).with_context(|| name.display().to_string())?;
            files.insert(name, bytes);
        }
    }
    Ok(())
}

/// The files with these faults in them. Of two that are the same change one is made.
///
/// # Errors
/// A text does not stand exactly once in its file: the mutation no longer fits the sources, or not beside the others.
pub fn mutate(files: &Files, mutations: &[&Mutation]) -> Result<Files> {
    let mut mutated = files.clone();
    let mut made: Vec<Edit> = vec![];
    for edit in mutations.iter().flat_map(|mutation| mutation.edits) {
        if made.contains(edit) {
            continue;
        }
        made.push(*edit);
        let bytes = mutated
            .get_mut(Path::new(edit.file))
            .with_context(|| format!("found no {}, wanted it", edit.file))?;
        let text = String::from_utf8_lossy(bytes);
        let times = text.matches(edit.find).count();
        ensure!(
            times == 1,
            "found {:?} {times} times in {}, wanted it once: the mutation no longer fits the sources",
            edit.find,
            edit.file
        );
        *bytes = text.replacen(edit.find, edit.put, 1).into_bytes();
    }
    Ok(mutated)
}

/// Makes `folder` hold these files and no others; a file that holds the same already is not touched.
///
/// # Errors
/// A file cannot be written.
pub fn write(files: &Files, folder: &Path) -> Result<()> {
    let before = if folder.is_dir() {
        read(folder)?
    } else {
        Files::new()
    };
    for name in before.keys().filter(|name| !files.contains_key(*name)) {
        fs::remove_file(folder.join(name)).with_context(|| name.display().to_string())?;
    }
    for (name, bytes) in files {
        if before.get(name) == Some(bytes) {
            continue;
        }
        let path = folder.join(name);
        let parent = path.parent().unwrap_or(folder);
        fs::create_dir_all(parent).with_context(|| parent.display().to_string())?;
        fs::write(&path, bytes).with_context(|| path.display().to_string())?;
    }
    Ok(())
}

/// Copies what has been built in `from` to `to`, dates included: cargo goes by them.
///
/// # Errors
/// A file cannot be copied.
pub fn built(from: &Path, to: &Path) -> Result<()> {
    fs::create_dir_all(to).with_context(|| to.display().to_string())?;
    let entries = fs::read_dir(from).with_context(|| from.display().to_string())?;
    for entry in entries {
        let (path, target) = {
            let entry = entry.with_context(|| from.display().to_string())?;
            (entry.path(), to.join(entry.file_name()))
        };
        if path.is_dir() {
            built(&path, &target)?;
        } else {
            copy_with_date(&path, &target).with_context(|| target.display().to_string())?;
        }
    }
    Ok(())
}

fn copy_with_date(from: &Path, to: &Path) -> std::io::Result<()> {
    fs::copy(from, to)?;
    let date = fs::metadata(from)?.modified()?;
    fs::File::options().write(true).open(to)?.set_modified(date)
}

#[cfg(test)]
mod tests {
    use super::super::mutations::MUTATIONS;
    use super::*;

    #[test]
    fn every_mutation_fits_the_sources() {
        let files = read(&crate::arm::root()).expect("readable");
        for mutation in MUTATIONS {
            let mutated =
                mutate(&files, &[mutation]).unwrap_or_else(|e| panic!("{}: {e:#}", mutation.name));
            assert_ne!(files, mutated, "{} changes nothing", mutation.name);
        }
    }

    #[test]
    fn a_mutation_that_no_longer_fits_says_so() {
        let files = Files::from([("a".into(), b"one two one".to_vec())]);
        let with = |find| Mutation {
            name: "test",
            what: "",
            edits: Box::leak(Box::new([Edit {
                file: "a",
                find,
                put: "",
            }])),
            check: "",
            shows: "",
        };
        for (find, times) in [("one", "2 times"), ("three", "0 times")] {
            let error = mutate(&files, &[&with(find)]).unwrap_err().to_string();
            assert!(error.contains(times) && error.contains(find), "{error}");
        }
        let mutated = mutate(&files, &[&with(" two")]).expect("once");
        assert_eq!(mutated[Path::new("a")], b"one one");
    }
}
