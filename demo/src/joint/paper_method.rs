//! The paper's own method on the same poses: g_p alone, then h, l and o' with the platen fixed, then everything of its
//! section 3.2 together. Equal weights, no terms for the coordination sensor's own errors, no map of the teeth, no step reverted.

use crate::flyby::deviation;
use anyhow::{Context, Result, anyhow};
use courier_sensor::calibration::joint::{
    Constraints, Groups, JointBuffer, JointSolver, Layout, Priors, ReadingNoise, Unknown, Values,
    Weighting, entered, model_of,
};
use courier_sensor::geometry::Geometry;
use courier_sensor::model::{ErrorModel, TermTable};

/// What the paper's method makes of some poses.
pub struct PaperFit {
    /// Platen sensor by g_p alone.
    pub separate: ErrorModel,
    /// Platen sensor of the joint fit.
    pub joint: ErrorModel,
    /// With height and lever arm of the joint fit.
    pub geometry: Geometry,
    /// Standard deviations of g_p, g_x, g_y over the held-out poses, metres.
    pub residuals_m: [f64; 3],
}

/// Only sets the priors' weight against the poses: a segment's error by the platen's teeth, the paper's 1.9 µm.
const NOISE_M: f32 = 1.9e-6;

/// Fits, from the drawing's geometry on.
///
/// # Errors
/// Poses that the solver cannot solve.
pub fn fit(poses: &JointBuffer, drawing: &Geometry) -> Result<PaperFit> {
    let template = ErrorModel::zero(TermTable::equation_9());
    let layout = Layout::new(&template).context("equation (9) has too many terms")?;
    let noise = ReadingNoise {
        segment_m: NOISE_M,
        displacement_m: NOISE_M,
    };
    let constraints = Constraints {
        geometry: *drawing,
        layout,
        noise,
        stated_noise: noise,
        weighting: Weighting::Equal,
    };
    let mut values = entered(&constraints.layout, &template, drawing);
    let mut solver = Box::new(JointSolver::new());
    solver.set_priors(&constraints, &values, &Priors::default());
    let mut step = |groups: Groups, values: &mut Values| {
        let fitted = solver.fit(&constraints, &poses.fitted(), groups, values);
        fitted
            .map(|_| ())
            .map_err(|error| anyhow!("the paper's method: {error:?}"))
    };
    step(Groups::PLATEN, &mut values)?;
    let separate = model_of(&constraints.layout, &values, &template);
    step(Groups::MOUNTING, &mut values)?;
    step(Groups::PAPER, &mut values)?;
    let misclosures: Vec<_> = poses
        .held_out()
        .map(|pose| constraints.misclosure(&values, &pose))
        .collect();
    let mut geometry = *drawing;
    for index in 0..constraints.layout.len() {
        match constraints.layout.unknown(index) {
            Unknown::Height => geometry.height_m = values[index],
            Unknown::Lever(axis) => geometry.lever_m[axis] = values[index],
            _ => {}
        }
    }
    let residual = |i: usize| {
        deviation(
            &misclosures
                .iter()
                .map(|g| f64::from(g[i]))
                .collect::<Vec<_>>(),
        )
    };
    Ok(PaperFit {
        separate,
        joint: model_of(&constraints.layout, &values, &template),
        geometry,
        residuals_m: [residual(0), residual(1), residual(2)],
    })
}
