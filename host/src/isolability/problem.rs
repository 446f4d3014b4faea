//! The triangle of a motion's rows, and what it says of each unknown.

use super::poses;
use super::question::Question;
use courier_sensor::calibration::joint::{
    Constraints, Groups, JointSolver, Layout, Priors, ReadingNoise, Unknown, Weighting, entered,
    foreseen_under_beacon,
};
use courier_sensor::model::{ErrorModel, TermTable};
use guided::triangle::Triangle;
use nalgebra::DMatrix;
use serde::Serialize;
use std::ops::Range;

/// An unknown whose deviation is above this share of its prior's is the prior's. Derived from information: at 0.7 the prior and
/// the data tell the same, since their inverse squares add.
const PRIORS_OWN: f64 = 0.7;

/// One unknown.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Parameter {
    /// Its name.
    pub name: String,
    /// Unit of the deviations.
    pub unit: &'static str,
    /// Predicted standard deviation by the poses alone; none where they do not determine it.
    pub deviation: Option<f64>,
    /// With what is believed before.
    pub deviation_with_prior: f64,
    /// The prior's own.
    pub prior: f64,
    /// `data` or `prior`: which of them the result would rest on.
    pub rests_on: &'static str,
}

/// The rows of a motion, pose by pose.
pub(super) struct Rows {
    layout: Layout,
    free: Vec<usize>,
    priors: Vec<f64>,
    /// Of each pose, one value a free unknown and channel.
    of_pose: Vec<Vec<f64>>,
}

impl Rows {
    pub(super) fn new(question: &Question) -> Self {
        let model = ErrorModel::zero(TermTable::equation_9());
        let layout = Layout::new(&model).unwrap_or_default();
        let noise = ReadingNoise {
            segment_m: question.noise_m,
            displacement_m: question.noise_m,
        };
        let geometry = question.geometry;
        let constraints = Constraints {
            geometry,
            layout: layout.clone(),
            noise,
            stated_noise: noise,
            weighting: Weighting::Covariance,
        };
        let values = entered(&layout, &model, &geometry);
        let mut solver = Box::new(JointSolver::new());
        solver.set_priors(&constraints, &values, &Priors::default());
        let groups = groups(question);
        let free: Vec<usize> = layout.free(groups).iter().map(|&i| i.into()).collect();
        let channels = if question.motion.beacon { 3 } else { 1 };
        let of_pose = |pose| {
            let sample = foreseen_under_beacon(&constraints, &values, &poses::start(), &pose);
            let rows = constraints.rows(&values, &sample).jacobian;
            let picked = rows.into_iter().take(channels);
            picked
                .flat_map(|row| free.iter().map(|&i| f64::from(row[i])).collect::<Vec<_>>())
                .collect()
        };
        let visited = poses::visited(question, &constraints, &values, &mut solver, groups);
        Self {
            of_pose: visited.into_iter().map(of_pose).collect(),
            priors: free
                .iter()
                .map(|&i| solver.prior_deviation(i).into())
                .collect(),
            layout,
            free,
        }
    }

    /// Poses.
    pub(super) fn len(&self) -> usize {
        self.of_pose.len()
    }

    /// What no pose has told anything of yet.
    pub(super) fn before(&self) -> Problem {
        Problem {
            layout: self.layout.clone(),
            free: self.free.clone(),
            triangle: Triangle::new(self.priors.clone()),
        }
    }

    /// The same with those of some poses.
    pub(super) fn with(&self, problem: Problem, poses: Range<usize>) -> Problem {
        let rows = self.of_pose[poses].concat();
        let jacobian =
            DMatrix::from_row_slice(rows.len() / self.free.len(), self.free.len(), &rows);
        Problem {
            triangle: problem.triangle.with(&jacobian),
            ..problem
        }
    }
}

/// The triangle of a motion's rows.
pub(super) struct Problem {
    pub(super) layout: Layout,
    pub(super) free: Vec<usize>,
    pub(super) triangle: Triangle,
}

impl Problem {
    pub(super) fn new(question: &Question) -> Self {
        let rows = Rows::new(question);
        rows.with(rows.before(), 0..rows.len())
    }

    pub(super) fn parameters(&self) -> Vec<Parameter> {
        let triangle = &self.triangle;
        let (alone, with_prior) = (triangle.variances(), triangle.variances_with_priors());
        (0..self.free.len())
            .map(|column| {
                let unknown = self.layout.unknown(self.free[column]);
                let deviation_with_prior = with_prior[column].sqrt();
                let priors_own = deviation_with_prior > PRIORS_OWN * triangle.prior(column);
                Parameter {
                    name: unknown.to_string(),
                    unit: unit(unknown),
                    deviation: alone[column].is_finite().then(|| alone[column].sqrt()),
                    deviation_with_prior,
                    prior: triangle.prior(column),
                    rests_on: if priors_own { "prior" } else { "data" },
                }
            })
            .collect()
    }
}

fn groups(question: &Question) -> Groups {
    let platen = Groups::PLATEN | Groups::LATERAL;
    match (question.motion.beacon, question.sensor_terms) {
        (false, _) => platen,
        (true, false) => Groups::PAPER,
        (true, true) => Groups::PAPER | Groups::SENSOR,
    }
}

fn unit(unknown: Unknown) -> &'static str {
    match unknown {
        Unknown::Turn => "rad",
        Unknown::GainDifference | Unknown::Nonlinearity(..) => "1",
        _ => "m",
    }
}
