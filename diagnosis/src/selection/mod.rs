//! From scores to a verdict.

mod attribution;
mod bursts;
pub mod by_posterior;
mod common_field;
mod completing_terms;
pub mod core_terms;
mod elimination;
pub(crate) mod far_forms;
mod field;
mod figures;
mod final_fit;
mod follows;
pub(crate) mod intermodulation;
pub mod limits;
mod location;
mod lost_signals;
pub(crate) mod measured;
mod missing_codes;
mod named;
mod nameless_correction;
mod nested_forms;
mod noise;
mod noise_level;
mod phase;
mod prediction;
mod reference;
mod rivals;
pub mod search;
mod second_effect;
mod selected;
mod stated_noise;
mod teeth;
mod temperature_extrapolation;
mod variance_components;
mod verdict;
mod wander_elsewhere;
mod whiteness;
mod winding;
mod worth;

use crate::data::prepare::{Prepared, prepare};
use crate::design::assembly::{Design, DesignOptions, Options, assemble};
use crate::inference::residuals::Residuals;
use crate::linearization::point::LinearizationPoint;
use crate::linearization::relinearized::RelinearizedFit;
use crate::noise::simulated::Floor;
use crate::progress::{Stage, Watch, unwatched};
use crate::selection::limits::{
    CLOSE_RATIO, DIVERGED_RATIO, RELINEARIZATIONS, TRUSTED_BELOW, UNLOCATED_ABOVE,
    VISIBLE_GAP_RATIO,
};
use crate::transfer::model::Model;
use crate::verdict::answer::{Diagnosis, Verdict};
use crate::verdict::evidence::Evidence;
use effects::sensor::{BasisInputs, READINGS};
use plausibility::{Finding, Fitted, Plausibility};
use recording::Recording;
use selected::SelectedModel;

/// True for a delay. What all segments have in common of the one is the other, the other way round.
fn is_delay(name: &str) -> bool {
    effects::has(name, |card| card.delays)
}

/// The diagnosis with what a report and a model need besides.
#[derive(Clone, Debug, Default)]
pub struct Answer {
    /// What is told.
    pub diagnosis: Diagnosis,
    /// The model, where there is one.
    pub model: Option<Model>,
    /// Held-out residuals with the baseline alone.
    pub before: Residuals,
    /// Held-out residuals with what is named.
    pub after: Residuals,
    /// What a reader may see for himself.
    pub evidence: Evidence,
}

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
            let mut answer = answered(prepared, name, options, watch);
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

/// The answer of a recording that can be diagnosed.
fn answered(mut prepared: Prepared, name: &str, options: &Options, watch: Watch) -> Answer {
    watch(Stage::Compare);
    let first = ModelSelection::from_baseline(&prepared, options);
    let Some(mask) = first.revised_mask() else {
        return first.run(watch).into_answer(name);
    };
    drop(first);
    prepared.use_only(mask);
    let again = ModelSelection::from_baseline(&prepared, options);
    again.run(watch).into_answer(name)
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

/// Everything that a verdict is made of.
pub(crate) struct ModelSelection<'a> {
    prepared: &'a Prepared,
    options: &'a Options,
    /// All columns, linearised about what was found before.
    design: Design<'a>,
    selected: SelectedModel,
    /// What is found, fitted about itself.
    relinearized: RelinearizedFit<'a>,
    /// The simulator's scatter by the stated noise.
    floor: Floor,
    /// Noise of each reading over the stated one, where it was found to be above.
    noise: Option<[f64; READINGS]>,
    /// Held-out residuals of the baseline alone, and with what is found; both by the stated noise.
    before: Residuals,
    after: Residuals,
    /// Residuals of the baseline alone on folds that it has not seen.
    before_by_folds: Residuals,
    /// What the model is expected to leave on another recording, and on folds of one that it has not seen, where a part of it does
    /// not carry over: a drift's course.
    transfer_residuals: Option<[Residuals; 2]>,
    /// What the model is expected to leave where a vibration beats otherwise than it does here.
    without_beats: Option<Residuals>,
    /// An effect that takes more of what the others leave than any shape without a name.
    leading_effect: Option<String>,
}

