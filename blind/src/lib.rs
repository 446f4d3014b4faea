//! The whole tool checked on data whose effect is withheld: [`write()`] makes recordings and seals the answers under a hash,
//! [`diagnose()`] sees nothing but the recordings, [`score()`] opens the seal and counts.
//!
//! The folder: `recordings/case_000` …, `second/case_000` … (the same couriers again, for `check`), `answers.json` (sealed),
//! `seal.txt`, `diagnoses/case_000.json`, `models/case_000.json`.

pub mod bounded;
mod claim;
mod detection;
mod figure;
mod ideal;
mod judged;
mod page;
mod reliability;
mod seal;
mod stated;
mod tally;
mod verdicts;
mod words;

pub use claim::{CLAIM_WITHIN, Claim};
pub use detection::Detection;
pub use figure::Figure;
pub use ideal::{Ideal, ideal};
pub use judged::Judged;
pub use page::page;
pub use reliability::{Outcome, Reliability, Tenth};
pub use specimens::{Case, Conditions, Drawn, Kind};
pub use stated::Stated;
pub use tally::Score;
pub use words::{Words, confusion, detection, effects, figures, matrix, reliability, shrinkage};

use diagnosis::design::assembly::Options;
use diagnosis::figures::limits::VISIBLE_GAP_RATIO;
use diagnosis::verdict::answer::{Diagnosis, Verdict};
use diagnosis::{Model, check};
use diagnosis::{diagnose as diagnose_recording, diagnose_fully};
use effects::Card;
use rayon::prelude::*;
use recording::{Existing, Recording};
use serde::de::DeserializeOwned;
use std::path::{Path, PathBuf};

/// Cases that run side by side.
const THREADS: usize = 2;
/// File of the sealed answers.
const ANSWERS: &str = "answers.json";
/// File of their hash.
const SEAL: &str = "seal.txt";

/// Why a step could not be done: one line.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file could not be read or written.
    #[error("{}: {problem}", path.display())]
    File {
        /// The file or folder.
        path: PathBuf,
        /// What was found and wanted.
        problem: String,
    },
    /// The answers are not those that were sealed.
    #[error(
        "answers.json: found hash {found}, wanted {wanted} of seal.txt: the answers were changed after sealing"
    )]
    BrokenSeal {
        /// Hash of what is there.
        found: String,
        /// Hash that was printed first.
        wanted: String,
    },
    /// A recording is bad.
    #[error(transparent)]
    Recording(#[from] recording::Error),
}

impl Error {
    fn file(path: &Path, problem: impl ToString) -> Self {
        Self::File {
            path: path.into(),
            problem: problem.to_string(),
        }
    }
}

/// Outcome of a step.
pub type Result<T> = std::result::Result<T, Error>;

fn name(case: usize) -> String {
    format!("case_{case:03}")
}

fn pool() -> Result<rayon::ThreadPool> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(THREADS)
        .build()
        .map_err(|e| Error::file(Path::new("threads"), e))
}

fn read_json<T: DeserializeOwned>(path: &Path) -> Result<T> {
    let text = std::fs::read_to_string(path).map_err(|e| Error::file(path, e))?;
    serde_json::from_str(&text).map_err(|e| Error::file(path, e))
}

fn write_json<T: serde::Serialize>(path: &Path, value: &T) -> Result<()> {
    let text = serde_json::to_string_pretty(value).map_err(|e| Error::file(path, e))?;
    std::fs::write(path, text).map_err(|e| Error::file(path, e))
}

fn folder(path: PathBuf) -> Result<PathBuf> {
    std::fs::create_dir_all(&path).map_err(|e| Error::file(&path, e))?;
    Ok(path)
}

/// First step: recordings of `cases` couriers drawn from `seed` into an empty or new folder, under the usual conditions or under such
/// as are drawn for each, and the sealed answers.
/// Returns the hash. `sealed` is told the hash before anything is recorded; `tick` is called after each case.
///
/// # Errors
/// The folder is not empty or cannot be written.
pub fn write(
    into: &Path,
    cases: usize,
    seed: u64,
    conditions: Conditions,
    sealed: impl FnOnce(&str),
    tick: impl Fn() + Sync,
) -> Result<String> {
    folder(into.into())?;
    let full = std::fs::read_dir(into)
        .map_err(|e| Error::file(into, e))?
        .next()
        .is_some();
    if full {
        return Err(Error::file(
            into,
            "found a folder that is not empty, wanted an empty or a new one",
        ));
    }
    let drawn: Vec<Case> = (0..cases)
        .map(|number| Case::draw(number, seed, conditions))
        .collect();
    let answers = seal::answers(&drawn).map_err(|problem| Error::file(into, problem))?;
    let hash = seal::hash(answers.as_bytes());
    sealed(&hash);
    std::fs::write(into.join(ANSWERS), &answers)
        .map_err(|e| Error::file(&into.join(ANSWERS), e))?;
    std::fs::write(into.join(SEAL), format!("{hash}\n"))
        .map_err(|e| Error::file(&into.join(SEAL), e))?;
    let (first, second) = (
        folder(into.join("recordings"))?,
        folder(into.join("second"))?,
    );
    pool()?.install(|| {
        drawn.par_iter().try_for_each(|case| {
            case.recorded(0)
                .write(first.join(name(case.number)), Existing::Refuse)?;
            case.recorded(1)
                .write(second.join(name(case.number)), Existing::Refuse)?;
            tick();
            Ok::<_, Error>(())
        })
    })?;
    Ok(hash)
}

