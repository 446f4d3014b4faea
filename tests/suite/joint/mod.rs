//! The joint calibration against a courier under a beacon in f64.

mod constraints;
mod schedule;
mod synthetic;

use crate::common::beacon::{BeaconCourier, PITCH};
use courier_sensor::calibration::joint::*;

const TURN: f64 = 1.5 * std::f64::consts::PI / 180.0;

fn values(truth: &[f64]) -> Values {
    let mut values = [0.0; JOINT_UNKNOWNS];
    values
        .iter_mut()
        .zip(truth)
        .for_each(|(v, t)| *v = *t as f32);
    values
}

/// Samples of so many poses within a pitch.
fn samples(courier: &mut BeaconCourier, poses: usize) -> Vec<JointSample> {
    let readings = courier.readings(poses, PITCH, TURN);
    readings.into_iter().map(|reading| reading.sample).collect()
}

/// What a fit of the paper's unknowns gives.
struct Fit {
    solver: Box<JointSolver>,
    found: Values,
    report: FitReport,
}

/// Fits the paper's unknowns, all together, from these values.
fn fit(constraints: &Constraints, samples: &[JointSample], start: &Values, priors: &Priors) -> Fit {
    let mut solver = Box::new(JointSolver::new());
    solver.set_priors(constraints, start, priors);
    let (mut found, poses) = (*start, samples.iter().copied());
    let report = solver.fit(constraints, &poses, Groups::PAPER, &mut found);
    Fit {
        solver,
        found,
        report: report.unwrap(),
    }
}
