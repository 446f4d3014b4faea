//! `courier check MODEL RECORDING`.

use crate::findings::{self, ALL};
use crate::json::Json;
use crate::kinds;
use crate::output::Files;
use crate::recordings;
use crate::terminal::{begin, micrometres, stages, table, warn};
use anyhow::{Context, Result, bail};
use diagnosis::verdict::confirmation::{ConfirmedChannel, Confirmation};
use diagnosis::progress::Stage;
use diagnosis::{Check, Checked, Model, check_watched};
use recording::Recording;
use std::path::PathBuf;
use std::process::ExitCode;

/// Apply a diagnosed model to another recording of the same courier and see whether the gap shrinks as claimed.
///
/// Nothing is fitted but what is arbitrary from one recording to the next: the zeros of the tooth counts (offset of g_p,
/// o'_x, o'_y; the angle of a courier whose mounts drift with temperature), the phase of a vibration in each run, and beside hysteresis what each segment
/// brought along to a run from a way that is not recorded. A pair that wanders is followed by what its amplitude shows; without
/// counts its course is left out.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  courier diagnose first --model model.json && courier check model.json second"
)]
pub struct Args {
    /// Model that `courier diagnose --model` wrote.
    model: PathBuf,
    /// Folder of the other recording.
    recording: PathBuf,
    #[command(flatten)]
    json: Json,
}

impl Args {
    /// The files that it reads and writes.
    pub fn files(&self) -> Files {
        Files::default()
            .reads(&self.model)
            .reads_recording(&self.recording)
            .json(&self.json, kinds::CHECK)
    }
}

/// Reads, applies, prints.
///
/// # Errors
/// A bad model or recording, or one that gives no residuals.
pub fn run(args: &Args) -> Result<ExitCode> {
    let name = args.model.display().to_string();
    let text = std::fs::read_to_string(&args.model)
        .with_context(|| format!("{name}: a readable model was wanted"))?;
    let model = model(&name, &text)?;
    let recording = recordings::read(&args.recording)?;
    recording.warnings.iter().for_each(|warning| warn(warning));
    let path = args.recording.display().to_string();
    let bar = stages();
    let watch = |stage: Stage| begin(&bar, stage.what(), stage.begins_at());
    let answer = answer((&name, &model), (&path, &recording), &watch, &mut warn);
    bar.finish_and_clear();
    let answer = answer?;
    args.json.tell(kinds::CHECK, &answer.check, || answer.text)?;
    Ok(ExitCode::SUCCESS)
}

/// A model by its text; `name` is what errors name.
///
/// # Errors
/// It is none, or one of another schema.
pub fn model(name: &str, text: &str) -> Result<Model> {
    let model: Model = serde_json::from_str(text)
        .with_context(|| format!("{name}: a model by `courier diagnose --model` was wanted"))?;
    if model.schema != 1 {
        bail!("{name}: schema {}, 1 was wanted", model.schema);
    }
    Ok(model)
}

/// What a check tells.
#[derive(Clone, Debug)]
pub struct Answer {
    /// As JSON has it.
    pub check: Check,
    /// In words.
    pub text: String,
}

/// Applies a model to another recording, each with the name that it is told by. What is wrong in what is not used goes to `tell`.
///
/// # Errors
/// A recording that gives no residuals, or whose wires, units or geometry cannot be right.
pub fn answer(
    (name, model): (&str, &Model),
    (path, recording): (&str, &Recording),
    watch: &dyn Fn(Stage),
    tell: &mut dyn FnMut(&str),
) -> Result<Answer> {
    findings::check_telling(recording, path, ALL, tell)?;
    let checked = check_watched(model, recording, watch).with_context(|| path.to_owned())?;
    let held_out = checked.held_out.clone();
    let check = Check {
        schema: 1,
        recording: path.to_owned(),
        model: name.to_owned(),
        notes: checked.notes.clone(),
        confirmation: Confirmation::new(&model.claimed, &held_out),
        held_out,
    };
    let notes = check.notes.iter().map(|note| format!("  {note}"));
    let text = [
        [confirmed(&check.confirmation)].into_iter().chain(notes).collect::<Vec<_>>().join("\n"),
        told(model, &check) + &left_out(model, &checked),
    ];
    Ok(Answer { check, text: text.join("\n") })
}

/// Whether the claim is confirmed, and how sure that is.
fn confirmed(confirmation: &Confirmation) -> String {
    let lines = confirmation.channels.iter().map(confirmed_channel);
    let verdict = if confirmation.confirmed {
        "confirmed"
    } else {
        "not confirmed"
    };
    if confirmation.channels.is_empty() {
        return format!("{verdict}: the model claims nothing of these channels");
    }
    format!("{verdict}: {}", lines.collect::<Vec<_>>().join("\n    "))
}

fn confirmed_channel(channel: &ConfirmedChannel) -> String {
    let within = 100.0 * diagnosis::verdict::confirmation::WITHIN;
    let state = if channel.confirmed {
        ""
    } else if channel.probability_at_best < 0.5 {
        "; the recordings are too short to tell"
    } else {
        "; not as claimed"
    };
    format!(
        "{} {} µm claimed, {} came (probability {:.2} that they differ by less than {within:.0} %){state}",
        channel.channel,
        micrometres(channel.claimed_rms_m),
        micrometres(channel.came_rms_m),
        channel.probability,
    )
}

/// What the figures leave out, and what they are beyond.
fn left_out(model: &Model, checked: &Checked) -> String {
    let mut out = String::new();
    if let Some([here, there]) = checked.warmer_or_colder {
        let told = |range: [f64; 2]| format!("{:.1} to {:.1} °C", range[0], range[1]);
        let mut follow = effects::cards().filter(|card| card.follows_temperature());
        let effect = follow.next().map_or("", |card| card.name);
        let how = if model.inputs.bend_goes_on {
            "as it is bent there"
        } else {
            "by its linear part alone"
        };
        out += &format!(
            "\ntemperature: {} here, {} in the model's recording: {effect} is carried beyond what it was fitted on, {how}",
            told(here),
            told(there)
        );
    }
    if checked.unknown == 0 {
        return out;
    }
    out + &format!(
        "\nleft out: {} of {} samples, where the model's recording showed too little of what it speaks of (places, angles, speeds, gaps that it did not go through); {:.2} is left there",
        checked.unknown, checked.samples, checked.unknown_after
    )
}

fn told(model: &Model, check: &Check) -> String {
    let rows: Vec<Vec<String>> = check
        .held_out
        .channels
        .iter()
        .map(|c| {
            let claimed = model
                .claimed
                .channels
                .iter()
                .find(|m| m.channel == c.channel);
            vec![
                c.channel.clone(),
                micrometres(c.before_rms_m),
                micrometres(c.after_rms_m),
                format!(
                    "{} to {}",
                    micrometres(c.after_ci95_m[0]),
                    micrometres(c.after_ci95_m[1])
                ),
                claimed.map_or(String::new(), |m| micrometres(m.after_rms_m)),
                micrometres(c.floor_rms_m),
            ]
        })
        .collect();
    let names: Vec<&str> = model.effects.iter().map(|e| e.name.as_str()).collect();
    format!(
        "{} with {}\n{}\nover the simulator's own scatter: {:.2} before, {:.2} after, {:.2} claimed",
        check.recording,
        if names.is_empty() {
            "the baseline alone".into()
        } else {
            names.join(", ")
        },
        table(
            &["rms µm", "before", "after", "95 %", "claimed", "floor"],
            &rows
        ),
        check.held_out.whitened_before,
        check.held_out.whitened_after,
        model.claimed.whitened_after
    )
}
