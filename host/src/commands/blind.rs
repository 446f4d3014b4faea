//! `courier blind`.

use crate::json::Json;
use crate::kinds;
use crate::output::{self, Files, Kind};
use crate::provenance::origin;
use crate::terminal::{progress, table};
use anyhow::{Context, Result};
use blind::{self, Score};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Check the diagnosis on simulated couriers whose effects are withheld.
///
/// Couriers are drawn with no effect, one, two, or one that is in no catalogue, and recorded; the answers are sealed under a
/// hash that is printed first. The recordings are diagnosed, then the seal is opened and the answers are scored. Without a
/// step all three are done in a row.
#[derive(Debug, clap::Args)]
#[command(
    args_conflicts_with_subcommands = true,
    disable_help_subcommand = true,
    after_help = "Example:\n  courier blind --cases 40 --seed 7 --report blind.html\n\nExample, step by step:\n  courier blind write cases --cases 40 --seed 7\n  courier blind diagnose cases\n  courier blind score cases"
)]
pub struct Args {
    #[command(subcommand)]
    step: Option<Step>,
    #[command(flatten)]
    draw: Draw,
    /// Keep recordings, answers and diagnoses in this folder, empty or new; otherwise they are thrown away.
    #[arg(long, value_name = "DIR")]
    folder: Option<PathBuf>,
    #[command(flatten)]
    told: Told,
}

/// What is drawn.
#[derive(Debug, clap::Args)]
struct Draw {
    /// Number of couriers.
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    cases: u32,
    /// Seed: the same one draws the same couriers.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// How the couriers are moved and recorded.
    #[arg(long, value_enum, default_value_t = Conditions::Usual)]
    conditions: Conditions,
}

/// How the couriers of a blind check are moved and recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Conditions {
    /// With the usual runs, all channels, a laboratory's temperature and the noise as it is.
    Usual,
    /// Motions, temperature, channels and stated noise are drawn for each courier; up to three effects, from a third of the noise floor
    /// to twenty times it.
    Drawn,
}

impl From<Conditions> for blind::Conditions {
    fn from(conditions: Conditions) -> Self {
        match conditions {
            Conditions::Usual => Self::Usual,
            Conditions::Drawn => Self::Drawn,
        }
    }
}

/// How the scores are told.
#[derive(Debug, clap::Args)]
struct Told {
    #[command(flatten)]
    json: Json,
    /// Write the scores with plots to this file.
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Leave out what needs further diagnoses: effects taken out of the catalogue, the best possible gap, what an ideal observer sees.
    #[arg(long)]
    quick: bool,
}

/// One step.
#[derive(Debug, clap::Subcommand)]
enum Step {
    /// Draw couriers, seal the answers, record.
    Write {
        /// Folder to write into, empty or new.
        folder: PathBuf,
        #[command(flatten)]
        draw: Draw,
    },
    /// Diagnose the recordings, with nothing but them.
    Diagnose {
        /// The folder of `courier blind write`.
        folder: PathBuf,
    },
    /// Open the seal and score.
    Score {
        /// The folder of `courier blind write`.
        folder: PathBuf,
        #[command(flatten)]
        told: Told,
    },
}

/// What `--json` writes.
const SCORE: Kind = Kind::json("scores of a blind check", &["seal", "judged", "figures"]);

impl Args {
    /// The files that it reads and writes.
    pub fn files(&self) -> Files {
        let files = Files::default();
        match &self.step {
            None => {
                let files = self.folder.iter().fold(files, |files, folder| files.fills(folder));
                self.told.files(files)
            }
            Some(Step::Score { folder, told }) => told.files(files.reads(folder)),
            Some(Step::Write { folder, .. } | Step::Diagnose { folder }) => files.fills(folder),
        }
    }
}

impl Told {
    fn files(&self, files: Files) -> Files {
        files
            .json(&self.json, SCORE)
            .writes(self.report.as_ref(), kinds::PAGE)
    }
}

/// Does a step, or all of them.
///
/// # Errors
/// A folder that is not as it should be, or a broken seal.
pub fn run(args: &Args) -> Result<ExitCode> {
    match &args.step {
        Some(Step::Write { folder, draw }) => write(folder, draw)?,
        Some(Step::Diagnose { folder }) => {
            let cases = diagnose(folder)?;
            eprintln!(
                "{cases} recordings diagnosed; next: courier blind score {}",
                folder.display()
            );
        }
        Some(Step::Score { folder, told }) => score(folder, told)?,
        None => {
            let scratch = tempfile::tempdir().context("a folder for the recordings")?;
            let folder = args.folder.as_deref().unwrap_or(scratch.path());
            write(folder, &args.draw)?;
            diagnose(folder)?;
            score(folder, &args.told)?;
        }
    }
    Ok(ExitCode::SUCCESS)
}

fn write(folder: &Path, draw: &Draw) -> Result<()> {
    let bar = progress(u64::from(draw.cases), "recording couriers");
    // On standard error: standard output may be the JSON alone.
    blind::write(
        folder,
        draw.cases as usize,
        draw.seed,
        draw.conditions.into(),
        |hash| bar.suspend(|| eprintln!("seal (SHA-256 of the answers): {hash}")),
        || bar.inc(1),
    )?;
    bar.finish_and_clear();
    Ok(())
}

fn diagnose(folder: &Path) -> Result<usize> {
    let bar = progress(blind::count(folder)? as u64, "diagnosing");
    let cases = blind::diagnose(folder, || bar.inc(1))?;
    bar.finish_and_clear();
    Ok(cases)
}

fn score(folder: &Path, told: &Told) -> Result<()> {
    let bar = progress(blind::count(folder)? as u64, "opening the seal, scoring");
    let score = blind::score(folder, !told.quick, || bar.inc(1))?;
    bar.finish_and_clear();
    if let Some(path) = &told.report {
        output::write(path, kinds::PAGE, blind::page(&score, &origin()).as_bytes())?;
    }
    told.json.tell(SCORE, &score, || text(&score))
}

/// The figures, what the stated probabilities are worth, what was answered to what, detection by size, shrinkage, and every case that was not right.
fn text(score: &Score) -> String {
    let mut out = format!("seal {} holds; {} cases\n", score.seal, score.cases);
    let parts = [
        blind::figures(score),
        blind::reliability(score),
        blind::confusion(score),
        blind::detection(score),
        blind::effects(score),
        blind::shrinkage(score),
        wrong(score),
    ];
    let tables = parts.iter().filter(|(_, rows)| !rows.is_empty());
    let told = tables.map(|(header, rows)| {
        let header: Vec<&str> = header.iter().map(String::as_str).collect();
        table(&header, rows)
    });
    out += &told.collect::<Vec<_>>().join("\n\n");
    out
}

/// Every case that was not right.
fn wrong(score: &Score) -> blind::Words {
    let effect = |e: &blind::Drawn| format!("{} {:.2} µm", e.name, 1e6 * e.size_m);
    let rows = score.judged.iter().filter(|j| !j.right()).map(|j| {
        let truth: Vec<String> = j.case.effects.iter().map(effect).collect();
        let answer = if j.named.is_empty() {
            j.answered()
        } else {
            j.named.join(" + ")
        };
        vec![
            format!("case_{:03}", j.case.number),
            truth.join(" + "),
            answer,
            j.places.first().cloned().unwrap_or_default(),
        ]
    });
    let header = ["not right", "truth", "answer", "placed over"].map(Into::into);
    (header.to_vec(), rows.collect())
}
