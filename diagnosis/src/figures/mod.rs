//! The figures of what was decided: shares and amounts of what is named, where the rest lies, and what another recording will show.

mod answered;
mod attribution;
mod bursts;
pub(crate) mod far_forms;
mod filled;
mod final_fit;
mod fitted_effects;
mod follows;
mod gap;
pub(crate) mod intermodulation;
pub mod limits;
mod location;
mod lost_signals;
pub(crate) mod measured;
mod measurements;
mod missing_codes;
mod named;
mod nameless_correction;
mod noise;
mod noise_level;
mod prediction;
mod reference;
mod stated_noise;
mod teeth;
mod temperature_extrapolation;
mod variance_components;
mod wander_elsewhere;
mod whiteness;

use crate::data::prepare::{Prepared, prepare};
use crate::design::assembly::Options;
use crate::posterior::diagnosed::{Decided, decided};
use crate::progress::{Stage, Watch, unwatched};
use crate::verdict::answer::{Diagnosis, Verdict};
use answered::answered;
pub use answered::{Answer, Decision};
use plausibility::{Finding, Fitted, Plausibility};
use recording::Recording;

/// Diagnoses a recording; `name` is what the answer calls it.
pub fn diagnose(recording: &Recording, name: &str, options: &Options) -> Diagnosis {
    diagnose_fully(recording, name, options).diagnosis
}

/// The same with the model and the residuals.
pub fn diagnose_fully(recording: &Recording, name: &str, options: &Options) -> Answer {
    diagnose_watched(recording, name, options, &unwatched)
}

/// The same; `watch` is told each stage as it begins.
pub fn diagnose_watched(
    recording: &Recording,
    name: &str,
    options: &Options,
    watch: Watch,
) -> Answer {
    watch(Stage::Prepare);
    match prepared_or_told(recording, name) {
        Ok((prepared, geometry)) => {
            let told = |prepared: &Prepared, decided: Decided| {
                answered(prepared, name, options, decided, watch)
            };
            let mut answer = decided(prepared, options, watch, told);
            answer.diagnosis.geometry = geometry;
            answer
        }
        Err(answer) => *answer,
    }
}

/// A recording made ready, with the geometry that its readings show; or the answer to one that cannot be diagnosed.
fn prepared_or_told(
    recording: &Recording,
    name: &str,
) -> Result<(Prepared, Vec<Fitted>), Box<Answer>> {
    let Plausibility { findings, geometry } = plausibility::look(recording);
    if !findings.is_empty() {
        let notes = findings.iter().map(Finding::to_string).collect();
        return Err(Box::new(unanswered(name, notes, findings, geometry)));
    }
    match prepare(recording) {
        Ok(prepared) => Ok((prepared, geometry)),
        Err(limit) => {
            let notes = vec![limit.to_string()];
            Err(Box::new(unanswered(name, notes, findings, geometry)))
        }
    }
}

/// The answer of a recording that cannot be diagnosed.
fn unanswered(
    name: &str,
    notes: Vec<String>,
    findings: Vec<Finding>,
    geometry: Vec<Fitted>,
) -> Answer {
    Answer {
        diagnosis: Diagnosis {
            schema: 1,
            recording: name.into(),
            verdict: Verdict::InsufficientData,
            notes,
            findings,
            geometry,
            ..Diagnosis::default()
        },
        ..Answer::default()
    }
}
