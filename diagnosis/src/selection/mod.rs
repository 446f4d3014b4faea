//! From scores to a verdict.

mod attribution;
mod bursts_and_noise;
mod common_field;
mod completing_terms;
pub mod core_terms;
mod elimination;
mod field;
mod final_fit;
mod intermodulation;
pub mod limits;
mod location;
mod missing_codes;
mod named;
mod nested_forms;
mod noise;
mod noise_level;
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
mod winding;

use crate::data::prepare::{Prepared, prepare};
use crate::design::assembly::{Design, DesignOptions, Options, assemble};
use crate::inference::residuals::Residuals;
use crate::linearization::point::LinearizationPoint;
use crate::linearization::relinearized::RelinearizedFit;
use crate::noise::simulated::Floor;
use crate::progress::{Stage, Watch, unwatched};
use crate::selection::limits::{
    CLOSE, LEFT_OVER, LOOKS, NOWHERE, OTHER_PHASE, OTHER_PHASE_TAKES, STRAYED, TRUSTED, VISIBLE,
};
use crate::transfer::model::Model;
use crate::verdict::answer::{Diagnosis, Verdict};
use crate::verdict::evidence::{Evidence, Step};
use effects::sensor::READINGS;
use plausibility::{Finding, Fitted, Plausibility};
use recording::Recording;
use selected::SelectedModel;

/// True for a delay. What all segments have in common of the one is the other, the other way round.
fn is_delay(name: &str) -> bool {
    effects::has(name, |card| card.delays)
}
/// Names of the effects whose harmonics run over either phase of the own tooth.
fn of_either_phase() -> Vec<String> {
    let cards = effects::cards().filter(|card| card.either_phase);
    cards.map(|card| card.name.into()).collect()
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
    let Plausibility { findings, geometry } = plausibility::look(recording);
    if !findings.is_empty() {
        let notes = findings.iter().map(Finding::to_string).collect();
        return unanswered(name, notes, findings, geometry);
    }
    let mut answer = match prepare(recording) {
        Ok(prepared) => answered(prepared, name, options, watch),
        Err(limit) => return unanswered(name, vec![limit.to_string()], findings, geometry),
    };
    answer.diagnosis.geometry = geometry;
    answer
}

/// The answer of a recording that can be diagnosed.
fn answered(mut prepared: Prepared, name: &str, options: &Options, watch: Watch) -> Answer {
    watch(Stage::Compare);
    let first = ModelSelection::at_first(&prepared, options);
    let Some(keep) = first.in_use_anew() else {
        return first.in_full(watch).into_answer(name);
    };
    drop(first);
    prepared.use_only(keep);
    let again = ModelSelection::at_first(&prepared, options);
    again.in_full(watch).into_answer(name)
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
    study: Design<'a>,
    told: SelectedModel,
    /// What is found, fitted about itself.
    fine: RelinearizedFit<'a>,
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
    elsewhere: Option<[Residuals; 2]>,
    /// What the model is expected to leave where a vibration beats otherwise than it does here.
    without_beats: Option<Residuals>,
    /// An effect that takes more of what the others leave than any shape without a name.
    leads: Option<String>,
}

impl<'a> ModelSelection<'a> {
    /// The first look: about the baseline.
    fn at_first(prepared: &'a Prepared, options: &'a Options) -> Self {
        let first = assemble(
            prepared,
            options,
            &prepared.about(),
            DesignOptions::default(),
        );
        let before = first.residuals(&[]);
        let told = SelectedModel::new(&first, false);
        let fine = RelinearizedFit::of(&first, &told);
        Self {
            prepared,
            options,
            floor: first.floor,
            noise: None,
            after: fine.residuals().clone(),
            elsewhere: None,
            without_beats: None,
            leads: None,
            before_by_folds: Residuals::default(),
            study: first,
            told,
            fine,
            before,
        }
    }

    /// The looks that follow, about what was found.
    fn in_full(mut self, watch: Watch) -> Self {
        watch(Stage::Phase);
        self.choose_phase();
        watch(Stage::NestedForms);
        self.tell_more_fully();
        self.allow_for_noise();
        watch(Stage::Relinearize);
        for _ in 0..LOOKS {
            let known = self.told.names(&self.study);
            self.look_again();
            if self.told.names(&self.study) == known {
                break;
            }
        }
        watch(Stage::Field);
        self.try_winding();
        self.try_field();
        watch(Stage::SecondEffect);
        if self.try_beside() {
            self.try_winding();
        }
        // Before anything goes: what harmonics of the gap's own leave hides what else there is.
        self.tell_gap();
        watch(Stage::Prune);
        self.prune();
        self.tell_growth();
        self.tell_turn();
        self.tell_gap();
        self.tell_teeth();
        watch(Stage::Predict);
        self.claim();
        watch(Stage::Decide);
        self
    }

