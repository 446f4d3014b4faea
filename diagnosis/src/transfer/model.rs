//! The diagnosed model on disk, and its check on another recording.

use crate::Insufficient;
use crate::algebra::statistics::rms;
use crate::data::channel_names::CHANNEL_NAMES;
use crate::data::folds::folds;
use crate::data::observations::{MINIMUM_SAMPLES, Observations};
use crate::data::outliers::{among_bursts, astray, disturbed};
use crate::data::slips::repair_slips;
use crate::data::tooth_counts::align_pairs;
use crate::data::{adequacy, commanded, faint, restarts};
use crate::design::gram::{Columns, Gram, coefficients};
use crate::inference::covariance::PosteriorCovariance;
use crate::inference::residuals::Residuals;
use crate::linearization::baseline::Baseline;
use crate::linearization::calibrate::baseline_columns;
use crate::linearization::paths::likeliest;
use crate::linearization::recording::{LinearizedRecording, ReferenceValues, range};
use crate::linearization::relinearized::remembers;
use crate::noise::simulated::floor;
use crate::progress::{Stage, Watch, unwatched};
use crate::spectra::phase::{Line, align, waves};
use crate::trace::{log, tracing};
use crate::transfer::amplitude_support::AmplitudeSupport;
use crate::transfer::aside;
use crate::transfer::support::TrainingSupport;
use crate::verdict::answer::{HeldOut, HeldOutChannel, Magnitude};
use crate::verdict::confirmation::Confirmation;
use courier_signal::equations::ANGLE_SIGN;
use effects::identity::Identity;
use effects::sensor::{BasisInputs, Regressor};
use effects::{Card, Detection};
use recording::Recording;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// What `diagnose --model` writes: everything that `check` needs, in SI.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Model {
    /// 1.
    pub schema: u32,
    /// The recording that it is of.
    pub recording: String,
    /// Baseline calibrated alone.
    pub baseline: Baseline,
    /// Baseline fitted together with the effects.
    pub baseline_with_effects: Baseline,
    /// Amounts of each effect: what is added to the readings, in the convention of equation (3).
    pub effects: Vec<EffectAmounts>,
    /// Values that amounts are relative to.
    pub normal: ReferenceValues,
    /// What was surveyed: frequencies, clip levels, speeds.
    #[serde(rename = "survey")]
    pub inputs: BasisInputs,
    /// Held-out figures that `check` should confirm.
    pub claimed: HeldOut,
    /// True where bursts were named: another recording has others, and `check` sets them aside.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub bursts: bool,
    /// Where it knows the field over the platen, if it has one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub visited: Option<TrainingSupport>,
    /// How well the other amounts are known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub certainty: Option<PosteriorCovariance>,
    /// How far the amplitudes went, where it speaks of the gap.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reached: Option<AmplitudeSupport>,
}

/// Amounts of one effect.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EffectAmounts {
    /// Name in diagnosis.md.
    pub name: String,
    /// False where the amounts belong to that recording's own time (a drift's course): `check` leaves them out.
    pub carries_over: bool,
    /// All amounts but those that stand for how a vibration swells and strays, which is another on the next recording.
    pub amounts: Vec<Magnitude>,
}

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
    /// where the uncertainty of the amounts counts ([`PosteriorCovariance::extrapolates`]), or beyond the amplitudes that a gap had ([`AmplitudeSupport`]). Left out
    /// of the figures.
    pub unknown: usize,
    /// What the model leaves at these, rms over the simulator's own scatter.
    pub unknown_after: f64,
    /// Temperatures here and in the model's recording, °C, where what follows temperature is carried beyond those that it was fitted
    /// on: its bend as well where [`effects::sensor::BasisInputs::bend_goes_on`], else its linear part alone.
    pub warmer_or_colder: Option<[[f64; 2]; 2]>,
}

/// True if the amounts of an effect are tied to a recording's own time. A pair's counts show its course in any recording.
pub(crate) fn is_time_bound(effect: &str, inputs: &BasisInputs) -> bool {
    effects::has(effect, Card::keeps_its_own_time) && !inputs.counts
}

/// Applies a model to another recording of the same courier. Fits nothing but the zeros that are arbitrary from one recording
/// to the next: of the tooth counts (offset of g_p, o'_x, o'_y; each segment's against a reference), and of time, which a
/// vibration's phase is counted from (in each stretch: what drives it keeps no time from run to run), what a segment brought along
/// to a stretch from a way that is not recorded, and the angle between the two sensors where mounts drift with temperature. Whole
/// teeth between the segments of a pair are told before ([`align_pairs`]). A wander is followed by what
/// the counts' amplitudes show of it ([`LinearizedRecording::amplitudes_explained`]); without counts it does not carry over and is left out,
/// so is what the model's recording showed too little of ([`TrainingSupport`], [`PosteriorCovariance`]); how a vibration swells is not in the model.
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
    let mut notes = commanded::repair(&mut observations);
    notes.extend(restarts::join(&mut observations, recording));
    let slips = repair_slips(&mut observations);
    notes.extend(slips.iter().map(|slip| aside::slip(slip, &observations)));
    align_pairs(&mut observations);
    notes.extend(faint::leave_aside(&mut observations));
    notes.extend(adequacy::remarks(&observations));
    let undisturbed = undisturbed(model, &observations, &mut notes);
    watch(Stage::Split);
    let (known, elsewhere) = split(model, &observations, undisturbed);
    let doubtful = doubtful(model, &observations, &known);
    let both = |i: usize| (known[i] && !doubtful[i], elsewhere[i] || doubtful[i]);
    let (known, unknown): (Vec<bool>, Vec<bool>) = (0..known.len()).map(both).unzip();
    watch(Stage::Apply);
    let (after, floor_scene) = residuals(model, &observations, known.clone(), true);
    let floor = floor(&floor_scene, 4);
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

