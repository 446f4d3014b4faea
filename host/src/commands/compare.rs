//! `courier compare A B …`.

use crate::compared::{self, Compared, check, page, text};
use crate::findings::{self, SEGMENTS_AND_REFERENCE};
use crate::json::Json;
use crate::kinds;
use crate::output::{self, Files, Kind};
use crate::provenance::origin_of_files;
use crate::recordings;
use crate::terminal::warn;
use anyhow::{Result, ensure};
use comparison::answer::{Question, answer};
use comparison::budget::{Conditions, PAPER_TEETH_M};
use comparison::estimate::Estimate;
use comparison::workspace::Pose;
use courier_sensor::drivers::motion::Target;
use courier_sensor::geometry::Geometry;
use recording::Recording;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Say whether calibrations differ beyond chance, which terms changed, by how many micrometres and where; or what one is worth.
///
/// Each is a calibration that `courier export` wrote, a model that `courier diagnose --model` wrote, or a recording's folder, which is
/// fitted as `courier replay` does. All are held against the first, and three or more give a trend too: by the time they were made where
/// all have one, else in the order given. A budget lists what a calibrated position and angle are uncertain by, in the form of the Guide
/// to the Expression of Uncertainty in Measurement (JCGM 100:2008).
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  courier compare january.json june.json\n  courier compare courier7.json --budget --at 0.3,0.1,0 --report budget.html"
)]
pub struct Args {
    /// Calibrations, models or recordings of one courier.
    #[arg(required = true, num_args = 1..)]
    inputs: Vec<PathBuf>,
    /// Tell the uncertainty of a calibrated position and angle by each of them.
    #[arg(long)]
    budget: bool,
    /// Where: x and y from a tooth's middle, mm, and the angle, degrees [default: where it is largest].
    #[arg(long, value_name = "X,Y,THETA", allow_hyphen_values = true, value_parser = super::target, requires = "budget")]
    at: Option<Target>,
    /// Displacement of teeth that no parity tells, µm: the standard deviation [default: 1.9, the paper's over seven teeth; 0 with a tooth map].
    #[arg(long, value_name = "UM", requires = "budget")]
    teeth_um: Option<f64>,
    /// How far a segment's output depends on the place across it, µm: the standard deviation [default: 0.63 of what the parity was left with, as the
    /// paper found it; nothing where lateral terms were fitted or looked for].
    #[arg(long, value_name = "UM", requires = "budget")]
    lateral_um: Option<f64>,
    /// The temperature lies within so many kelvin of the calibration's.
    #[arg(long, value_name = "K", requires = "at")]
    within_k: Option<f64>,
    /// Largest angle of the workspace, degrees.
    #[arg(long, value_name = "DEG", default_value_t = 0.5)]
    turn_deg: f64,
    /// So many of the first are repeats of one state, whose scatter tells what chance is.
    #[arg(long, value_name = "N", default_value_t = 0)]
    repeats: usize,
    /// Compare them though they are of different boards.
    #[arg(long)]
    other_device: bool,
    #[command(flatten)]
    json: Json,
    /// Write a report with plots to this file: one HTML file that needs no network.
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
}

/// What `--json` writes.
const ANSWER: Kind = Kind::json(
    "an answer of `courier compare`",
    &["compared", "differences"],
);

impl Args {
    /// The files that it reads and writes.
    pub fn files(&self) -> Files {
        let read = |files: Files, path: &PathBuf| {
            if recordings::is_recording(path) {
                files.reads_recording(path)
            } else {
                files.reads(path)
            }
        };
        self.inputs
            .iter()
            .fold(Files::default(), read)
            .json(&self.json, ANSWER)
            .writes(self.report.as_ref(), kinds::PAGE)
    }
}

/// Reads, compares, prints.
///
/// # Errors
/// Something that cannot be read or is of another courier, or a number out of range.
pub fn run(args: &Args) -> Result<ExitCode> {
    let question = args.question()?;
    let mut list = args
        .inputs
        .iter()
        .map(|path| read(path))
        .collect::<Result<Vec<_>>>()?;
    check(&list, args.other_device)?;
    let geometry = geometry(&list);
    list.iter_mut()
        .for_each(|of| of.estimate.geometry = geometry);
    let estimates: Vec<Estimate> = list.into_iter().map(|of| of.estimate).collect();
    let answer = answer(&estimates, &question);
    if let Some(path) = &args.report {
        let page = page::page(&answer, &geometry, &origin_of_files(&args.inputs)?);
        output::write(path, kinds::PAGE, page.as_bytes())?;
    }
    args.json
        .tell(ANSWER, &answer, || text::text(&answer, &geometry))?;
    Ok(ExitCode::SUCCESS)
}

fn read(path: &Path) -> Result<Compared> {
    let place = path.display().to_string();
    compared::read(path, &|recording: &Recording| {
        recording.warnings.iter().for_each(|warning| warn(warning));
        findings::check(recording, &place, SEGMENTS_AND_REFERENCE).map(|_| ())
    })
}

/// That of the first that states where its segments sit: a model does not.
fn geometry(list: &[Compared]) -> Geometry {
    let stated = list
        .iter()
        .find(|of| of.stated[0].is_some())
        .or(list.first());
    stated.map_or(Geometry::PAPER, |of| of.estimate.geometry)
}

impl Args {
    fn question(&self) -> Result<Question> {
        ensure!(
            self.budget || self.inputs.len() > 1,
            "{}: found it alone, wanted two or more to compare, or --budget",
            self.inputs[0].display()
        );
        let most = self.inputs.len();
        ensure!(
            self.repeats == 0 || (2..=most).contains(&self.repeats),
            "--repeats: found {}, wanted 2 to {most}, as many as there are",
            self.repeats
        );
        // Beyond three degrees the lateral phases are ambiguous (`signal/src/model/basis.rs`).
        let turn_rad = within("--turn-deg", self.turn_deg, 0.0, 2.8)?.to_radians();
        let teeth_m = match self.teeth_um {
            Some(teeth_um) => 1.0e-6 * within("--teeth-um", teeth_um, 0.0, 1.0e3)?,
            None => PAPER_TEETH_M,
        };
        let lateral_m = match self.lateral_um {
            Some(lateral_um) => Some(1.0e-6 * within("--lateral-um", lateral_um, 0.0, 1.0e3)?),
            None => None,
        };
        let at = self.at.map(|target| Pose {
            centre_m: [target.x_m, target.y_m].map(f64::from),
            theta_rad: f64::from(target.theta_rad),
        });
        let conditions = Conditions {
            teeth_m,
            lateral_m,
            within_k: within("--within-k", self.within_k.unwrap_or(0.0), 0.0, 200.0)?,
            distance_m: at.map_or([0.0; 2], |pose| pose.centre_m),
        };
        Ok(Question {
            turn_rad,
            budget: self.budget.then_some(conditions),
            at,
            repeats: self.repeats,
        })
    }
}

fn within(name: &str, value: f64, low: f64, high: f64) -> Result<f64> {
    ensure!(
        (low..=high).contains(&value),
        "{name}: found {value}, wanted {low} to {high}"
    );
    Ok(value)
}