    fn into_answer(self, name: &str) -> Answer {
        let diagnosis = self.answer(name);
        let told = diagnosis.verdict != Verdict::InsufficientData;
        let model = told.then(|| self.model(&diagnosis));
        let evidence = self.evidence(&diagnosis);
        Answer {
            diagnosis,
            model,
            before: self.before,
            after: self.after,
            evidence,
        }
    }

    /// Takes over what was found in a study.
    fn take(&mut self, study: Design<'a>, told: SelectedModel) {
        if self.is_fitted(&study, &told) {
            (self.study, self.told) = (study, told);
            return;
        }
        let fine = RelinearizedFit::of(&study, &told);
        self.take_fitted(study, told, fine);
    }

    /// True if what was found in another study is what is fitted about itself: of the same columns, from the same start.
    fn is_fitted(&self, study: &Design, told: &SelectedModel) -> bool {
        let [here, there] = [&self.study, study].map(|s| &s.scene);
        let columns = |study: &Design, told: &SelectedModel| {
            let list = study.list(&told.found.blocks);
            let names = list
                .iter()
                .map(|c| study.columns.regressors[*c].name.clone());
            names.collect::<Vec<String>>()
        };
        here.baseline == there.baseline
            && here.shift == there.shift
            && here.noise == there.noise
            && here.inputs.unmodified == there.inputs.unmodified
            && told.names(study) == self.told.names(&self.study)
            && columns(study, told) == columns(&self.study, &self.told)
    }

    /// The same, fitted about itself already.
    fn take_fitted(&mut self, study: Design<'a>, told: SelectedModel, fine: RelinearizedFit<'a>) {
        (self.study, self.told, self.fine) = (study, told, fine);
        self.restate();
    }

    /// What is left, by the stated noise.
    fn restate(&mut self) {
        self.after = self.by_stated_noise(self.held_out());
    }

    /// Residuals by folds that the fit has not seen. Where a field is told by its teeth, by short pieces: a fold is whole places, and
    /// of teeth that no other fold went over nothing is foretold.
    fn held_out(&self) -> &Residuals {
        let by_teeth = self.fine.scene.inputs.teeth.is_some();
        let pieces = by_teeth.then(|| self.fine.left_out()).flatten();
        pieces.unwrap_or_else(|| self.fine.residuals())
    }

