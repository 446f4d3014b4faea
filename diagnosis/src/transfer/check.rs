//! A model checked on another recording of the same courier.

use crate::Insufficient;
use crate::algebra::statistics::rms;
use crate::data::channel_names::CHANNEL_NAMES;
use crate::data::observations::{MINIMUM_SAMPLES, Observations};
use crate::data::outliers::{among_bursts, astray, disturbed};
use crate::data::slips::repair_slips;
use crate::data::tooth_counts::align_pairs;
use crate::data::{adequacy, clip, commanded, faint, held_reference, late, restarts};
use crate::inference::residuals::Residuals;
use crate::linearization::calibrate::equation_columns;
use crate::linearization::recording::{LinearizedRecording, range};
use crate::noise::simulated::floor;
use crate::progress::{Stage, Watch, unwatched};
use crate::trace::{log, tracing};
use crate::transfer::applied::{apply, residuals};
use crate::transfer::aside;
use crate::transfer::model::Model;
use crate::verdict::answer::{HeldOut, HeldOutChannel};
use crate::verdict::confirmation::Confirmation;
use recording::Recording;
use serde::{Deserialize, Serialize};

/// What `check --json` prints.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Check {
    /// 1.
    pub schema: u32,
    /// Path of the recording.
    pub recording: String,
    /// Path of the model.
    pub model: String,
    /// What of the recording was mended or left aside, a line each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// As in the diagnosis.
    pub held_out: HeldOut,
    /// Whether that is what the model claims.
    #[serde(default)]
    pub confirmation: Confirmation,
}

/// The figures of `check`, and what they leave out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Checked {
    /// What of the recording was mended or left aside, a line each.
    pub notes: Vec<String>,
    /// As in the diagnosis.
    pub held_out: HeldOut,
    /// Samples that residuals could be formed of.
    pub samples: usize,
    /// Those of them of which the model's recording showed too little: over places that it did not visit, where there is a field, or
    /// where the uncertainty of the amounts counts (`PosteriorCovariance::extrapolates`), or beyond the amplitudes that a gap had (`AmplitudeSupport`). Left out
    /// of the figures.
    pub unknown: usize,
    /// What the model leaves at these, rms over the simulator's own scatter.
    pub unknown_after: f64,
    /// Temperatures here and in the model's recording, °C, where what follows temperature is carried beyond those that it was fitted
    /// on: its bend as well where [`effects::sensor::BasisInputs::bend_goes_on`], else its linear part alone.
    pub warmer_or_colder: Option<[[f64; 2]; 2]>,
}

/// Applies a model to another recording of the same courier. Fits nothing but the zeros that are arbitrary from one recording
/// to the next: of the tooth counts (offset of g_p, o'_x, o'_y; each segment's against a reference), and of time, which a
/// vibration's phase is counted from (in each stretch: what drives it keeps no time from run to run), what a segment brought along
/// to a stretch from a way that is not recorded, and the angle between the two sensors where mounts drift with temperature. Whole
/// teeth between the segments of a pair are told before ([`align_pairs`]). A wander is followed by what
/// the counts' amplitudes show of it ([`LinearizedRecording::amplitudes_explained`]); without counts it does not carry over and is left out,
/// so is what the model's recording showed too little of (`TrainingSupport`, `PosteriorCovariance`); how a vibration swells is not in the model.
///
/// # Errors
/// [`Insufficient`] where the recording gives no residuals, or nearly all of it lies where the model does not know what it speaks of.
pub fn check(model: &Model, recording: &Recording) -> Result<HeldOut, Insufficient> {
    check_fully(model, recording).map(|checked| checked.held_out)
}

/// The same with what was left out.
///
/// # Errors
/// As [`check`].
pub fn check_fully(model: &Model, recording: &Recording) -> Result<Checked, Insufficient> {
    check_watched(model, recording, &unwatched)
}