impl<'a> ModelSelection<'a> {
    /// The first look: about the baseline.
    fn from_baseline(prepared: &'a Prepared, options: &'a Options) -> Self {
        let of = |design_options| assemble(prepared, options, &prepared.point(), design_options);
        let mut first = of(DesignOptions::default());
        let before = first.residuals(&[]);
        if let Some(forms) = far_forms::far_forms(&first, &before) {
            let inputs = BasisInputs {
                forms,
                ..first.linearized.inputs.clone()
            };
            first = of(DesignOptions {
                previous_inputs: Some(&inputs),
                ..DesignOptions::default()
            });
        }
        let selected = SelectedModel::new(&first, false);
        let relinearized = RelinearizedFit::of(&first, &selected);
        Self {
            prepared,
            options,
            floor: first.floor,
            noise: None,
            after: relinearized.residuals().clone(),
            transfer_residuals: None,
            without_beats: None,
            leading_effect: None,
            before_by_folds: Residuals::default(),
            design: first,
            selected,
            relinearized,
            before,
        }
    }

    /// The looks that follow, about what was found.
    fn run(mut self, watch: Watch) -> Self {
        watch(Stage::Phase);
        self.choose_phase();
        watch(Stage::NestedForms);
        self.extend_forms();
        self.allow_for_noise();
        watch(Stage::Relinearize);
        for _ in 0..RELINEARIZATIONS {
            let known = self.selected.names(&self.design);
            self.relinearize_all();
            if self.selected.names(&self.design) == known {
                break;
            }
        }
        watch(Stage::Field);
        self.try_winding();
        self.try_field();
        watch(Stage::SecondEffect);
        if self.try_second_effect() {
            self.try_winding();
        }
        // Before anything goes: what harmonics of the gap's own leave hides what else there is.
        self.complete_gap();
        watch(Stage::Prune);
        self.prune();
        self.complete_growth();
        self.complete_turn();
        self.complete_gap();
        self.resolve_teeth();
        watch(Stage::Predict);
        self.claim();
        watch(Stage::Decide);
        self
    }

    fn into_answer(self, name: &str) -> Answer {
        let (diagnosis, correction) = self.answer(name);
        let selected = diagnosis.verdict != Verdict::InsufficientData;
        let evidence = self.evidence(&diagnosis, correction.as_ref());
        let model = selected.then(|| self.model(&diagnosis, correction));
        Answer {
            diagnosis,
            model,
            before: self.before,
            after: self.after,
            evidence,
        }
    }

    /// Takes over what was found in a design.
    fn accept(&mut self, design: Design<'a>, selected: SelectedModel) {
        if self.is_fitted(&design, &selected) {
            (self.design, self.selected) = (design, selected);
            return;
        }
        let relinearized = RelinearizedFit::of(&design, &selected);
        self.accept_fit(design, selected, relinearized);
    }

    /// True if what was found in another design is what is fitted about itself: of the same columns, from the same start.
    fn is_fitted(&self, design: &Design, selected: &SelectedModel) -> bool {
        let [here, there] = [&self.design, design].map(|s| &s.linearized);
        let columns = |design: &Design, selected: &SelectedModel| {
            let list = design.list(&selected.found.blocks);
            let names = list
                .iter()
                .map(|c| design.columns.regressors[*c].name.clone());
            names.collect::<Vec<String>>()
        };
        here.baseline == there.baseline
            && here.displacement == there.displacement
            && here.noise == there.noise
            && here.inputs.unmodified == there.inputs.unmodified
            && selected.names(design) == self.selected.names(&self.design)
            && columns(design, selected) == columns(&self.design, &self.selected)
    }

    /// The same, fitted about itself already.
    fn accept_fit(
        &mut self,
        design: Design<'a>,
        selected: SelectedModel,
        relinearized: RelinearizedFit<'a>,
    ) {
        (self.design, self.selected, self.relinearized) = (design, selected, relinearized);
        self.update_residuals();
    }

    /// What is left, by the stated noise.
    fn update_residuals(&mut self) {
        self.after = self.by_stated_noise(self.held_out());
    }

    /// Residuals by folds that the fit has not seen. Where a field is told by its teeth, by short pieces: a fold is whole places, and
    /// of teeth that no other fold went over nothing is foretold.
    fn held_out(&self) -> &Residuals {
        let by_teeth = self.relinearized.linearized.inputs.teeth.is_some();
        let pieces = by_teeth.then(|| self.relinearized.left_out()).flatten();
        pieces.unwrap_or_else(|| self.relinearized.residuals())
    }