    fn by_stated_noise(&self, residuals: &Residuals) -> Residuals {
        if self.noise.is_none() {
            return residuals.clone();
        }
        let about = &self.fine.about;
        let mut stated = self
            .fine
            .scene
            .moved(about.baseline.clone(), about.shift.clone());
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

    /// Free harmonics may run over the calibrated phase, where the courier is, or over the unmodified output's, as equation (3)
    /// does: by high orders the two are a good part of a turn apart. That which leaves less is kept, for all of them.
    fn choose_phase(&mut self) {
        let found = self.told.names(&self.study);
        let harmonic = found
            .iter()
            .any(|name| effects::has(name, |card| card.either_phase));
        // What is found beside harmonics may stand in for what they lack over the wrong phase.
        let alone = found.len() == 1;
        let closed = self.ratio() < if harmonic { CLOSE } else { VISIBLE } && (alone || !harmonic);
        if closed || !harmonic && self.told.found.rest < LEFT_OVER {
            return;
        }
        let mut inputs = self.study.scene.inputs.clone();
        inputs.unmodified = true;
        let mut list = found;
        list.extend(of_either_phase());
        let mut look = DesignOptions {
            as_in: Some(&inputs),
            only: Some(&list),
            ..DesignOptions::default()
        };
        let about = self.prepared.about();
        let harmonics = assemble(self.prepared, self.options, &about, look);
        if !self.less_is_left_in(&harmonics) {
            return;
        }
        look.only = None;
        let again = assemble(self.prepared, self.options, &about, look);
        let told = SelectedModel::new(&again, false);
        let fine = RelinearizedFit::of(&again, &told);
        let excess = |r: &Residuals| r.white_rms().powi(2) - self.floor.white_square;
        if excess(fine.residuals()) < OTHER_PHASE * excess(self.fine.residuals()) {
            self.take_fitted(again, told, fine);
        }
    }

    /// True if harmonics leave less in another study than in this one, by themselves or beside what is found.
    fn less_is_left_in(&self, other: &Design) -> bool {
        let known = self.told.names(&self.study);
        let left = |study: &Design, names: &[String]| {
            let of_these = |b: &usize| names.contains(&study.columns.blocks[*b].name);
            let blocks: Vec<usize> = study.effects().into_iter().filter(of_these).collect();
            let mut arena = study.arena();
            arena.score(&blocks).squares - arena.rows() * study.floor.white_square
        };
        of_either_phase().iter().any(|name| {
            let alone = vec![name.clone()];
            let beside = [&known[..], &alone].concat();
            [alone, beside].iter().any(|names| {
                let [here, there] = [&self.study, other].map(|s| left(s, names));
                crate::trace::log(&format!(
                    "{names:?} leave {here:.0}, over the other phase {there:.0}"
                ));
                // What is of no physical size leaves no end.
                there < here - OTHER_PHASE_TAKES * here.abs()
                    || here.is_infinite() && there.is_finite()
            })
        })
    }

    /// What all is compared about. What explains little may be wrong: nothing is moved by it.
    fn trusted(&self) -> LinearizationPoint {
        if self.told.found.rest < TRUSTED {
            self.fine.about.clone()
        } else {
            self.prepared.about()
        }
    }

    /// The second look: about what was found, and with the lines that stand in what is left. Looked for only now, when motion
    /// no longer makes lines of its own.
    fn look_again(&mut self) {
        let left = self.ratio() / self.noise_rms();
        if left < CLOSE && (self.noise.is_none() || self.told.found.blocks.is_empty()) {
            return;
        }
        let about = LinearizationPoint {
            noise: self.noise,
            ..self.trusted()
        };
        let look = DesignOptions {
            lines_of: Some(self.fine.residuals()),
            fringes: self.told.shaped.rest > NOWHERE,
            as_in: Some(&self.study.scene.inputs),
            ..DesignOptions::default()
        };
        let again = assemble(self.prepared, self.options, &about, look);
        let inputs = &again.scene.inputs;
        let lines = !inputs.beacon_lines_hz.is_empty()
            || !inputs.deflection_waves.is_empty()
            || !inputs.flicker_hz.is_empty()
            || !inputs.segment_lines_hz.is_empty()
            || inputs.pair_lines_hz.iter().any(|l| !l.is_empty());
        if self.told.found.blocks.is_empty() && !lines {
            return;
        }
        let told = SelectedModel::new(&again, self.noise.is_some());
        if self.told.left(&self.study) * STRAYED < told.left(&again) {
            return;
        }
        if self.is_fitted(&again, &told) {
            self.take(again, told);
        } else {
            // To first order it may leave less, and stray where it is fitted about itself.
            let fine = RelinearizedFit::of(&again, &told);
            if self.strayed(&fine) {
                return;
            }
            self.take_fitted(again, told, fine);
        }
        self.allow_for_noise();
    }

    /// True if another fit leaves far more of a gap than what is found, by the same noise.
    fn strayed(&self, other: &RelinearizedFit) -> bool {
        let (_, noise) = self.levels();
        let excess =
            |fine: &RelinearizedFit| (fine.residuals().white_rms().powi(2) / noise - 1.0).max(0.0);
        excess(other) > STRAYED * excess(&self.fine).max(VISIBLE * VISIBLE - 1.0)
    }

    /// Mean square of the whole gap beyond the noise, and of the noise, in the units of the search.
    fn levels(&self) -> (f64, f64) {
        let mut arena = self.study.arena();
        let rows = arena.rows();
        let noise = self.told.base / rows;
        (
            (arena.score(&[]).squares / rows - noise).max(1e-9),
            noise.max(1e-9),
        )
    }

    /// Share of the gap that is left, held out, after what is found.
    fn left(&self) -> f64 {
        let (whole, noise) = self.levels();
        let before = if self.noise.is_some() {
            whole
        } else {
            (self.before.white_rms().powi(2) - noise).max(1e-9)
        };
        let after = self.held_out().white_rms();
        ((after.powi(2) - noise) / before).clamp(0.0, 1.0)
    }

    /// Residuals beside their coordinates, and the gap after each effect in the order of the answer.
    fn evidence(&self, diagnosis: &Diagnosis) -> Evidence {
        let columns = &self.study.columns;
        let floor = self.floor.white_square.sqrt();
        let found = &self.told.found.blocks;
        let step = |effect: &str, of: &Residuals| Step {
            effect: effect.into(),
            whitened: of.white_rms() / floor,
        };
        let mut steps = vec![step("", &self.before)];
        let mut blocks = Vec::new();
        for effect in &diagnosis.effects {
            let same = |b: &&usize| columns.blocks[**b].name == effect.name;
            if let Some(&block) = found.iter().find(same) {
                blocks.push(block);
                steps.push(if blocks.len() == found.len() {
                    step(&effect.name, &self.after)
                } else {
                    let part = self.study.residuals(&blocks);
                    step(&effect.name, &part)
                });
            }
        }
        let after = if blocks.is_empty() {
            &self.before
        } else {
            &self.after
        };
        let mut evidence = Evidence::new(&self.study.scene, &self.before, after, steps);
        evidence.set_aside += self.prepared.samples - evidence.samples;
        evidence.samples = self.prepared.samples;
        evidence
    }

    fn allowed(&self, name: &str) -> bool {
        !self.options.without.iter().any(|w| w == name)
    }
}
