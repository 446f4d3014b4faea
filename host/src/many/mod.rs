//! Many recordings, a row each: `courier diagnose A B … --out DIR`.
//!
//! `row` makes a row of an answer, `cell` is one value of it, `part` keeps each row in a file of its own, `kept` reads what such a file says.
//! Recordings are diagnosed side by
//! side, each by one processor, so that an answer does not depend on how many there are.

pub mod cell;
pub mod kept;
pub mod part;
pub mod row;

use crate::interrupt;
use crate::provenance::files;
use crate::recordings;
use anyhow::{Context, Result};
use cell::Row;
use diagnosis::verdict::answer::{Diagnosis, Verdict};
use diagnosis::{Options, diagnose};
use kept::Kept;
use part::{Key, Parts, hex};
use recording::Recording;
use row::{FAILED, Identity, of_answer, of_failure};
use serde::Serialize;
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// What to diagnose, and where the table is.
#[derive(Clone, Debug)]
pub struct Order {
    /// Recordings, each by its path.
    pub recordings: Vec<PathBuf>,
    /// Folder of the table.
    pub table: PathBuf,
    /// Effects that are taken out of the catalogue.
    pub without: Vec<String>,
    /// Resolution that gaps are held against, m.
    pub resolution_m: f64,
    /// Recordings that are diagnosed at once, 1 or more.
    pub jobs: usize,
}

/// What was done.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Done {
    /// Recordings that were asked for.
    pub recordings: usize,
    /// Rows that were there already.
    pub already: usize,
    /// Rows that were written now, of answers that were there under another path.
    pub taken_over: usize,
    /// Rows by verdict that were written now; `failed` are recordings that could not be read or diagnosed.
    pub verdicts: BTreeMap<String, usize>,
    /// Recordings that were not reached, since the user wanted no more.
    pub not_reached: usize,
}

/// Diagnoses what has no row yet. `each` is called after each recording.
///
/// # Errors
/// The table cannot be written. Rows that are written by then stay.
pub fn run(order: &Order, each: &(dyn Fn() + Sync)) -> Result<Done> {
    let parts = Parts::open(&order.table)?;
    let (next, stop) = (AtomicUsize::new(0), AtomicBool::new(false));
    let (done, failed) = (Mutex::new(Done::default()), Mutex::new(None));
    let work = || {
        while !stop.load(Ordering::Relaxed) && interrupt::check().is_ok() {
            let Some(path) = order.recordings.get(next.fetch_add(1, Ordering::Relaxed)) else {
                return;
            };
            match one(order, &parts, path) {
                Ok(made) => count(&mut held(&done), made),
                Err(error) => {
                    stop.store(true, Ordering::Relaxed);
                    held(&failed).get_or_insert(error);
                }
            }
            each();
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..order.jobs.clamp(1, order.recordings.len().max(1)) {
            scope.spawn(work);
        }
    });
    if let Some(error) = held(&failed).take() {
        return Err(error);
    }
    let mut done = held(&done).clone();
    let reached = done.already + done.taken_over + done.verdicts.values().sum::<usize>();
    done.recordings = order.recordings.len();
    done.not_reached = done.recordings - reached;
    Ok(done)
}

/// No thread that holds one of these can panic.
fn held<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex
        .lock()
        .unwrap_or_else(std::sync::PoisonError::into_inner)
}

/// How a recording came by its row.
enum Made {
    Already,
    TakenOver,
    /// With this verdict.
    Diagnosed(String),
}

fn count(done: &mut Done, made: Made) {
    match made {
        Made::Already => done.already += 1,
        Made::TakenOver => done.taken_over += 1,
        Made::Diagnosed(verdict) => *done.verdicts.entry(verdict).or_default() += 1,
    }
}

