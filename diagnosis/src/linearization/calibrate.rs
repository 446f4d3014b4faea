//! Gauss-Newton for the baseline, on all samples in use or without one fold.

use crate::data::folds::folds;
use crate::data::observations::Observations;
use crate::design::gram::{Columns, Gram};
use crate::inference::fit::solve;
use crate::linearization::baseline::Baseline;
use crate::linearization::recording::{LatentDisplacement, LinearizedRecording};
use crate::linearization::unknown_angle;
use effects::sensor::Regressor;

/// Steps of Gauss-Newton. Derived from quadratic convergence: the model is linear but for the products of h, l and theta, so that
/// 5 % of error (paper, 3.2.1) is 0.2 % after one step and 1e-11 after three.
const CALIBRATION_STEPS: usize = 5;

/// Calibrates equations (3), (5) and (11).
pub fn calibrate(observations: &Observations, mask: &[bool]) -> Baseline {
    let fold = folds(&observations.stretch);
    let mut baseline = Baseline::nominal(observations);
    let mut linearized = LinearizedRecording::new(observations, baseline.clone(), mask.to_vec());
    linearized.aligned_in_time = true;
    for _ in 0..CALIBRATION_STEPS {
        let columns = baseline_columns(&linearized);
        let gram = Gram::new(&linearized, &columns, &fold);
        let all: Vec<usize> = (0..gram.width()).collect();
        let Some(fit) = solve(gram.training(None), &all, &gram.centre, 1.0) else {
            break;
        };
        let step: Vec<f64> = fit
            .coefficient
            .iter()
            .zip(&gram.scale)
            .map(|(a, s)| a * s)
            .collect();
        baseline.add(linearized.scope, &step);
        linearized = linearized.moved(baseline.clone(), LatentDisplacement::default());
        let largest = fit.coefficient.iter().fold(0.0f64, |m, a| m.max(a.abs()));
        if largest < 1e-6 {
            break;
        }
    }
    baseline
}

/// The baseline's columns, with its priors about nominal values, and after them what an angle that is not known may do.
pub fn baseline_columns(linearized: &LinearizedRecording) -> Columns {
    with_baseline_and(linearized, unknown_angle::regressors(linearized))
}

/// The same of the equations alone.
pub fn equation_columns(linearized: &LinearizedRecording) -> Columns {
    with_baseline_and(linearized, Vec::new())
}

fn with_baseline_and(linearized: &LinearizedRecording, others: Vec<Regressor>) -> Columns {
    let nominal = Baseline::nominal(linearized.observations);
    let mut columns = Columns::default();
    let (mut regressors, values) = linearized.baseline.regressors(linearized.scope);
    let (_, wanted) = nominal.regressors(linearized.scope);
    regressors.extend(others);
    columns.push("baseline", regressors);
    for (centre, (wanted, value)) in columns.centre.iter_mut().zip(wanted.iter().zip(&values)) {
        *centre = wanted - value;
    }
    columns
}
