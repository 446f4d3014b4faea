//! A recording under a model: what is known is put into the residuals, and what is arbitrary here is fitted.

use crate::data::folds::folds;
use crate::data::observations::Observations;
use crate::design::gram::{Columns, Gram};
use crate::inference::fit::coefficients;
use crate::inference::residuals::Residuals;
use crate::linearization::paths::likeliest;
use crate::linearization::recording::LinearizedRecording;
use crate::linearization::relinearized::remembers;
use crate::spectra::phase::{Line, align, waves};
use crate::transfer::arbitrary::{between_stretches, is_brought_along, zero_of_the_angle, zeros};
use crate::transfer::model::Model;
use effects::Detection;
use effects::sensor::{BasisInputs, Regressor};
use std::sync::Arc;

/// What the model, or its baseline alone, leaves at some samples; and the linearized recording under it.
pub(super) fn residuals<'a>(
    model: &Model,
    observations: &'a Observations,
    mask: Vec<bool>,
    with: bool,
) -> (Residuals, LinearizedRecording<'a>) {
    let (linearized, columns, list) = apply(model, observations, mask, with);
    (evaluate(&linearized, &columns, &list), linearized)
}

/// The linearized recording under the model: known amounts are put into the residual by columns with a prior that does not move.
pub(super) fn apply<'a>(
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
        late_s: own.late_s,
        beacon_stretches: own.beacon_stretches.clone(),
        middle_m: middle_m(&model.inputs, &own),
        ..model.inputs.clone()
    };
    let mut columns = Columns::default();
    let mut zeros = zeros(&linearized);
    if with && linearized.scope.beacon && model.follows_temperature() {
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