/// Sees to it that a recording has its row. Rows of the same content, whose recordings have gone from their paths, were of this one
/// before it was renamed: they go last, so that one is there at any time.
fn one(order: &Order, parts: &Parts, path: &Path) -> Result<Made> {
    let name = path.display().to_string();
    let content = content(path);
    let without = order.without.join(",");
    let key = Key::new(
        &name,
        &content,
        &format!("{without};{:?}", order.resolution_m),
    );
    // What is not there has no content that could have another name.
    let same = match path.exists() {
        true => parts.of_same_content(&key),
        false => Vec::new(),
    };
    let same: Vec<(PathBuf, Kept)> = same
        .into_iter()
        .filter_map(|file| Some((file.clone(), Kept::read(&file)?)))
        .collect();
    let made = match parts.find(&key) {
        Some(_) => Made::Already,
        None => written(order, parts, path, &key, &content, &same)?,
    };
    for (file, kept) in &same {
        if kept.is_gone() {
            // Another program may have taken it away.
            let _ = std::fs::remove_file(file);
        }
    }
    Ok(made)
}

/// Writes the row of a recording, of an answer that is there under another path or of a new one.
fn written(
    order: &Order,
    parts: &Parts,
    path: &Path,
    key: &Key,
    content: &str,
    same: &[(PathBuf, Kept)],
) -> Result<Made> {
    let name = path.display().to_string();
    let without = order.without.join(",");
    let identity = Identity {
        path: &name,
        content,
        without: &without,
        resolution_m: order.resolution_m,
    };
    let known = same.iter().find_map(|(_, kept)| kept.answer(&name));
    let is_known = known.is_some();
    let (verdict, courier_id, row) = diagnosed(order, path, &identity, known)?;
    parts.put(key, &courier_id, &row)?;
    Ok(match is_known {
        true => Made::TakenOver,
        false => Made::Diagnosed(verdict),
    })
}

/// Verdict, courier and row, of an answer that is known or of a new one. What cannot be read or diagnosed has a row that says why.
fn diagnosed(
    order: &Order,
    path: &Path,
    identity: &Identity,
    known: Option<Diagnosis>,
) -> Result<(String, String, Row)> {
    let recording = match recordings::read(path) {
        Ok(recording) => recording,
        Err(error) => {
            let row = of_failure(identity, None, &error.to_string());
            return Ok((FAILED.into(), String::new(), row));
        }
    };
    let courier_id = recording.meta.names.courier_id.clone();
    let answer = match known {
        Some(known) => Some(known),
        None => answered(order, &recording, identity.path)?,
    };
    let Some(answer) = answer else {
        let row = of_failure(
            identity,
            Some(&recording),
            "error of the program, not of its input; `courier diagnose` of this recording alone says where",
        );
        return Ok((FAILED.into(), courier_id, row));
    };
    let row = of_answer(identity, &recording, &answer)?;
    Ok((word(answer.verdict)?, courier_id, row))
}

/// The answer of a diagnosis; none where the program fails.
fn answered(order: &Order, recording: &Recording, path: &str) -> Result<Option<Diagnosis>> {
    let options = Options {
        without: order.without.clone(),
        explain: false,
    };
    // One processor a recording: what a diagnosis does side by side within itself would wait for others.
    let alone = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .context("a thread")?;
    let answer = catch_unwind(AssertUnwindSafe(|| {
        alone.install(|| diagnose(recording, path, &options))
    }));
    Ok(answer.ok())
}

fn word(verdict: Verdict) -> Result<String> {
    let value = serde_json::to_value(verdict)?;
    Ok(value.as_str().unwrap_or_default().to_owned())
}

/// SHA-256 of a recording's files, each behind its length; of one that is not there, that it is not.
fn content(path: &Path) -> String {
    let mut hash = Sha256::new();
    for file in files(path) {
        match std::fs::read(&file) {
            Ok(bytes) => {
                hash.update((bytes.len() as u64).to_le_bytes());
                hash.update(&bytes);
            }
            Err(error) => hash.update(error.kind().to_string()),
        }
    }
    hex(&hash.finalize())
}
