//! `courier record DIR`.

use crate::json::Json;
use crate::output::{Files, Kind};
use crate::board::Choice;
use crate::destination::Destination;
use crate::recorder::{Order, Run, record};
use crate::survey;
use crate::terminal::progress;
use anyhow::{Context, Result, ensure};
use courier_sensor::drivers::motion::Target;
use courier_sensor::geometry::Geometry;
use std::path::PathBuf;
use std::process::ExitCode;

/// Record the raw counts of every sample that a board can send, in the recording layout.
///
/// Amplitudes and noise in recording.toml are measured from the recording itself: the noise by third differences of
/// neighbouring samples, which a smooth motion does not reach.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  courier --probe any record flight --seconds 2 --go-to 0,40,0\n  courier --probe any record survey --survey 0,0,0"
)]
pub struct Args {
    /// Folder to make. A recording that is there already is not replaced without --force.
    folder: PathBuf,
    /// How long, s.
    #[arg(long, default_value_t = 1.0, value_name = "S")]
    seconds: f64,
    /// One sample in so many [default: 1, or 20 for a survey].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    decimation: Option<u16>,
    /// Name of the motion.
    #[arg(long, default_value = "recorded")]
    run: String,
    /// Move there meanwhile: mm, mm and degrees in the motion controller's frame.
    #[arg(long, value_name = "X,Y,THETA", allow_hyphen_values = true, value_parser = super::target)]
    go_to: Option<Target>,
    /// Speed of that motion, mm/s.
    #[arg(long, default_value_t = 50.0, value_name = "MM_S", requires = "go_to")]
    speed_mm_s: f32,
    /// Make the motions that a diagnosis wants, within 26 mm of this place: both directions, three speeds, turned, turning,
    /// still; some 25 s.
    #[arg(long, value_name = "X,Y,THETA", allow_hyphen_values = true, value_parser = super::target, conflicts_with_all = ["seconds", "run", "go_to", "speed_mm_s"])]
    survey: Option<Target>,
    /// Make the motions that `courier map` wants, within 4 mm of this place under a beacon, turned by up to 1.5°; some 40 s. A
    /// simulated courier's beacon need not be named.
    #[arg(long, value_name = "X,Y,THETA", num_args = 0..=1, require_equals = true, allow_hyphen_values = true, value_parser = super::target, conflicts_with_all = ["seconds", "run", "go_to", "speed_mm_s", "survey"])]
    under_beacon: Option<Option<Target>>,
    /// Replace the recording in the folder.
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    json: Json,
}

/// What `--json` writes.
const ANSWER: Kind = Kind::json("an answer of `courier record`", &["samples", "lost"]);

impl Args {
    /// The files that it reads and writes.
    pub fn files(&self) -> Files {
        Files::default().fills(&self.folder).json(&self.json, ANSWER)
    }
}

/// A survey's samples at 20 kHz: one a millisecond.
const SURVEY_DECIMATION: u16 = 20;

/// Records and says how many samples there are and how many are not.
///
/// # Errors
/// The board cannot be reached or refuses the motion, or the folder cannot be written.
pub fn run(args: &Args, choice: &Choice) -> Result<ExitCode> {
    ensure!(
        (1.0e-3..=86_400.0).contains(&args.seconds),
        "--seconds: found {}, wanted 0.001 to 86400",
        args.seconds
    );
    let mut board = choice.open()?;
    let (runs, decimation) = match (args.survey, args.under_beacon) {
        (Some(centre), _) => (survey::runs(centre), SURVEY_DECIMATION),
        (None, Some(place)) => {
            let centre = place.or(board.beacon).context(
                "--under-beacon: found no place, wanted =X,Y,THETA: only a simulated courier's beacon is known",
            )?;
            let lever_m = Geometry::PAPER.lever_m;
            (survey::under_beacon(centre, lever_m), SURVEY_DECIMATION)
        }
        (None, None) => (vec![single(args)], 1),
    };
    let to = Destination {
        folder: args.folder.clone(),
        force: args.force,
    };
    let order = Order {
        to,
        decimation: args.decimation.unwrap_or(decimation),
        runs,
    };
    let recorded = record(&mut board.link, &order, &progress(0, "recording: samples"))?;
    board.close()?;
    args.json.tell(ANSWER, &recorded, || {
        format!(
            "{} samples in {}, {} could not be taken",
            recorded.samples,
            args.folder.display(),
            recorded.lost
        )
    })?;
    Ok(ExitCode::SUCCESS)
}

fn single(args: &Args) -> Run {
    let to = args.go_to.map(|target| (target, args.speed_mm_s * 1.0e-3));
    Run {
        name: args.run.clone(),
        from: None,
        to,
        seconds: args.seconds,
    }
}
