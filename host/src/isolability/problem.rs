//! The triangle of a motion's rows, and what it says of each unknown.

use super::poses;
use super::question::Question;
use courier_sensor::calibration::joint::{
    Constraints, Groups, JointSolver, Layout, Priors, ReadingNoise, Unknown, Weighting, entered,
    foreseen_under_beacon,
};
use courier_sensor::model::{ErrorModel, TermTable};
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

/// Singular values below this share of the largest, columns equally long, are nothing: the rows are of f32.
pub(super) const UNDETERMINED: f64 = 1.0e-5;
/// A column that moves all poses together by less than this many deviations, the unknown off by its prior's, is rounding.
const UNFELT: f64 = 1.0e-2;
/// An unknown whose deviation is above this share of its prior's is the prior's.
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

/// The triangle of a motion's rows.
pub(super) struct Problem {
    pub(super) layout: Layout,
    pub(super) free: Vec<usize>,
    /// Columns equally long.
    pub(super) triangle: DMatrix<f64>,
    lengths: Vec<f64>,
    priors: Vec<f64>,
}

impl Problem {
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
        let rows = poses::visited(question, &constraints, &values, &mut solver, groups)
            .into_iter()
            .flat_map(|pose| {
                let sample = foreseen_under_beacon(&constraints, &values, &poses::start(), &pose);
                constraints
                    .rows(&values, &sample)
                    .jacobian
                    .into_iter()
                    .take(channels)
            })
            .flat_map(|row| free.iter().map(|&i| f64::from(row[i])).collect::<Vec<_>>())
            .collect::<Vec<f64>>();
        let jacobian = DMatrix::from_row_slice(rows.len() / free.len(), free.len(), &rows);
        let mut triangle = jacobian.qr().unpack_r();
        let priors: Vec<f64> = free
            .iter()
            .map(|&i| f64::from(solver.prior_deviation(i)))
            .collect();
        let mut lengths: Vec<f64> = triangle.column_iter().map(|c| c.norm()).collect();
        for ((mut column, length), prior) in
            triangle.column_iter_mut().zip(&mut lengths).zip(&priors)
        {
            if *length * prior < UNFELT {
                column.fill(0.0);
                *length = 1.0;
            } else {
                column /= *length;
            }
        }
        Self {
            layout,
            free,
            triangle,
            lengths,
            priors,
        }
    }

    /// Condition number, columns equally long, where all is determined; and how many directions are not.
    pub(super) fn condition(&self) -> (Option<f64>, usize) {
        let singular = self.triangle.clone().singular_values();
        let largest = singular.max();
        let undetermined_directions = self.free.len()
            - singular
                .iter()
                .filter(|&&s| s > UNDETERMINED * largest)
                .count();
        let number = (undetermined_directions == 0).then(|| largest / singular.min());
        (number, undetermined_directions)
    }

    /// Predicted variances by the poses alone, infinite where undetermined.
    pub(super) fn variances(&self) -> Vec<f64> {
        let svd = self.triangle.clone().svd(false, true);
        let Some(right) = svd.v_t else {
            return vec![f64::INFINITY; self.free.len()];
        };
        let largest = svd.singular_values.max();
        (0..self.free.len())
            .map(|column| {
                let parts = svd.singular_values.iter().enumerate().map(|(k, s)| {
                    let share = right[(k, column)].powi(2);
                    if *s > UNDETERMINED * largest {
                        share / (s * s)
                    } else if share > 1.0e-8 {
                        f64::INFINITY
                    } else {
                        0.0
                    }
                });
                parts.sum::<f64>() / self.lengths[column].powi(2)
            })
            .collect()
    }

    fn variances_with_priors(&self) -> Vec<f64> {
        let n = self.free.len();
        let mut stacked = DMatrix::zeros(2 * n, n);
        stacked
            .view_mut((0, 0), (self.triangle.nrows(), n))
            .copy_from(&self.triangle);
        for i in 0..n {
            stacked[(n + i, i)] = 1.0 / (self.priors[i] * self.lengths[i]);
        }
        let triangle = stacked.qr().unpack_r();
        (0..n)
            .map(|column| {
                let unit = DVector::from_fn(n, |i, _| {
                    if i == column {
                        1.0 / self.lengths[i]
                    } else {
                        0.0
                    }
                });
                triangle
                    .tr_solve_upper_triangular(&unit)
                    .map_or(f64::INFINITY, |v| v.norm_squared())
            })
            .collect()
    }

    pub(super) fn parameters(&self) -> Vec<Parameter> {
        let (alone, with_prior) = (self.variances(), self.variances_with_priors());
        (0..self.free.len())
            .map(|column| {
                let unknown = self.layout.unknown(self.free[column]);
                let deviation_with_prior = with_prior[column].sqrt();
                let priors_own = deviation_with_prior > PRIORS_OWN * self.priors[column];
                Parameter {
                    name: unknown.to_string(),
                    unit: unit(unknown),
                    deviation: alone[column].is_finite().then(|| alone[column].sqrt()),
                    deviation_with_prior,
                    prior: self.priors[column],
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
