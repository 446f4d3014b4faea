//! The model of what is named, fitted on all samples in use.

use super::fitted_effects::FittedEffects;
use super::nameless_correction::NamelessCorrection;
use crate::inference::covariance::PosteriorCovariance;
use crate::linearization::relinearized::RelinearizedFit;
use crate::transfer::amplitude_support::AmplitudeSupport;
use crate::transfer::model::{EffectAmounts, Model, is_time_bound};
use crate::transfer::support::TrainingSupport;
use crate::verdict::answer::{Diagnosis, Magnitude, Verdict};
use effects::Detection;

impl FittedEffects<'_> {
    /// The model: the baseline alone, and the baseline with what is named, or with a correction without a name.
    pub(super) fn model(
        &self,
        diagnosis: &Diagnosis,
        correction: Option<NamelessCorrection>,
    ) -> Model {
        let linearized = &self.design.linearized;
        let mut model = Model {
            schema: 1,
            recording: diagnosis.recording.clone(),
            baseline: self.prepared.baseline.clone(),
            baseline_with_effects: self.prepared.baseline.clone(),
            effects: Vec::new(),
            normal: linearized.normal.clone(),
            inputs: linearized.inputs.clone(),
            claimed: diagnosis.held_out.clone(),
            bursts: diagnosis
                .effects
                .iter()
                .any(|e| effects::is(&e.name, Detection::AsBursts)),
            visited: None,
            certainty: None,
            reached: None,
            nameless: correction.map(|correction| correction.amounts),
        };
        if matches!(diagnosis.verdict, Verdict::Named | Verdict::Alias) {
            let relinearized = &self.relinearized;
            model.normal.mean_flaws = relinearized.linearized.mean_flaws();
            model.inputs.skew_moves = relinearized.linearized.inputs.skew_moves;
            model.inputs.growth_told = relinearized.linearized.inputs.growth_told;
            model.inputs.gap_told = relinearized.linearized.inputs.gap_told;
            model.inputs.forms = relinearized.linearized.inputs.forms;
            model.inputs.bend_goes_on = super::temperature_extrapolation::goes_on(relinearized);
            if let Some(teeth) = &relinearized.linearized.inputs.teeth {
                model.inputs.teeth = Some(teeth.clone());
                model.inputs.field_by_segment = true;
            }
            let count = relinearized.columns.blocks[0].columns.len();
            let step: Vec<f64> = (0..count).map(|c| relinearized.coefficient(c)).collect();
            model.baseline_with_effects = relinearized.linearized.baseline.clone();
            model.baseline_with_effects.add(linearized.scope, &step);
            model.effects = amounts(relinearized);
            let fields = model
                .effects
                .iter()
                .any(|e| effects::is(&e.name, Detection::AsField));
            model.certainty = PosteriorCovariance::of(relinearized);
            let by_teeth = relinearized.linearized.inputs.teeth.is_some();
            let gap = model
                .effects
                .iter()
                .any(|e| effects::has(&e.name, |card| card.by_amplitude));
            model.reached = gap.then(|| AmplitudeSupport::of(&relinearized.linearized));
            model.visited =
                (fields && !by_teeth).then(|| TrainingSupport::of(&relinearized.linearized));
        }
        model
    }
}

fn amounts(relinearized: &RelinearizedFit) -> Vec<EffectAmounts> {
    let one = |c: usize| Magnitude {
        name: relinearized.columns.regressors[c].name.clone(),
        value: relinearized.coefficient(c),
        deviation: None,
        unit: relinearized.columns.regressors[c].unit.into(),
    };
    let swell = crate::spectra::resonance::amplitude_modulation(relinearized).time_bound;
    relinearized
        .columns
        .blocks
        .iter()
        .skip(1)
        .map(|block| EffectAmounts {
            name: block.name.clone(),
            carries_over: !is_time_bound(&block.name, &relinearized.linearized.inputs),
            amounts: block
                .columns
                .clone()
                .filter(|c| !swell.contains(c))
                .map(one)
                .collect(),
        })
        .collect()
}
