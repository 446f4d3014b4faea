//! The files of the table of answers: one a recording, so that any number of programs can write side by side and be killed.
//!
//! A file lies in `courier_id=NAME/`, as engines partition tables. Its name is `PATH-CONTENT`: the hash of the recording's path, by which
//! an older answer of it is found and taken away, and that of its content, the program's version and the options, by which an answer that
//! is there already is found, be it under another path. It is moved there once it is whole.

#[cfg(any(test, feature = "parquet"))]
use super::cell::Cell;
use super::cell::Row;
use anyhow::{Context, Result, ensure};
use sha2::{Digest, Sha256};
use std::collections::HashMap;
use std::fs::read_dir;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// What the names of the files end in.
pub const ENDING: &str = if cfg!(feature = "parquet") {
    ".parquet"
} else {
    ".jsonl"
};
/// Endings of files of either build.
const ENDINGS: [&str; 2] = [".parquet", ".jsonl"];
/// Folder of recordings that do not say which courier they are of: the name that engines read as null.
const NO_COURIER: &str = "__HIVE_DEFAULT_PARTITION__";
/// How the name of a file begins that was not finished (`recording::unfinished_file`).
const UNFINISHED: &str = ".courier-unfinished-";
/// A file is written in milliseconds; one that is not finished and older than this was left by a program that was killed.
const ABANDONED: Duration = Duration::from_secs(600);
/// Digits of a hash in a name: 64 bits, so that among a million recordings two have one name with a chance of 3e-8.
const DIGITS: usize = 16;

/// Which answer a file holds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Key {
    path: String,
    content: String,
}

impl Key {
    /// Of a recording by its path as given, the hash of its content, and whatever else an answer depends on.
    #[must_use]
    pub fn new(path: &str, content: &str, options: &str) -> Self {
        let version = env!("CARGO_PKG_VERSION");
        Self {
            path: short(path),
            content: short(&format!("{content}\n{version}\n{options}")),
        }
    }

    fn name(&self) -> String {
        format!("{}-{}{ENDING}", self.path, self.content)
    }
}

fn short(text: &str) -> String {
    let mut hash = hex(&Sha256::digest(text));
    hash.truncate(DIGITS);
    hash
}

/// Bytes as hexadecimal digits.
#[must_use]
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The table: a folder of such files.
#[derive(Debug)]
pub struct Parts {
    folder: PathBuf,
    /// Files that were there at the beginning, by the hash of their recording's path.
    there: HashMap<String, Vec<PathBuf>>,
    /// The same, and those that were written since, by the hash of their recording's content.
    by_content: Mutex<HashMap<String, Vec<PathBuf>>>,
}

impl Parts {
    /// Opens the table in `folder`, which is made if need be. What killed programs have left there is taken away.
    ///
    /// # Errors
    /// The folder cannot be made, read or written.
    pub fn open(folder: &Path) -> Result<Self> {
        let told = || format!("{}: wanted a folder to write into", folder.display());
        ensure!(
            !folder.is_file(),
            "{}: found a file, wanted a folder",
            folder.display()
        );
        std::fs::create_dir_all(folder).with_context(told)?;
        let mut there: HashMap<String, Vec<PathBuf>> = HashMap::new();
        let mut by_content: HashMap<String, Vec<PathBuf>> = HashMap::new();
        for partition in read_dir(folder).with_context(told)? {
            let partition = partition.with_context(told)?;
            let name = partition.file_name();
            if !name.to_string_lossy().starts_with("courier_id=") || !partition.path().is_dir() {
                continue;
            }
            for file in read_dir(partition.path()).with_context(told)? {
                let file = file.with_context(told)?.path();
                let name = file
                    .file_name()
                    .unwrap_or_default()
                    .to_string_lossy()
                    .into_owned();
                if name.starts_with(UNFINISHED) {
                    sweep(&file);
                } else if let Some((path, content)) = name
                    .split_once('-')
                    .filter(|_| ENDINGS.iter().any(|ending| name.ends_with(ending)))
                {
                    if let Some(content) = content.strip_suffix(ENDING) {
                        let of_it = by_content.entry(content.to_owned()).or_default();
                        of_it.push(file.clone());
                    }
                    there.entry(path.to_owned()).or_default().push(file);
                }
            }
        }
        Ok(Self {
            folder: folder.to_owned(),
            there,
            by_content: Mutex::new(by_content),
        })
    }

    /// The file with the answer of this key, if it is there already.
    #[must_use]
    pub fn find(&self, key: &Key) -> Option<&Path> {
        let name = key.name();
        let is_it = |file: &&PathBuf| file.file_name().is_some_and(|file| *file == *name);
        self.there
            .get(&key.path)?
            .iter()
            .find(is_it)
            .map(PathBuf::as_path)
    }