/// Samples that what was brought along is kept for: of fewer, it would be most of what they tell.
const LONG: f64 = 10.0;
/// Share of the model's range of temperatures that another recording may lie beyond it before that is said.
const BEYOND: f64 = 0.1;

fn follows_temperature(model: &Model) -> bool {
    let mut effects = model.effects.iter();
    effects.any(|e| effects::has(&e.name, Card::follows_temperature))
}

fn warmer_or_colder(model: &Model, observations: &Observations) -> Option<[[f64; 2]; 2]> {
    let there = model.normal.temperatures_c;
    let there = there.filter(|_| follows_temperature(model))?;
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
    let stuck = crate::data::clip::stuck(observations, &model.inputs.clip);
    notes.extend(aside::stuck(&stuck));
    let all: Vec<bool> = resting.iter().zip(&stuck).map(|(r, s)| !r && !s).collect();
    let (first, _) = residuals(model, observations, all.clone(), model.bursts);
    let rows = first.white_rows();
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
    let mut columns = baseline_columns(&linearized);
    columns.append(effects);
    let extrapolates = certainty.extrapolates(&linearized, &columns);
    extrapolates
        .iter()
        .zip(&beyond)
        .map(|(d, b)| *d || *b)
        .collect()
}

/// What the model, or its baseline alone, leaves at some samples; and the linearized recording under it.
fn residuals<'a>(
    model: &Model,
    observations: &'a Observations,
    mask: Vec<bool>,
    with: bool,
) -> (Residuals, LinearizedRecording<'a>) {
    let (linearized, columns, list) = apply(model, observations, mask, with);
    (evaluate(&linearized, &columns, &list), linearized)
}

/// The linearized recording under the model: known amounts are put into the residual by columns with a prior that does not move.
fn apply<'a>(
    model: &Model,
    observations: &'a Observations,
    mask: Vec<bool>,
    with: bool,
) -> (LinearizedRecording<'a>, Columns, Vec<usize>) {
    let baseline = if with {
        &model.baseline_with_effects
    } else {
        &model.baseline
    };
    let mut linearized =
        LinearizedRecording::relative_to(observations, baseline.clone(), mask, Some(&model.normal));
    linearized.take_amplitudes(Arc::new(linearized.amplitudes_explained()));
    let own = linearized.inputs.clone();
    linearized.inputs = BasisInputs {
        segments: own.segments,
        reference: own.reference,
        beacon: own.beacon,
        temperature: own.temperature,
        counts: own.counts,
        beacon_stretches: own.beacon_stretches.clone(),
        middle_m: middle_m(&model.inputs, &own),
        ..model.inputs.clone()
    };
    let mut columns = Columns::default();
    let mut zeros = zeros(&linearized);
    if with && linearized.scope.beacon && follows_temperature(model) {
        zeros.push(zero_of_the_angle());
    }
    columns.push("zeros", zeros);
    let mut lines = Vec::new();
    if with {
        for effect in model.effects.iter().filter(|e| e.carries_over) {
            if effects::is(&effect.name, Detection::ByLines) {
                if linearized.scope.beacon {
                    lines = Line::all(&effect.amounts, &model.inputs.beacon_lines_hz);
                }
                columns.push(effects::name_of(Detection::ByLines), waves(&lines));
                continue;
            }
            let Some(side) = effects::sensor_sides()
                .into_iter()
                .find(|e| e.name() == effect.name)
            else {
                continue;
            };
            let regressors: Vec<Regressor> = side.regressors(&linearized.inputs);
            let start = columns.regressors.len();
            columns.push(effect.name.clone(), regressors);
            for c in start..columns.regressors.len() {
                let name = &columns.regressors[c].name;
                if is_brought_along(&columns.regressors[c]) {
                    continue;
                }
                columns.centre[c] = effect
                    .amounts
                    .iter()
                    .find(|a| a.name == *name)
                    .map_or(0.0, |a| a.value);
                columns.held[c] = true;
            }
        }
    }
    if with && remembers(&columns) {
        columns.push("ways between stretches", between_stretches(&linearized));
    }
    if with {
        align(&linearized, &mut columns, &lines);
    }
    let list: Vec<usize> = (0..columns.regressors.len()).collect();
    if with {
        linearized = if remembers(&columns) && !linearized.scope.reference {
            let estimate = |columns: &Columns| {
                let left = |linearized: &LinearizedRecording| evaluate(linearized, columns, &list);
                likeliest(
                    &linearized,
                    |linearized| at_fixed_point(linearized, columns),
                    left,
                )
            };
            let first = estimate(&columns);
            take_along(&first, &mut columns);
            estimate(&columns)
        } else {
            at_fixed_point(linearized, &columns)
        };
    }
    (linearized, columns, list)
}

