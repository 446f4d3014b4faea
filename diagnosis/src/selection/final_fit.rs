//! The model of what is named, fitted on all samples in use.

use super::ModelSelection;
use crate::inference::covariance::PosteriorCovariance;
use crate::linearization::relinearized::RelinearizedFit;
use crate::transfer::amplitude_support::AmplitudeSupport;
use crate::transfer::model::{EffectAmounts, Model, is_of_its_time};
use crate::transfer::support::TrainingSupport;
use crate::verdict::answer::{Diagnosis, Magnitude, Verdict};
use effects::Detection;

impl ModelSelection<'_> {
    /// The model: the baseline alone, and the baseline with what is named.
    pub(super) fn model(&self, diagnosis: &Diagnosis) -> Model {
        let scene = &self.study.scene;
        let mut model = Model {
            schema: 1,
            recording: diagnosis.recording.clone(),
            baseline: self.prepared.baseline.clone(),
            baseline_with_effects: self.prepared.baseline.clone(),
            effects: Vec::new(),
            normal: scene.normal.clone(),
            inputs: scene.inputs.clone(),
            claimed: diagnosis.held_out.clone(),
            bursts: diagnosis
                .effects
                .iter()
                .any(|e| effects::is(&e.name, Detection::AsBursts)),
            visited: None,
            certainty: None,
            reached: None,
        };
        if matches!(diagnosis.verdict, Verdict::Named | Verdict::Alias) {
            let fine = &self.fine;
            model.normal.mean_flaws = fine.scene.mean_flaws();
            model.inputs.skew_moves = fine.scene.inputs.skew_moves;
            model.inputs.growth_told = fine.scene.inputs.growth_told;
            model.inputs.gap_told = fine.scene.inputs.gap_told;
            model.inputs.forms = fine.scene.inputs.forms;
            model.inputs.bend_goes_on = super::temperature_extrapolation::goes_on(fine);
            if let Some(teeth) = &fine.scene.inputs.teeth {
                model.inputs.teeth = Some(teeth.clone());
                model.inputs.field_by_segment = true;
            }
            let count = fine.columns.blocks[0].columns.len();
            let step: Vec<f64> = (0..count).map(|c| fine.amount(c)).collect();
            model.baseline_with_effects = fine.scene.baseline.clone();
            model.baseline_with_effects.add(scene.scope, &step);
            model.effects = amounts(fine);
            let fields = model
                .effects
                .iter()
                .any(|e| effects::is(&e.name, Detection::AsField));
            model.certainty = PosteriorCovariance::of(fine);
            let by_teeth = fine.scene.inputs.teeth.is_some();
            let gap = model
                .effects
                .iter()
                .any(|e| effects::has(&e.name, |card| card.by_amplitude));
            model.reached = gap.then(|| AmplitudeSupport::of(&fine.scene));
            model.visited = (fields && !by_teeth).then(|| TrainingSupport::of(&fine.scene));
        }
        model
    }
}

fn amounts(fine: &RelinearizedFit) -> Vec<EffectAmounts> {
    let one = |c: usize| Magnitude {
        name: fine.columns.regressors[c].name.clone(),
        value: fine.amount(c),
        deviation: None,
        unit: fine.columns.regressors[c].unit.into(),
    };
    let swell = crate::spectra::resonance::breath(fine).of_its_time;
    fine.columns
        .blocks
        .iter()
        .skip(1)
        .map(|block| EffectAmounts {
            name: block.name.clone(),
            carries_over: !is_of_its_time(&block.name, &fine.scene.inputs),
            amounts: block
                .columns
                .clone()
                .filter(|c| !swell.contains(c))
                .map(one)
                .collect(),
        })
        .collect()
}