/// The same; `watch` is told each stage as it begins.
///
/// # Errors
/// As [`check`].
pub fn check_watched(
    model: &Model,
    recording: &Recording,
    watch: Watch,
) -> Result<Checked, Insufficient> {
    watch(Stage::Read);
    let mut observations = Observations::new(recording)?;
    let late = late::late(&observations);
    observations.align_in_time(&late, 1.0);
    let mut notes = commanded::repair(&mut observations);
    notes.extend(held_reference::leave_aside(&mut observations));
    notes.extend(restarts::join(&mut observations, recording));
    let slips = repair_slips(&mut observations);
    notes.extend(slips.iter().map(|slip| aside::slip(slip, &observations)));
    align_pairs(&mut observations);
    notes.extend(
        faint::leave_aside(&mut observations)
            .into_iter()
            .map(|(_, told)| told),
    );
    notes.extend(adequacy::remarks(&observations));
    observations.cut_figures = clip::cut_figures(&observations);
    let undisturbed = undisturbed(model, &observations, &mut notes);
    observations.late = late;
    late::realign(&mut observations, &model.baseline_with_effects);
    watch(Stage::Split);
    let (known, elsewhere) = split(model, &observations, undisturbed);
    let doubtful = doubtful(model, &observations, &known);
    let both = |i: usize| (known[i] && !doubtful[i], elsewhere[i] || doubtful[i]);
    let (known, unknown): (Vec<bool>, Vec<bool>) = (0..known.len()).map(both).unzip();
    watch(Stage::Apply);
    let (after, floor_scene) = residuals(model, &observations, known.clone(), true);
    let floor = floor(&floor_scene);
    let (before, _) = residuals(model, &observations, known, false);
    if after.sample.len() < MINIMUM_SAMPLES {
        let found = after.sample.len() as f64;
        let what = "residuals of what the model's recording showed";
        return Err(Insufficient::new(what, found, MINIMUM_SAMPLES as f64, ""));
    }
    let white = floor.white_square.sqrt();
    log_runs(&observations, &after);
    let channels = after
        .channels()
        .into_iter()
        .map(|c| HeldOutChannel {
            channel: CHANNEL_NAMES[c].into(),
            before_rms_m: before.channel_rms_m(c).0,
            after_rms_m: after.channel_rms_m(c).0,
            after_ci95_m: after.interval_m(c),
            floor_rms_m: floor.channel_rms_m[c],
        })
        .collect();
    let held_out = HeldOut {
        whitened_before: before.white_rms() / white,
        whitened_after: after.white_rms() / white,
        channels,
    };
    let beyond = unknown.iter().filter(|u| **u).count();
    let samples = beyond + floor_scene.mask.iter().filter(|k| **k).count();
    let unknown_after = if beyond > 0 {
        residuals(model, &observations, unknown, true).0.white_rms() / white
    } else {
        0.0
    };
    Ok(Checked {
        notes,
        held_out,
        samples,
        unknown: beyond,
        unknown_after,
        warmer_or_colder: warmer_or_colder(model, &observations),
    })
}

/// Share of the model's range of temperatures that another recording may lie beyond it before that is said.
const BEYOND: f64 = 0.1;

fn warmer_or_colder(model: &Model, observations: &Observations) -> Option<[[f64; 2]; 2]> {
    let there = model.normal.temperatures_c;
    let there = there.filter(|_| model.follows_temperature())?;
    let finite = observations.temperature_c.iter().copied();
    let here = range(&finite.filter(|t| t.is_finite()).collect::<Vec<f64>>())?;
    let margin = BEYOND * (there[1] - there[0]);
    (here[0] < there[0] - margin || here[1] > there[1] + margin).then_some([here, there])
}

