//! `courier record DIR`.

use crate::json::Json;
use crate::output::{Files, Kind};
use crate::recordings;
use crate::board::Choice;
use crate::destination::Destination;
use crate::findings::{self, NOTHING};
use guided::question::Question;
use crate::interrupt::{self, EXIT_INTERRUPTED, Interrupted};
use recording::noise::at_rest::Noise;
use crate::recorder::{Order, Run, record};
use crate::survey;
use crate::terminal::{progress, warn};
use anyhow::{Context, Result, ensure};
use courier_sensor::drivers::motion::Target;
use courier_sensor::geometry::Geometry;
use std::path::PathBuf;
use std::process::ExitCode;

/// Record the raw counts of every sample that a board can send, in the recording layout.
///
/// The recording states how large the signals are and how noisy. The noise is measured in the half second before the first
/// motion, at the board's full rate, so the courier has to rest then. Wires, units and stated lengths that the readings contradict are
/// told in a line each.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  courier record flight --seconds 2 --go-to 0,40,0\n  courier --sim-preset ideal --sim-effect velocity_lag=2 record first --survey 0,0,0 && courier diagnose first"
)]
pub struct Args {
    /// Folder to make. A recording that is there already is not replaced without --force.
    pub(super) folder: PathBuf,
    /// How long, s.
    #[arg(long, default_value_t = 1.0, value_name = "S")]
    seconds: f64,
    /// One sample in so many [default: 1, or 20 for a survey].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub(super) decimation: Option<u16>,
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
    /// still; some 25 s. `--survey 0,0,0` is about where the controller's frame begins.
    #[arg(long, value_name = "X,Y,THETA", allow_hyphen_values = true, value_parser = super::target, conflicts_with_all = ["seconds", "run", "go_to", "speed_mm_s"])]
    survey: Option<Target>,
    /// Make the motions that `courier map` wants, within 4 mm of this place under a beacon, turned by up to 1.5°; some 40 s. A
    /// simulated courier's beacon need not be named.
    #[arg(long, value_name = "X,Y,THETA", num_args = 0..=1, require_equals = true, allow_hyphen_values = true, value_parser = super::target, conflicts_with_all = ["seconds", "run", "go_to", "speed_mm_s", "survey"])]
    under_beacon: Option<Option<Target>>,
    /// Move until the recording answers WHAT, and no longer: `platen`, `joint`, the name of an effect, or `all`.
    #[arg(long, value_name = "WHAT", value_parser = Question::of, conflicts_with_all = ["seconds", "run", "go_to", "speed_mm_s", "survey", "under_beacon"])]
    until_answers: Option<Question>,
    /// Place that those motions are about: mm, mm and degrees in the motion controller's frame.
    #[arg(long, value_name = "X,Y,THETA", default_value = "0,0,0", allow_hyphen_values = true, value_parser = super::target, requires = "until_answers")]
    pub(super) about: Target,
    /// The courier is moved by hand: each motion is told in words. A simulated courier is pushed by a simulated hand.
    #[arg(long, requires = "until_answers")]
    pub(super) by_hand: bool,
    /// End when so much is recorded, s, answered or not.
    #[arg(long, value_name = "S", default_value_t = 25.0, requires = "until_answers")]
    pub(super) most_seconds: f64,
    /// Name of the platen: recordings over one platen go together by it.
    #[arg(long, value_name = "NAME", default_value = "", hide_default_value = true)]
    pub(super) platen_id: String,
    /// Name of the beacon: one that has not been moved over the platen keeps it.
    #[arg(long, value_name = "NAME", default_value = "", hide_default_value = true)]
    pub(super) beacon_id: String,
    /// Noise of a quadrature channel and of an electrode, rms counts, for a courier that cannot rest [default: measured].
    #[arg(long, value_name = "QUADRATURE,ELECTRODE", allow_hyphen_values = true, value_parser = noise)]
    pub(super) noise_counts: Option<Noise>,
    /// Replace the recording in the folder.
    #[arg(long)]
    pub(super) force: bool,
    #[command(flatten)]
    pub(super) json: Json,
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
pub(super) const SURVEY_DECIMATION: u16 = 20;

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
    if let Some(question) = args.until_answers {
        return super::record_guided::run(args, question, choice);
    }
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
        surroundings: [args.platen_id.clone(), args.beacon_id.clone()],
        noise: args.noise_counts,
        runs,
    };
    interrupt::watch()?;
    let bar = progress(0, "recording: samples");
    let recorded = record(&mut board.link, board.world.as_ref(), &order, &bar);
    board.close()?;
    let recorded = match recorded {
        Err(error) if error.is::<Interrupted>() => {
            warn("interrupted: nothing was recorded");
            return Ok(ExitCode::from(EXIT_INTERRUPTED));
        }
        recorded => recorded?,
    };
    args.json.tell(ANSWER, &recorded, || {
        format!(
            "{} samples in {}, {} could not be taken; noise {:.2} counts",
            recorded.samples,
            args.folder.display(),
            recorded.lost,
            recorded.noise.quadrature_counts
        )
    })?;
    let place = args.folder.display().to_string();
    findings::check(&recordings::read(&args.folder)?, &place, NOTHING)?;
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

/// `QUADRATURE,ELECTRODE`, rms counts.
fn noise(text: &str) -> Result<Noise, String> {
    let numbers: Vec<f64> = text
        .split(',')
        .map_while(|part| part.trim().parse().ok())
        .collect();
    match numbers[..] {
        [quadrature_counts, electrode_counts]
            if text.split(',').count() == 2
                && numbers.iter().all(|n| (0.0..=32_768.0).contains(n)) =>
        {
            Ok(Noise {
                quadrature_counts,
                electrode_counts,
            })
        }
        _ => Err("wanted two numbers of counts, 0 to 32768".to_owned()),
    }
}
