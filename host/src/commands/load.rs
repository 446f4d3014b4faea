//! `courier load MODEL`.

use crate::json::Json;
use crate::output::{Files, Kind};
use crate::board::Choice;
use crate::board_model::BoardModel;
use crate::teeth::MapFile;
use crate::terminal::warn;
use anyhow::{Context, Result, bail, ensure};
use courier_sensor::drivers::motion::Target;
use courier_sensor::calibration::record::Quality;
use courier_sensor::link::message::{Action, Reply, Source};
use diagnosis::Model;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::ExitCode;

/// Make a diagnosed model further terms of a board's error model, and store it; or load a tooth map.
///
/// A map (of `courier map`) is stored with its own coefficients of equations (3) and (9), which are in force together with it; the stored
/// calibration stays as it is. Tooth counts begin anew at each start: the map is placed by the beacon under which it was made, so the
/// courier must stand under that, or go there. After a restart the board places it by itself as soon as it sees that beacon.
///
/// The board must have a calibration: its geometry and device stay, terms and coefficients become the model's. Recalibrate
/// afterwards: `courier calibrate` fits equation (3) anew beside the further terms. Effects that the board has no terms for
/// (those of the coordination sensor, clipping, slips, noise) are named and left out. Where nothing is named, the model holds a correction
/// without a name over the coordinates where the gap lies: what of it changes over a tooth with the speed, the direction or the temperature
/// becomes terms.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  courier diagnose first --model model.json && courier --sim-flash board.bin load model.json"
)]
pub struct Args {
    /// The model, as `courier diagnose --model` wrote it, or the map of `courier map`.
    pub(super) model: PathBuf,
    /// For a map, the name of its place: a stored map of the same name is replaced [default: the file's name].
    #[arg(long, value_name = "NAME")]
    pub(super) place: Option<String>,
    /// Put it in force, but do not store it.
    #[arg(long)]
    pub(super) dry_run: bool,
    /// For a map, go under the beacon first: mm, mm and degrees in the motion controller's frame [default: a simulated courier's
    /// own beacon].
    #[arg(long, value_name = "X,Y,THETA", allow_hyphen_values = true, value_parser = super::target)]
    pub(super) from: Option<Target>,
    #[command(flatten)]
    pub(super) json: Json,
}

/// What `--json` writes.
pub(super) const ANSWER: Kind = Kind::json("an answer of `courier load`", &["stored"]);

impl Args {
    /// The files that it reads and writes.
    pub fn files(&self) -> Files {
        Files::default().reads(&self.model).json(&self.json, ANSWER)
    }
}

/// Reads, translates, loads, stores.
///
/// # Errors
/// The file is no model, nothing of it is a term of the board, or the board has no calibration or refuses; what was in force
/// still is.
pub fn run(args: &Args, choice: &Choice) -> Result<ExitCode> {
    let name = args.model.display().to_string();
    let text = std::fs::read_to_string(&args.model)
        .with_context(|| format!("{name}: a readable model was wanted"))?;
    let value: serde_json::Value = serde_json::from_str(&text).with_context(|| {
        format!(
            "{name}: a model by `courier diagnose --model`, or a map by `courier map`, was wanted"
        )
    })?;
    if MapFile::is_one(&value) {
        let file = MapFile::from_json(&args.model, value)?;
        return super::load_map::run(&file, args, choice);
    }
    let model: Model = serde_json::from_value(value)
        .with_context(|| format!("{name}: a model by `courier diagnose --model` was wanted"))?;
    ensure!(
        model.schema == 1,
        "{name}: schema: found {}, wanted 1",
        model.schema
    );
    let mut board = choice.open()?;
    let Reply::Calibration(mut calibration) = board.link.ask(Action::Read(Source::InForce))? else {
        bail!(super::STRANGE_REPLY)
    };
    let translated = BoardModel::new(&model, &calibration.geometry).context(name)?;
    calibration.model = translated.model;
    // What the model before left is not what this one leaves, which nobody has measured on the board yet.
    (calibration.quality, calibration.poses) = (Quality::default(), None);
    let Reply::Done = board.link.ask(Action::load(calibration))? else {
        bail!(super::STRANGE_REPLY)
    };
    let stored = if args.dry_run {
        None
    } else {
        let Reply::Place(place) = board.link.ask(Action::Commit {
            lose_unknown: false,
        })?
        else {
            bail!(super::STRANGE_REPLY)
        };
        Some(place)
    };
    board.close()?;
    if !args.json.is_printed() {
        translated.left.iter().for_each(|line| warn(line));
    }
    let taken: Vec<String> = translated
        .taken
        .iter()
        .map(|(effect, terms)| format!("{effect} ({terms} terms)"))
        .collect();
    let place = stored.map_or("in force, not stored".to_owned(), |place| {
        format!(
            "in force and stored: slot {}, number {}",
            place.slot, place.sequence
        )
    });
    let terms: BTreeMap<_, _> = translated.taken.iter().cloned().collect();
    let told = serde_json::json!({ "terms": terms, "left": translated.left, "left_rms_m": translated.left_m, "stored": stored });
    args.json.tell(ANSWER, &told, || {
        format!("{}\n{place}; next: courier calibrate", taken.join(", "))
    })?;
    Ok(ExitCode::SUCCESS)
}