/// Samples that tell a place and do not stand out. Disturbed ones are those that stand out of what the baseline alone leaves: a place where
/// the effects do not fit is a gap, and no disturbance. Where bursts were named there are others here, which a great gap may hide: then it is
/// what the model leaves that they stand out of, as they did in the diagnosis. What is left out goes to `notes`.
fn undisturbed(model: &Model, observations: &Observations, notes: &mut Vec<String>) -> Vec<bool> {
    let resting = crate::data::prepare::resting(observations);
    let stuck = clip::stuck(observations, &model.inputs.clip);
    notes.extend(aside::stuck(&stuck));
    let all: Vec<bool> = resting.iter().zip(&stuck).map(|(r, s)| !r && !s).collect();
    let (first, first_scene) = residuals(model, observations, all.clone(), model.bursts);
    let mut rows = first.white_rows();
    rows.extend(first_scene.amplitude_rows());
    let marked = if model.bursts {
        among_bursts(&rows, &observations.stretch, &observations.run)
    } else {
        disturbed(&rows, observations.len(), &observations.stretch)
    };
    let astray = astray(&rows, observations);
    let far: Vec<bool> = (0..all.len())
        .map(|i| all[i] && (marked[i] || astray[i]))
        .collect();
    notes.extend(aside::far(&far));
    (0..all.len()).map(|i| all[i] && !far[i]).collect()
}

/// Samples over places where the model knows all that it speaks of, and the others.
fn split(model: &Model, observations: &Observations, usable: Vec<bool>) -> (Vec<bool>, Vec<bool>) {
    let Some(visited) = &model.visited else {
        let none = vec![false; usable.len()];
        return (usable, none);
    };
    let baseline = model.baseline_with_effects.clone();
    let mut linearized =
        LinearizedRecording::relative_to(observations, baseline, usable, Some(&model.normal));
    linearized.inputs.field_by_segment = model.inputs.field_by_segment;
    linearized.inputs.forms = model.inputs.forms;
    let there = |i: usize| {
        linearized.mask[i] && linearized.channels(i).contains(&true) | linearized.scope.reference
    };
    (0..linearized.len())
        .map(|i| {
            let knows = visited.knows(&linearized, i);
            (there(i) && knows, there(i) && !knows)
        })
        .unzip()
}

/// Samples of those in use at which the model's own uncertainty counts, or the gap lies beyond all that it was fitted on.
fn doubtful(model: &Model, observations: &Observations, usable: &[bool]) -> Vec<bool> {
    let (certainty, reached) = (&model.certainty, &model.reached);
    if certainty.is_none() && reached.is_none() {
        return vec![false; usable.len()];
    }
    let (mut linearized, effects, _) = apply(model, observations, usable.to_vec(), true);
    let beyond = |i: usize| {
        let reached = reached.as_ref().filter(|_| usable[i]);
        reached.is_some_and(|r| r.is_beyond(linearized.covariates(i).ln_amplitude))
    };
    let beyond: Vec<bool> = (0..linearized.len()).map(beyond).collect();
    let Some(certainty) = certainty else {
        return beyond;
    };
    linearized.noise = certainty.noise;
    let mut columns = equation_columns(&linearized);
    columns.append(effects);
    let extrapolates = certainty.extrapolates(&linearized, &columns);
    extrapolates
        .iter()
        .zip(&beyond)
        .map(|(d, b)| *d || *b)
        .collect()
}

/// What is left of each run in each channel, over its noise, where that was asked for.
fn log_runs(observations: &Observations, left: &Residuals) {
    if !tracing() {
        return;
    }
    for (run, name) in observations.run_names.iter().enumerate() {
        for (channel, channel_name) in CHANNEL_NAMES.iter().enumerate() {
            let of_it = (0..left.sample.len())
                .filter(|&k| left.channel[k] == channel && observations.run[left.sample[k]] == run)
                .map(|k| left.value_m[k] / left.noise_m[k].max(1e-12));
            let list: Vec<f64> = of_it.collect();
            if !list.is_empty() {
                log(&format!(
                    "{name}, {channel_name}: {:.2}",
                    rms(list.iter().copied())
                ));
            }
        }
    }
}
