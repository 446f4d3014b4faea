//! `courier diagnose RECORDING`.

use super::{diagnose_explained, diagnose_many};
use crate::json::Json;
use crate::kinds;
use crate::many::Order;
use crate::output::{self, Files};
use crate::provenance::origin_of;
use crate::recordings;
use crate::terminal::{begin, micrometres, one_line, stages, table, warn};
use anyhow::{Result, bail, ensure};
use report::headline::{RESOLUTION_M, headline};
use diagnosis::progress::Stage;
use diagnosis::verdict::answer::{Magnitude, Named};
use diagnosis::{Answer, Diagnosis, Model, Options, Verdict, diagnose_watched};
use report::html::Origin;
use report::remainder::remainder;
use report::{html, units};
use recording::Recording;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Say where simulation and sensor part, which effect does it, and how far adding it closes the gap.
///
/// The baseline (equations 3, 5 and 11) is calibrated on part of the recording; the simulator repeats its motion with that
/// baseline and the stated noise; both are compared on parts that were not used to fit. Verdicts: no_gap, named, alias,
/// unknown, insufficient_data. Wires, units and stated lengths that the readings contradict are named first, and nothing is diagnosed then.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  courier diagnose examples/survey-lateral --json=answer.json --report gap.html\n  courier diagnose recordings/* --out answers"
)]
pub struct Args {
    /// The recording: a folder with recording.toml and samples.csv, or a .parquet or .mcap file.
    recording: PathBuf,
    /// More of them, with --out.
    #[arg(requires = "out")]
    more: Vec<PathBuf>,
    #[command(flatten)]
    json: Json,
    /// Diagnose many recordings into a table in this folder: a row each, as Parquet in a build with that, as lines of JSON
    /// else. What has a row already is not done again, so that it goes on where it was ended; several programs may fill one table.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Recordings that are diagnosed at once [default: as many as there are processors].
    #[arg(long, value_name = "N", requires = "out", value_parser = clap::value_parser!(u16).range(1..))]
    jobs: Option<u16>,
    /// Write the diagnosed model to this file, for `courier check` and `courier load`.
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// Write a report with plots to this file: one HTML file that needs no network.
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Resolution that the gap is held against in the headline, µm rms.
    #[arg(long, value_name = "UM", default_value_t = 1.0e6 * RESOLUTION_M)]
    resolution_um: f64,
    /// Take an effect out of the catalogue; may be given several times.
    #[arg(long, value_name = "EFFECT")]
    without: Vec<String>,
    /// Add the twenty likeliest sets of effects with their evidence, and why each is not the first, below the steps of the decision. Takes twenty further fits.
    #[arg(long, conflicts_with = "to")]
    explain: bool,
}

impl Args {
    /// All recordings, in order.
    fn all(&self) -> impl Iterator<Item = &PathBuf> {
        std::iter::once(&self.recording).chain(&self.more)
    }

    /// The files that it reads and writes.
    pub fn files(&self) -> Files {
        let read = |files: Files, path: &PathBuf| files.reads_recording(path);
        let files = self.all().fold(Files::default(), read);
        let (files, kind) = match &self.out {
            Some(table) => (files.fills(table), diagnose_many::ANSWER),
            None => (files, kinds::DIAGNOSIS),
        };
        files
            .json(&self.json, kind)
            .writes(self.model.as_ref(), kinds::MODEL)
            .writes(self.report.as_ref(), kinds::PAGE)
    }
}

/// Reads, diagnoses, writes what was asked for.
///
/// # Errors
/// A bad recording, an unknown effect, or a file that cannot be written.
pub fn run(args: &Args) -> Result<ExitCode> {
    args.check()?;
    if let Some(table) = &args.out {
        // Not told to clap, which then would not miss `--out` beside one of these.
        ensure!(
            args.model.is_none() && args.report.is_none() && !args.explain,
            "--out: found --model, --report or --explain beside it, which are of one recording"
        );
        return diagnose_many::run(&args.order(table), &args.json);
    }
    let path = &args.recording;
    let recording = recordings::read(path)?;
    recording.warnings.iter().for_each(|warning| warn(warning));
    let bar = stages();
    let answer = answer(args, &recording, &|stage: Stage| {
        begin(&bar, stage.what(), stage.begins_at())
    });
    let explained = explained(args, &answer);
    bar.finish_and_clear();
    match (&args.model, &answer.model) {
        (Some(path), Some(model)) => output::write(path, kinds::MODEL, model_text(model)?.as_bytes())?,
        (Some(path), None) => warn(&format!(
            "{}: not written, the data give no model",
            path.display()
        )),
        _ => {}
    }
    if let Some(page) = &args.report {
        let model = args.model.as_deref().filter(|_| answer.model.is_some());
        let origin = origin_of(path, &recording, model)?;
        let text = args.page(&answer, &origin);
        output::write(page, kinds::PAGE, text.as_bytes())?;
    }
    args.json
        .tell(kinds::DIAGNOSIS, &answer.diagnosis, || told(args, &answer, explained.as_deref()))?;
    Ok(ExitCode::SUCCESS)
}

