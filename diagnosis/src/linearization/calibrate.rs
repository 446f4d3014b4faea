//! Gauss-Newton for the baseline, on all samples in use or without one fold.

use crate::data::folds::folds;
use crate::data::observations::Observations;
use crate::design::gram::{Columns, Gram, solve};
use crate::linearization::baseline::Baseline;
use crate::linearization::scene::{LatentDisplacement, Scene};

/// Steps of Gauss-Newton; the model is linear but for the products of h, l and theta.
const STEPS: usize = 5;

/// Calibrates equations (3), (5) and (11).
pub fn calibrate(observations: &Observations, keep: &[bool]) -> Baseline {
    let fold = folds(&observations.stretch);
    let mut baseline = Baseline::nominal(observations);
    let mut scene = Scene::new(observations, baseline.clone(), keep.to_vec());
    for _ in 0..STEPS {
        let columns = baseline_columns(&scene);
        let gram = Gram::new(&scene, &columns, &fold);
        let all: Vec<usize> = (0..gram.width()).collect();
        let Some(fit) = solve(gram.training(None), &all, &gram.centre, 1.0) else {
            break;
        };
        let step: Vec<f64> = fit
            .amount
            .iter()
            .zip(&gram.scale)
            .map(|(a, s)| a * s)
            .collect();
        baseline.add(scene.scope, &step);
        scene = scene.moved(baseline.clone(), LatentDisplacement::default());
        let largest = fit.amount.iter().fold(0.0f64, |m, a| m.max(a.abs()));
        if largest < 1e-6 {
            break;
        }
    }
    baseline
}

/// The baseline's columns, with its priors about nominal values.
pub fn baseline_columns(scene: &Scene) -> Columns {
    let nominal = Baseline::nominal(scene.observations);
    let mut columns = Columns::default();
    let (regressors, values) = scene.baseline.regressors(scene.scope);
    let (_, wanted) = nominal.regressors(scene.scope);
    columns.push("baseline", regressors);
    columns.centre = wanted.iter().zip(&values).map(|(w, v)| w - v).collect();
    columns
}
