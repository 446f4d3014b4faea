//! Sums of products: of what is recorded, and with a motion that may follow.

use crate::given::Given;
use diagnosis::design::excitation::Excitation;
use nalgebra::DMatrix;
use normal_equations::symmetric::Symmetric;

/// Products over a recording and some paths, as if all had the recording's rate.
#[derive(Clone)]
pub struct Totals {
    sum: Symmetric,
}

impl Totals {
    /// Of the recording, of which one sample in `thinned` was looked at.
    pub fn new(excitation: &Excitation, thinned: f64) -> Self {
        let mut sum = Symmetric::zeros(excitation.names.len() + 1);
        add(&mut sum, &excitation.so_far.sum, thinned);
        Self { sum }
    }

    /// The same with a path behind it, of which each step stands for so many samples.
    #[must_use]
    pub fn with(mut self, excitation: &Excitation, path: usize, samples_a_step: f64) -> Self {
        add(&mut self.sum, &excitation.paths[path].sum, samples_a_step);
        self
    }

    /// Products of some columns beside others, which have their priors.
    pub fn given(&self, own: &[usize], others: &[usize]) -> Given {
        let mut left = self.sum.block(own, own);
        if others.is_empty() || own.is_empty() {
            return Given(left);
        }
        let mut precision = self.sum.block(others, others);
        for k in 0..others.len() {
            precision[(k, k)] += 1.0;
        }
        let across = self.sum.block(others, own);
        if let Some(factor) = precision.cholesky() {
            let half: DMatrix<f64> = factor
                .l_dirty()
                .lower_triangle()
                .solve_lower_triangular(&across)
                .unwrap_or(across);
            left.gemm_tr(-1.0, &half, &half, 1.0);
        }
        Given(left)
    }
}

fn add(sum: &mut Symmetric, part: &Symmetric, weight: f64) {
    for column in 0..sum.order() {
        let from = part.below(column);
        for (sum, value) in sum.below_mut(column).iter_mut().zip(from) {
            *sum += weight * value;
        }
    }
}