/// Diagnoses a recording, which is told by the path that the options name.
pub fn answer(args: &Args, recording: &Recording, watch: &dyn Fn(Stage)) -> Answer {
    let name = args.recording.display().to_string();
    diagnose_watched(recording, &name, &args.options(), watch)
}

/// A model, as its file has it.
///
/// # Errors
/// It has a number that JSON has not.
pub fn model_text(model: &Model) -> Result<String> {
    Ok(serde_json::to_string_pretty(model)?)
}

impl Args {
    /// Refuses options that no recording can be diagnosed with.
    ///
    /// # Errors
    /// An unknown effect; a resolution that is none.
    pub fn check(&self) -> Result<()> {
        let known: Vec<&str> = effects::CATALOGUE.iter().map(|entry| entry.name).collect();
        let mut without = self.without.iter();
        if let Some(name) = without.find(|name| !known.contains(&name.as_str())) {
            bail!(
                "--without {}: not in the catalogue; one of {} was wanted",
                one_line(name),
                known.join(", ")
            );
        }
        ensure!(
            self.resolution_um > 0.0 && self.resolution_um.is_finite(),
            "--resolution-um: found {}, wanted above 0",
            self.resolution_um
        );
        Ok(())
    }

    /// What the gap is held against in the headline, m rms.
    #[must_use]
    pub fn resolution_m(&self) -> f64 {
        1.0e-6 * self.resolution_um
    }

    fn options(&self) -> Options {
        Options {
            without: self.without.clone(),
            explain: self.explain,
        }
    }

    /// What becomes of many recordings in a table.
    #[must_use]
    pub fn order(&self, table: &Path) -> Order {
        Order {
            recordings: self.all().cloned().collect(),
            table: table.to_owned(),
            without: self.without.clone(),
            resolution_m: self.resolution_m(),
            jobs: self.jobs.map_or_else(processors, usize::from),
        }
    }

    /// The report's page; `origin` says where it comes from.
    #[must_use]
    pub fn page(&self, answer: &Answer, origin: &Origin) -> String {
        let headline = headline(&answer.diagnosis, self.resolution_m());
        html::page(&answer.diagnosis, &answer.evidence, &headline, origin)
    }
}

/// Processors of this machine.
fn processors() -> usize {
    std::thread::available_parallelism().map_or(1, std::num::NonZero::get)
}

/// The likeliest sets of effects as text, where they were asked for. What cannot be answered has none, and its verdict says why.
pub fn explained(args: &Args, answer: &Answer) -> Option<String> {
    let decision = answer.decision.as_ref().filter(|_| args.explain);
    decision
        .filter(|_| answer.diagnosis.verdict != Verdict::InsufficientData)
        .map(diagnose_explained::text)
}

/// The whole text of an answer.
pub fn told(args: &Args, answer: &Answer, explained: Option<&str>) -> String {
    let text = text(&answer.diagnosis, args.resolution_m());
    explained.map_or(text.clone(), |explained| format!("{text}\n\n{explained}"))
}

/// No length is said to be known better than this, m: it is a first look.
const FINEST_M: f64 = 10.0e-6;

/// What was stated of the geometry beside what the data say.
fn geometry(d: &Diagnosis) -> String {
    if d.geometry.is_empty() {
        return String::new();
    }
    let value = |f: &plausibility::Fitted| {
        let [found, stated, error] = [f.found_m, f.stated_m, f.error_m.max(FINEST_M)].map(|m| 1.0e3 * m);
        format!("{} {found:.4} mm (stated {stated:.4}, known to {error:.2})", f.name)
    };
    let list: Vec<String> = d.geometry.iter().map(value).collect();
    format!("geometry by the data: {}\n", list.join(", "))
}

