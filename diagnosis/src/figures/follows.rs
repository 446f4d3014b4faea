//! How what is left follows a logged column: by how much for one unit of it, and where.

use super::location::{Located, reported};
use crate::algebra::statistics::NORMAL_95;
use crate::data::channel_names::CHANNEL_NAMES;
use crate::design::assembly::Design;
use crate::design::coordinate_basis::{logged_columns, with_own_phase};
use crate::inference::posterior::{Estimate, birge_ratio};
use crate::inference::residuals::Residuals;
use crate::verdict::answer::Follows;
use effects::sensor::{CHANNELS, Regressor};
use nalgebra::DVector;
use normal_equations::unit_priors::{Solution, solve};

/// Samples that a slope is averaged over, derived from an rms of so many being known to 4 %.
const SAMPLES_LOOKED_AT: usize = 300;

/// What follows a logged column, of what is left after `blocks`: of each coordinate that is told and is one of a logged column's. Cost of each:
/// a third of the cube of its columns, and a pass over the samples.
pub(super) fn follows(design: &Design, blocks: &[usize], located: &[Located]) -> Vec<Follows> {
    let known = design.list(blocks);
    let mut out = Vec::new();
    for (k, column) in logged_columns(&design.linearized.inputs) {
        for (coordinate, over_teeth) in [(column.into(), false), (with_own_phase(column), true)] {
            let found = reported(located).find(|l| l.coordinate == coordinate);
            let slopes = found.map(|l| slopes(design, &known, l.columns(), k));
            let told = |(of, slope): (String, Estimate)| Follows {
                column: column.into(),
                of,
                over_teeth,
                per_unit_m: slope.value,
                deviation_m: slope.deviation,
            };
            out.extend(slopes.into_iter().flatten().map(told));
        }
    }
    out.sort_by(|a, b| b.per_unit_m.total_cmp(&a.per_unit_m));
    out
}

/// Whose a column of shapes is.
fn owner(regressor: &Regressor) -> Option<String> {
    use effects::sensor::Action;
    match regressor.action {
        Action::Reading(segment @ 0..=3, _) => Some(CHANNEL_NAMES[3 + segment].into()),
        Action::Channel(channel @ 0..CHANNELS, _) => Some(CHANNEL_NAMES[channel].into()),
        _ => None,
    }
}

/// By how much the error of each segment or channel changes with one unit of the logged column `k` about its mean: rms over the samples, m. Only
/// what chance does not give.
fn slopes(
    design: &Design,
    known: &[usize],
    columns: &[usize],
    k: usize,
) -> Vec<(String, Estimate)> {
    let Some(unit) = design.linearized.inputs.logged.get(k) else {
        return Vec::new();
    };
    let new = columns.iter().copied().filter(|c| !known.contains(c));
    let list: Vec<usize> = known.iter().copied().chain(new).collect();
    let gram = &design.gram;
    let training = gram.training(None);
    let right = DVector::from_fn(list.len(), |a, _| training.at(list[a], training.last()));
    let centres = list.iter().map(|c| gram.centre[*c]);
    let Some(Solution { values, factor, .. }) = solve(training.lower(&list), right, centres) else {
        return Vec::new();
    };
    let birge = birge_ratio(&Residuals::new(
        &design.linearized,
        &design.columns,
        gram,
        &design.folds,
        &list,
    ));
    let regressors = &design.columns.regressors;
    let mut owners: Vec<String> = columns
        .iter()
        .filter_map(|c| owner(&regressors[*c]))
        .collect();
    owners.sort();
    owners.dedup();
    let mut out = Vec::new();
    for whose in owners {
        let own = |at: &usize| {
            let c = list[*at];
            columns.contains(&c) && owner(&regressors[c]).as_ref() == Some(&whose)
        };
        let own: Vec<usize> = (0..list.len()).filter(own).collect();
        let mut square = 0.0;
        let mut gradient = DVector::zeros(list.len());
        let samples = looked_at(design);
        for &i in &samples {
            let by_amount = changes(design, i, k, own.iter().map(|at| list[*at]));
            let change: f64 = own
                .iter()
                .zip(&by_amount)
                .map(|(at, by)| values[*at] * by)
                .sum();
            square += change * change;
            for (at, by) in own.iter().zip(&by_amount) {
                gradient[*at] += change * by;
            }
        }
        let count = samples.len().max(1) as f64;
        let rms = (square / count).sqrt();
        gradient /= (count * rms).max(f64::MIN_POSITIVE);
        let deviation = birge * factor.deviation(&gradient);
        // The rms of so many amounts is not zero where they are: their squares are a chi-square's, of which this is the 95th percentile.
        let freedom = own.len() as f64;
        let chance = freedom + NORMAL_95 * (2.0 * freedom).sqrt();
        if rms * rms > chance * deviation * deviation {
            let per_unit = |of: f64| of / unit.deviation;
            let slope = Estimate {
                value: per_unit(rms),
                deviation: per_unit(deviation),
            };
            out.push((whose, slope));
        }
    }
    out
}

/// Samples in use, evenly spread.
fn looked_at(design: &Design) -> Vec<usize> {
    let linearized = &design.linearized;
    let kept: Vec<usize> = (0..linearized.len())
        .filter(|i| linearized.mask[*i])
        .collect();
    let every = kept.len().div_ceil(SAMPLES_LOOKED_AT).max(1);
    kept.into_iter().step_by(every).collect()
}

/// How what each of some columns adds at a sample changes with the logged column `k` about its mean, in units of its deviation, for an amount of
/// one prior deviation, m.
fn changes(design: &Design, i: usize, k: usize, columns: impl Iterator<Item = usize>) -> Vec<f64> {
    let at = |logged: f64| {
        let mut covariates = design.linearized.covariates(i);
        covariates.logged[k] = logged;
        covariates
    };
    let [above, below] = [0.5, -0.5].map(at);
    let change = |c: usize| {
        let regressor = &design.columns.regressors[c];
        let adds = |at| -> f64 {
            let readings = regressor.action.on_readings(at);
            let channels = regressor.action.on_channels(at);
            readings.iter().chain(&channels).sum()
        };
        design.gram.scale[c] * (adds(&above) - adds(&below))
    };
    columns.map(change).collect()
}