    /// No thread that holds it can panic.
    fn by_content(&self) -> MutexGuard<'_, HashMap<String, Vec<PathBuf>>> {
        let held = self.by_content.lock();
        held.unwrap_or_else(PoisonError::into_inner)
    }

    /// Files of the same content, program and options as this key's, and of other paths.
    #[must_use]
    pub fn of_same_content(&self, key: &Key) -> Vec<PathBuf> {
        let name = key.name();
        let is_other = |file: &&PathBuf| file.file_name().is_some_and(|file| *file != *name);
        let by_content = self.by_content();
        let files = by_content.get(&key.content).into_iter().flatten();
        files.filter(is_other).cloned().collect()
    }

    /// Writes the answer of this key, and takes older answers of the same recording away.
    ///
    /// # Errors
    /// The folder is full or not writable.
    pub fn put(&self, key: &Key, courier_id: &str, row: &Row) -> Result<()> {
        let partition = self
            .folder
            .join(format!("courier_id={}", escaped(courier_id)));
        let file = partition.join(key.name());
        let told = || format!("{}: wanted room to write", file.display());
        std::fs::create_dir_all(&partition).with_context(told)?;
        write(&file, row).with_context(told)?;
        let mut by_content = self.by_content();
        let of_it = by_content.entry(key.content.clone()).or_default();
        of_it.push(file.clone());
        drop(by_content);
        let older = self.there.get(&key.path).into_iter().flatten();
        for older in older.filter(|older| **older != file) {
            // Another program may have taken it away.
            let _ = std::fs::remove_file(older);
        }
        Ok(())
    }
}

/// Removes what a killed program has left. What another one is writing is younger.
fn sweep(file: &Path) {
    let age = std::fs::metadata(file).and_then(|data| data.modified());
    let age = age.ok().and_then(|modified| modified.elapsed().ok());
    if age.is_some_and(|age| age > ABANDONED) {
        let _ = std::fs::remove_file(file);
    }
}

/// A name of a folder that every system takes: other characters as `%` and two digits a byte, as engines write them.
fn escaped(name: &str) -> String {
    if name.is_empty() {
        return NO_COURIER.to_owned();
    }
    let is_plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-_".contains(&byte);
    let one = |byte: u8| match is_plain(byte) {
        true => char::from(byte).to_string(),
        false => format!("%{byte:02X}"),
    };
    name.bytes().map(one).collect()
}

/// A row as one line of JSON.
#[must_use]
pub fn line(row: &Row) -> String {
    let object: serde_json::Map<_, _> = row
        .iter()
        .map(|(name, cell)| (name.clone(), cell.json()))
        .collect();
    serde_json::Value::Object(object).to_string() + "\n"
}

#[cfg(not(feature = "parquet"))]
fn write(file: &Path, row: &Row) -> Result<()> {
    use std::io::Write as _;
    let folder = file.parent().unwrap_or(Path::new("."));
    let mut unfinished = recording::unfinished_file(folder)?;
    unfinished.write_all(line(row).as_bytes())?;
    unfinished.persist(file)?;
    Ok(())
}

#[cfg(feature = "parquet")]
fn write(file: &Path, row: &Row) -> Result<()> {
    use columnar::table::{Column, Values, write};
    let one = |(name, cell): &(String, Cell)| Column {
        name: name.clone(),
        values: match cell {
            Cell::Text(text) => Values::Texts(vec![text.clone()]),
            Cell::Real(value) => Values::Reals(vec![*value]),
            Cell::Whole(value) => Values::Wholes(vec![*value]),
        },
    };
    let columns: Vec<Column> = row.iter().map(one).collect();
    Ok(write(file, &columns)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> = read_dir(folder)
            .unwrap()
            .flat_map(|partition| read_dir(partition.unwrap().path()).unwrap())
            .map(|file| file.unwrap().file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    fn row() -> Row {
        vec![
            ("recording".into(), Cell::text("a")),
            ("gap_m".into(), Cell::real(f64::NAN)),
        ]
    }

    #[test]
    fn an_answer_is_found_by_content_and_takes_the_older_one_s_place() {
        let folder = tempfile::tempdir().unwrap();
        let first = Key::new("a", "1", "");
        let parts = Parts::open(folder.path()).unwrap();
        assert_eq!(parts.find(&first), None);
        parts.put(&first, "7", &row()).unwrap();
        parts.put(&Key::new("b", "1", ""), "7", &row()).unwrap();
        let parts = Parts::open(folder.path()).unwrap();
        assert!(parts.find(&first).is_some());
        for other in [
            Key::new("a", "2", ""),
            Key::new("a", "1", "without"),
            Key::new("c", "1", ""),
        ] {
            assert_eq!(parts.find(&other), None);
        }
        // Another content, and another courier: still one answer of `a`.
        let second = Key::new("a", "2", "");
        parts.put(&second, "", &row()).unwrap();
        assert_eq!(names(folder.path()).len(), 2);
        assert!(
            folder
                .path()
                .join("courier_id=__HIVE_DEFAULT_PARTITION__")
                .join(second.name())
                .is_file()
        );
    }

    #[test]
    fn what_a_killed_program_left_goes_and_what_is_being_written_stays() {
        let folder = tempfile::tempdir().unwrap();
        let partition = folder.path().join("courier_id=7");
        std::fs::create_dir(&partition).unwrap();
        let [old, young] =
            ["old", "young"].map(|name| partition.join(format!("{UNFINISHED}{name}")));
        let made = |path: &Path| std::fs::File::create(path).unwrap();
        made(&young);
        made(&old)
            .set_modified(std::time::SystemTime::UNIX_EPOCH)
            .unwrap();
        Parts::open(folder.path()).unwrap();
        assert_eq!(names(folder.path()), [format!("{UNFINISHED}young")]);
    }

    #[test]
    fn names_of_couriers_are_names_of_folders() {
        assert_eq!(escaped("ideal-000003"), "ideal-000003");
        assert_eq!(escaped("../a b/ü"), "%2E%2E%2Fa%20b%2F%C3%BC");
        assert_eq!(line(&row()), "{\"gap_m\":null,\"recording\":\"a\"}\n");
    }
}