    fn by_stated_noise(&self, residuals: &Residuals) -> Residuals {
        if self.noise.is_none() {
            return residuals.clone();
        }
        let point = &self.relinearized.point;
        let mut stated = self
            .relinearized
            .linearized
            .moved(point.baseline.clone(), point.displacement.clone());
        stated.noise = [1.0; READINGS];
        residuals.rewhitened(&stated)
    }

    /// Whitened rms of what is left over the floor's.
    fn ratio(&self) -> f64 {
        self.after.white_rms() / self.floor.white_square.sqrt()
    }

    /// Whitened rms of the noise as it was found, over the stated one.
    fn noise_rms(&self) -> f64 {
        if self.noise.is_some() {
            self.ratio()
        } else {
            1.0
        }
    }

    /// What all is compared about. What explains little may be wrong: nothing is moved by it.
    fn trusted(&self) -> LinearizationPoint {
        if self.selected.found.unexplained_fraction < TRUSTED_BELOW {
            self.relinearized.point.clone()
        } else {
            self.prepared.point()
        }
    }

    /// The second look: about what was found, and with the lines that stand in what is left. Looked for only now, when motion
    /// no longer makes lines of its own.
    fn relinearize_all(&mut self) {
        let left = self.ratio() / self.noise_rms();
        if left < CLOSE_RATIO && (self.noise.is_none() || self.selected.found.blocks.is_empty()) {
            return;
        }
        let point = LinearizationPoint {
            noise: self.noise,
            ..self.trusted()
        };
        let design_options = DesignOptions {
            line_residuals: Some(self.relinearized.residuals()),
            search_deflection_waves: self.selected.shaped.unexplained_fraction > UNLOCATED_ABOVE,
            previous_inputs: Some(&self.design.linearized.inputs),
            ..DesignOptions::default()
        };
        let again = assemble(self.prepared, self.options, &point, design_options);
        let inputs = &again.linearized.inputs;
        let lines = !inputs.beacon_lines_hz.is_empty()
            || !inputs.deflection_waves.is_empty()
            || !inputs.flicker_hz.is_empty()
            || !inputs.segment_lines_hz.is_empty()
            || inputs.pair_lines_hz.iter().any(|l| !l.is_empty());
        if self.selected.found.blocks.is_empty() && !lines {
            return;
        }
        let selected = SelectedModel::new(&again, self.noise.is_some());
        if self.selected.left(&self.design) * DIVERGED_RATIO < selected.left(&again) {
            return;
        }
        if self.is_fitted(&again, &selected) {
            self.accept(again, selected);
        } else {
            // To first order it may leave less, and stray where it is fitted about itself.
            let relinearized = RelinearizedFit::of(&again, &selected);
            if self.diverged(&relinearized) {
                return;
            }
            self.accept_fit(again, selected, relinearized);
        }
        self.allow_for_noise();
    }

    /// True if another fit leaves far more of a gap than what is found, by the same noise.
    fn diverged(&self, other: &RelinearizedFit) -> bool {
        let (_, noise) = self.levels();
        let excess = |relinearized: &RelinearizedFit| {
            (relinearized.residuals().white_rms().powi(2) / noise - 1.0).max(0.0)
        };
        excess(other)
            > DIVERGED_RATIO
                * excess(&self.relinearized).max(VISIBLE_GAP_RATIO * VISIBLE_GAP_RATIO - 1.0)
    }

    /// Mean square of the whole gap beyond the noise, and of the noise, in the units of the search.
    fn levels(&self) -> (f64, f64) {
        let mut validation = self.design.cross_validation();
        let rows = validation.rows();
        let noise = self.selected.base / rows;
        (
            (validation.score(&[]).squares / rows - noise).max(1e-9),
            noise.max(1e-9),
        )
    }

    /// Share of the gap that is left, held out, after what is found.
    fn left(&self) -> f64 {
        let (whole_gap, noise) = self.levels();
        let before = if self.noise.is_some() {
            whole_gap
        } else {
            (self.before.white_rms().powi(2) - noise).max(1e-9)
        };
        let after = self.held_out().white_rms();
        ((after.powi(2) - noise) / before).clamp(0.0, 1.0)
    }

    fn allowed(&self, name: &str) -> bool {
        !self.options.without.iter().any(|w| w == name)
    }
}
