//! Many recordings, a row each: `courier diagnose A B … --out DIR`.
//!
//! `row` makes a row of an answer, `cell` is one value of it, `part` keeps each row in a file of its own. Recordings are diagnosed side by
//! side, each by one processor, so that an answer does not depend on how many there are.

pub mod cell;
pub mod part;
pub mod row;

use crate::interrupt;
use crate::provenance::files;
use crate::recordings;
use anyhow::{Context, Result};
use cell::Row;
use diagnosis::verdict::answer::Verdict;
use diagnosis::{Options, diagnose};
use part::{Key, Parts, hex};
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
                Ok(verdict) => count(&mut held(&done), verdict),
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
    let reached = done.already + done.verdicts.values().sum::<usize>();
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

fn count(done: &mut Done, verdict: Option<String>) {
    match verdict {
        Some(verdict) => *done.verdicts.entry(verdict).or_default() += 1,
        None => done.already += 1,
    }
}

/// The verdict of a recording whose row was written; none where it was there.
fn one(order: &Order, parts: &Parts, path: &Path) -> Result<Option<String>> {
    let name = path.display().to_string();
    let content = content(path);
    let without = order.without.join(",");
    let key = Key::new(
        &name,
        &content,
        &format!("{without};{:?}", order.resolution_m),
    );
    if parts.find(&key).is_some() {
        return Ok(None);
    }
    let identity = Identity {
        path: &name,
        content: &content,
        without: &without,
        resolution_m: order.resolution_m,
    };
    let (verdict, courier_id, row) = diagnosed(order, path, &identity)?;
    parts.put(&key, &courier_id, &row)?;
    Ok(Some(verdict))
}

/// Verdict, courier and row. What cannot be read or diagnosed has a row that says why.
fn diagnosed(order: &Order, path: &Path, identity: &Identity) -> Result<(String, String, Row)> {
    let recording = match recordings::read(path) {
        Ok(recording) => recording,
        Err(error) => {
            let row = of_failure(identity, None, &error.to_string());
            return Ok((FAILED.into(), String::new(), row));
        }
    };
    let courier_id = recording.meta.names.courier_id.clone();
    let options = Options {
        without: order.without.clone(),
    };
    // One processor a recording: what a diagnosis does side by side within itself would wait for others.
    let alone = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .context("a thread")?;
    let answer = catch_unwind(AssertUnwindSafe(|| {
        alone.install(|| diagnose(&recording, identity.path, &options))
    }));
    let Ok(answer) = answer else {
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