/// Number of recordings in a folder.
///
/// # Errors
/// There are none.
pub fn count(folder: &Path) -> Result<usize> {
    let path = folder.join("recordings");
    let entries = std::fs::read_dir(&path).map_err(|e| Error::file(&path, e))?;
    match entries
        .filter_map(std::result::Result::ok)
        .filter(|e| e.file_name().to_string_lossy().starts_with("case_"))
        .count()
    {
        0 => Err(Error::file(
            &path,
            "found no case, wanted those of `courier blind write`",
        )),
        cases => Ok(cases),
    }
}

/// Second step: diagnoses every recording, with nothing but the recordings.
///
/// # Errors
/// A recording is missing or bad, or an answer cannot be written.
pub fn diagnose(within: &Path, tick: impl Fn() + Sync) -> Result<usize> {
    let cases = count(within)?;
    let (diagnoses, models) = (
        folder(within.join("diagnoses"))?,
        folder(within.join("models"))?,
    );
    pool()?.install(|| {
        (0..cases).into_par_iter().try_for_each(|case| {
            let path = within.join("recordings").join(name(case));
            let recording = Recording::read(&path)?;
            let answer = diagnose_fully(&recording, &name(case), &Options::default());
            write_json(
                &diagnoses.join(name(case)).with_extension("json"),
                &answer.diagnosis,
            )?;
            if let Some(model) = &answer.model {
                write_json(&models.join(name(case)).with_extension("json"), model)?;
            }
            tick();
            Ok::<_, Error>(())
        })
    })?;
    Ok(cases)
}

/// Third step: opens the seal and scores. `thorough` also diagnoses each single effect's recording with that effect taken out
/// of the catalogue, the same courier with its effects known exactly for the best possible gap, and with each of two effects alone; and it
/// tells what an ideal observer sees of each recording.
///
/// # Errors
/// The seal is broken, or a step before is missing.
pub fn score(within: &Path, thorough: bool, tick: impl Fn() + Sync) -> Result<Score> {
    let path = within.join(ANSWERS);
    let text = std::fs::read_to_string(&path).map_err(|e| Error::file(&path, e))?;
    let seal_path = within.join(SEAL);
    let wanted = std::fs::read_to_string(&seal_path)
        .map_err(|e| Error::file(&seal_path, e))?
        .trim()
        .to_owned();
    let found = seal::hash(text.as_bytes());
    if found != wanted {
        return Err(Error::BrokenSeal { found, wanted });
    }
    let cases = seal::open(&text).map_err(|problem| Error::file(&path, problem))?;
    let judged = pool()?.install(|| {
        cases
            .par_iter()
            .map(|case| {
                let judged = judge(within, case, thorough);
                tick();
                judged
            })
            .collect::<Result<Vec<Judged>>>()
    })?;
    Ok(Score::new(wanted, judged))
}

fn judge(within: &Path, case: &Case, thorough: bool) -> Result<Judged> {
    let of = |folder: &str| within.join(folder).join(name(case.number));
    let answer: Diagnosis = read_json(&of("diagnoses").with_extension("json"))?;
    let claim = if answer.effects.is_empty() {
        None
    } else {
        let model: Model = read_json(&of("models").with_extension("json"))?;
        let again = check(&model, &Recording::read(of("second"))?).ok();
        let best = (thorough && has_best(case)).then(|| {
            let recording = case.known_exactly();
            diagnose_recording(&recording, "known exactly", &Options::default()).held_out
        });
        Some(Claim::new(&answer.held_out, again.as_ref(), best.as_ref()))
    };
    let without = match (&case.kind, thorough) {
        (Kind::Single, true) => {
            let options = Options {
                without: vec![case.effects[0].name.clone()],
                ..Options::default()
            };
            let names =
                diagnose_recording(&Recording::read(of("recordings"))?, "withheld", &options)
                    .effects;
            Some(names.into_iter().map(|e| e.name).collect())
        }
        _ => None,
    };
    let mut judged = Judged::new(case, &answer, claim, without);
    judged.hidden = (thorough && case.kind == Kind::Pair).then(|| hidden(case));
    judged.ideal = thorough.then(|| ideal(case));
    Ok(judged)
}

/// All effects withheld but those that act.
fn those_that_act(case: &Case) -> Options {
    let acts = |card: &&Card| case.effects.iter().any(|e| e.name == card.name);
    let others = effects::cards().filter(|card| !acts(card));
    Options {
        without: others.map(|card| card.name.to_owned()).collect(),
        ..Options::default()
    }
}

/// Whether there is a best possible model that another recording could confirm: the course of a drift belongs to its own
/// recording's time.
fn has_best(case: &Case) -> bool {
    !case
        .effects
        .iter()
        .any(|e| effects::has(&e.name, Card::keeps_its_own_time))
}

/// Effects of a case that are no gap by themselves.
fn hidden(case: &Case) -> Vec<String> {
    let names = case.effects.iter().map(|e| e.name.clone());
    let no_gap = |name: &String| {
        let alone = diagnose_recording(&case.with_only(name), "alone", &Options::default());
        alone.verdict == Verdict::NoGap && alone.held_out.whitened_before < VISIBLE_GAP_RATIO
    };
    names.filter(no_gap).collect()
}