/// The four answers in under a screen, beside a resolution, m.
pub fn text(d: &Diagnosis, resolution_m: f64) -> String {
    let headline = headline(d, resolution_m).text;
    let mut out = format!("{}: {}. {headline}\n", d.recording, verdict(d));
    // Where the data are insufficient, the headline is the first note.
    let told = usize::from(d.verdict == Verdict::InsufficientData);
    for note in d.notes.iter().skip(told) {
        out += &format!("  {note}\n");
    }
    if d.gap.is_empty() {
        out += &geometry(d);
        return out.trim_end().into();
    }
    let rows: Vec<Vec<String>> = d
        .gap
        .iter()
        .zip(&d.held_out.channels)
        .map(|(gap, held)| {
            vec![
                gap.channel.clone(),
                gap.samples.to_string(),
                micrometres(gap.real_rms_m),
                micrometres(gap.simulated_rms_m),
                format!(
                    "{} ({} to {})",
                    micrometres(gap.excess_rms_m),
                    micrometres(gap.excess_ci95_m[0]),
                    micrometres(gap.excess_ci95_m[1])
                ),
                format!(
                    "{} ({} to {})",
                    micrometres(held.after_rms_m),
                    micrometres(held.after_ci95_m[0]),
                    micrometres(held.after_ci95_m[1])
                ),
            ]
        })
        .collect();
    out += &table(
        &[
            "held out, rms µm",
            "samples",
            "recording",
            "simulation",
            "excess (95 %)",
            "after (95 %)",
        ],
        &rows,
    );
    out += &format!(
        "\nover the simulator's own scatter: {:.2} before, {:.2} after (1.00 is the floor)\n",
        d.held_out.whitened_before, d.held_out.whitened_after
    );
    let place = if d.verdict == Verdict::Unknown {
        &d.unexplained.place
    } else {
        &d.place
    };
    if !place.is_empty() {
        let told = &place[..place.len().min(4)];
        let one = told.iter().all(|w| w.channel == told[0].channel);
        let list: Vec<String> = told
            .iter()
            .map(|w| {
                let channel = if one {
                    String::new()
                } else {
                    format!(" in {}", w.channel)
                };
                format!("{}{channel} {:.0} %", w.coordinate, 100.0 * w.share)
            })
            .collect();
        let all = if one {
            format!(" ({})", told[0].channel)
        } else {
            String::new()
        };
        out += &format!("where{all}: {}\n", list.join("; "));
    }
    out += &effects(d);
    if matches!(d.verdict, Verdict::Named | Verdict::Alias) {
        out += &format!(
            "unexplained: {:.1} % of the squared excess\n",
            100.0 * d.unexplained.share
        );
    }
    for sentence in remainder(d) {
        out += &format!("{sentence}\n");
    }
    out += &geometry(d);
    out.trim_end().into()
}

/// Its effects: their names, how sure, how large.
fn effects(d: &Diagnosis) -> String {
    let mut out = String::new();
    for effect in &d.effects {
        out += &format!(
            "{}{}: {}; probability {:.2}, {:.0} % of the gap{}\n",
            effect.name,
            units::total(effect).map_or(String::new(), |total| format!(": {total}")),
            effects::entry(&effect.name).map_or("", |entry| entry.summary),
            effect.probability,
            100.0 * effect.share,
            alone(effect),
        );
        for amount in effect.magnitude.iter().take(2) {
            out += &amount_line(amount);
        }
        if !effect.aliases.is_empty() {
            out += &format!(
                "    or {}; to tell: {}\n",
                effect.aliases.join(", "),
                effect.break_alias.as_deref().unwrap_or("another motion")
            );
        }
    }
    out
}

/// What an effect leaves by itself. Of what is no shape, nothing is told.
fn alone(effect: &Named) -> String {
    if effect.gap_after_alone_m > 0.0 {
        let left = micrometres(effect.gap_after_alone_m);
        format!(", alone down to {left} µm")
    } else {
        String::new()
    }
}

fn amount_line(amount: &Magnitude) -> String {
    format!("    {}: {}\n", units::name(amount), units::amount(amount))
}

fn verdict(d: &Diagnosis) -> &'static str {
    match d.verdict {
        Verdict::NoGap => "no gap",
        Verdict::Named => "named",
        Verdict::Alias => "alias",
        Verdict::Unknown => "unknown",
        Verdict::InsufficientData => "insufficient data",
    }
}