/// The place that places are told from: the model's, or this recording's own where that lies outside all that the model's went over.
/// Then its tooth counts have another zero.
fn middle_m(model: &BasisInputs, own: &BasisInputs) -> [f64; 2] {
    let within = |axis: usize| {
        let half = 0.5 * model.travel_m[axis].max(model.travel_m[axis + 2]);
        (own.middle_m[axis] - model.middle_m[axis]).abs() <= half
    };
    if within(0) && within(1) {
        model.middle_m
    } else {
        own.middle_m
    }
}

/// What the segments brought along to each stretch but the first, which the effect has itself, where they keep it for long.
fn between_stretches(linearized: &LinearizedRecording) -> Vec<Regressor> {
    let stretch = &linearized.observations.stretch;
    let mut kept = vec![[0.0; 4]; stretch.last().map_or(0, |last| last + 1)];
    for (s, before) in linearized.motion.before.iter().enumerate() {
        let samples = before
            .iter()
            .enumerate()
            .filter(|(i, _)| linearized.mask[*i]);
        samples.for_each(|(i, before)| kept[stretch[i]][s] += before);
    }
    let kept = kept.iter().enumerate().skip(1);
    let long = kept.flat_map(|(k, kept)| {
        let segments = (0..4).filter(|s| kept[*s] > LONG);
        segments.map(move |s| (s, k))
    });
    let mut remembering = effects::EFFECTS.iter().filter(|e| e.card().remembers);
    let effect = remembering.next();
    long.filter_map(|(s, k)| effect?.brought_along(s, k))
        .collect()
}

/// True for what a segment brought along to a stretch from a way that is not recorded: another recording has another.
fn is_brought_along(regressor: &Regressor) -> bool {
    regressor.identity == Some(Identity::BroughtAlong)
}

/// What the segments brought along, as a first look at their ways tells it: it moves them as what is known does.
fn take_along(linearized: &LinearizedRecording, columns: &mut Columns) {
    let gram = Gram::new(
        linearized,
        columns,
        &folds(&linearized.observations.stretch),
    );
    let amounts = coefficients(&gram, columns);
    for (c, regressor) in columns.regressors.iter().enumerate() {
        if is_brought_along(regressor) {
            columns.centre[c] = amounts[c] * gram.scale[c];
        }
    }
}

/// The linearized recording about where the known amounts say that the segments are.
fn at_fixed_point<'a>(
    linearized: LinearizedRecording<'a>,
    columns: &Columns,
) -> LinearizedRecording<'a> {
    let known: Vec<usize> = (0..columns.regressors.len())
        .filter(|c| columns.held[*c] || is_brought_along(&columns.regressors[*c]))
        .collect();
    let amounts: Vec<f64> = known.iter().map(|c| columns.centre[*c]).collect();
    crate::linearization::relinearized::at_fixed_point(linearized, columns, &known, &amounts)
}

/// Prior size of what is arbitrary, m.
const FREE_M: f64 = 0.3;

/// Mounts that have drifted by some micrometres have turned the sensor: against the coordination sensor by as much as that over the
/// span, and at another temperature by what nothing told.
fn zero_of_the_angle() -> Regressor {
    Regressor::readings("zero of the angle", "m", FREE_M, |_, out| {
        for (out, sign) in out.iter_mut().zip(ANGLE_SIGN.map(f64::from)) {
            *out += sign;
        }
    })
}

/// What is arbitrary from recording to recording.
fn zeros(linearized: &LinearizedRecording) -> Vec<Regressor> {
    let mut list = Vec::new();
    if linearized.scope.reference {
        for s in (0..4).filter(|s| linearized.scope.segments[*s]) {
            list.push(Regressor::reading(
                format!("zero of segment {}", s + 1),
                "m",
                FREE_M,
                s,
                |_| 1.0,
            ));
        }
        return list;
    }
    for channel in 0..if linearized.scope.beacon { 3 } else { 1 } {
        list.push(Regressor::channel(
            format!("zero of {}", CHANNEL_NAMES[channel]),
            "m",
            FREE_M,
            channel,
            |_| 1.0,
        ));
    }
    list
}

/// What is left where the few amounts that are arbitrary here are fitted to all samples: what a segment brought along shows in the first few
/// alone, and nothing else foretells it.
fn evaluate(linearized: &LinearizedRecording, columns: &Columns, list: &[usize]) -> Residuals {
    let gram = Gram::new(
        linearized,
        columns,
        &folds(&linearized.observations.stretch),
    );
    let amounts = coefficients(&gram, columns);
    Residuals::predicted(linearized, columns, &gram, list, |_| &amounts, false)
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
