//! `courier fleet RECORDING …`.

use super::fleet_text::text;
use crate::findings::{self, BOTH_SENSORS};
use crate::json::Json;
use crate::output::{self, Files, Kind};
use crate::recordings;
use crate::terminal::{progress, warn};
use anyhow::{Context, Result, ensure};
use fleet::{Fitted, Member, Part, State, answer, at, begin, fit};
use serde::de::DeserializeOwned;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Fit several couriers over shared platens together: what of their errors is the sensors' and what is the platens'.
///
/// Each recording is of one courier under a beacon, as `courier record --under-beacon` makes it, and states `courier_id` and `platen_id`.
/// Couriers that cross the same teeth, and a courier over other teeth, part what one recording cannot: a courier's own errors, its spans
/// and the displaced teeth. A platen's recordings are put over each other by the beacon and by the teeth themselves.
///
/// The sums that the fit needs add: an engine forms them with --part, one recording at a time, adds them with --join, and takes a
/// step with --step; at its last state --at tells the answer.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  courier fleet hall\n  courier fleet hall/c1 hall/c2 --json fleet.json\n  courier fleet hall/c1 --part c1.part\n  courier fleet c1.part c2.part --join both.part\n  courier fleet both.part --step start.state\n  courier fleet hall/c1 --part c1.part --at start.state"
)]
pub struct Args {
    /// Recordings, or a folder that holds them; for --join and --step, parts.
    #[arg(required = true, num_args = 1.., value_name = "INPUT")]
    inputs: Vec<PathBuf>,
    /// A state that --step wrote: take the sums there, or tell the answer there without a further step.
    #[arg(long, value_name = "STATE")]
    at: Option<PathBuf>,
    /// Write the sums of one recording to this file, at the state if there is one.
    #[arg(long, value_name = "FILE")]
    part: Option<PathBuf>,
    /// Add parts, and write their sum to this file.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["part", "at"])]
    join: Option<PathBuf>,
    /// Take a step from parts of all recordings, at the state if there is one, and write the next state to this file.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["part", "join"])]
    step: Option<PathBuf>,
    #[command(flatten)]
    json: Json,
}

/// What `--json` writes.
const ANSWER: Kind = Kind::json(
    "an answer of `courier fleet`",
    &["couriers", "platens", "recordings"],
);
/// What `--json` writes of a step.
const PROGRESS: Kind = Kind::json("the progress of `courier fleet`", &["steps", "is_settled"]);
/// What `--part` and `--join` write.
const PART: Kind = Kind::json("a part of `courier fleet`", &["courier_fleet_part"]);
/// What `--step` writes.
const STATE: Kind = Kind::json("a state of `courier fleet`", &["courier_fleet_state"]);
/// Steps of a usual fit, for the progress bar.
const STEPS: u64 = 50;

impl Args {
    /// The files that it reads and writes.
    pub fn files(&self) -> Files {
        let read = |files: Files, path: &PathBuf| {
            if path.is_dir() {
                files.reads_recording(path)
            } else {
                files.reads(path)
            }
        };
        let inputs = recordings::within(&self.inputs);
        let files = inputs.iter().chain(&self.at).fold(Files::default(), read);
        let told = if self.step.is_some() { PROGRESS } else { ANSWER };
        files
            .writes(self.part.as_ref(), PART)
            .writes(self.join.as_ref(), PART)
            .writes(self.step.as_ref(), STATE)
            .json(&self.json, told)
    }
}

/// Reads, fits, prints.
///
/// # Errors
/// A recording that cannot be read, or those that do not go together; nothing is written then.
pub fn run(args: &Args) -> Result<ExitCode> {
    let state = args.at.as_deref().map(read_state).transpose()?;
    if let Some(path) = &args.part {
        let [folder] = args.inputs.as_slice() else {
            anyhow::bail!("--part: found {} recordings, wanted one", args.inputs.len());
        };
        return write(path, PART, &Part::of(&member(folder)?, state.as_ref())?);
    }
    if let Some(path) = &args.join {
        return write(path, PART, &joined(&args.inputs)?);
    }
    if let Some(path) = &args.step {
        let (next, progress) = joined(&args.inputs)?.next(state.as_ref())?;
        write(path, STATE, &next)?;
        args.json.tell(PROGRESS, &progress, || match progress.decrement {
            Some(decrement) => format!(
                "{} steps; the squares of what is left fall by {decrement:.1e} with the last; settled: {}",
                progress.steps,
                if progress.is_settled { "yes" } else { "no" }
            ),
            None => "where the recordings lead by themselves".to_owned(),
        })?;
        return Ok(ExitCode::SUCCESS);
    }
    let inputs = recordings::within(&args.inputs);
    let members: Vec<Member> = inputs.iter().map(|path| member(path)).collect::<Result<_>>()?;
    ensure!(
        members.len() > 1,
        "{}: found it alone, wanted two recordings or more: `courier map` tells the teeth under one",
        inputs[0].display()
    );
    let bar = progress(STEPS, "fitting");
    let fitted = fitted(&members, state, &|| bar.inc(1));
    bar.finish_and_clear();
    let fitted = fitted?;
    if !fitted.is_settled() {
        warn(&format!(
            
            "not settled: the squares of what is left would fall by {:.1e} with another step",
            fitted.solution.decrement
        ));
    }
    let answer = answer(&members, &fitted)?;
    args.json.tell(ANSWER, &answer, || text(&answer))?;
    Ok(ExitCode::SUCCESS)
}

fn fitted(members: &[Member], state: Option<State>, tick: &(dyn Fn() + Sync)) -> Result<Fitted> {
    let Some(state) = state else {
        return fit(members, tick);
    };
    for member in members {
        ensure!(
            state.recordings.contains_key(&member.recording),
            "{}: found it in no recording of the state, wanted one from whose parts the state was made",
            member.recording
        );
    }
    let beginnings = members.iter().map(begin).collect::<Result<_>>()?;
    at(members, beginnings, Some(state))
}

/// A recording's poses, under the name of its folder.
fn member(folder: &Path) -> Result<Member> {
    let place = folder.display().to_string();
    let recording = recordings::read(folder)?;
    recording.warnings.iter().for_each(|line| warn(line));
    findings::check(&recording, &place, BOTH_SENSORS)?;
    let name = folder.file_name().map(|name| name.to_string_lossy().into_owned());
    Member::of(&name.unwrap_or(place), &recording)
}

fn joined(paths: &[PathBuf]) -> Result<Part> {
    let parts: Vec<Part> = paths.iter().map(|path| read_json(path)).collect::<Result<_>>()?;
    Part::join(parts)
}

fn read_state(path: &Path) -> Result<State> {
    let state: State = read_json(path)?;
    state.check().with_context(|| path.display().to_string())?;
    Ok(state)
}

fn read_json<T: DeserializeOwned>(path: &Path) -> Result<T> {
    let place = || path.display().to_string();
    let text = std::fs::read(path).with_context(place)?;
    serde_json::from_slice(&text)
        .with_context(|| format!("{}: wanted a file that `courier fleet` wrote", place()))
}

fn write(path: &Path, kind: Kind, value: &impl serde::Serialize) -> Result<ExitCode> {
    output::write(path, kind, &serde_json::to_vec(value)?)?;
    Ok(ExitCode::SUCCESS)
}
