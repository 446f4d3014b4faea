//! What a model leaves on another recording of the same motion: each short piece predicted from all the others, exactly and
//! without fitting anew (Cook and Weisberg 1982, deletion of several cases at once).
//!
//! Effects are chosen on five coarse folds; what is claimed of those that were chosen is counted here. A fold of a fifth
//! takes out whole places of the platen, which another recording would not: its model has seen them all.

use crate::design::gram::{Columns, Gram};
use crate::inference::residuals::Residuals;
use crate::linearization::groups::{Group, Sample};
use crate::linearization::recording::{LinearizedRecording, ROWS, SampleRows};
use nalgebra::{DMatrix, DVector};
use normal_equations::cholesky::Factor;
use rayon::prelude::*;

/// Samples that are left out together. Derived from the windows over seven neighbours that motions are told by: in a piece of ten
/// the middle ones share none with what is fitted.
const PIECE_SAMPLES: usize = 10;

/// The rows of a piece in prior deviations, whitened; only columns that act within it.
struct Piece {
    samples: Vec<(usize, SampleRows)>,
    active: Vec<usize>,
    design: DMatrix<f64>,
    residual: DVector<f64>,
}

/// Residuals of the model with these columns, each piece of some samples predicted from all others. Cost: rows times the square
/// of the columns that act at a sample, and one inverse.
pub fn left_out(
    linearized: &LinearizedRecording,
    columns: &Columns,
    gram: &Gram,
) -> Option<Residuals> {
    let width = gram.width();
    let training = gram.training(None);
    let all: Vec<usize> = (0..width).collect();
    let mut normal = training.lower(&all);
    let mut right = training.right(&all);
    for c in 0..width {
        normal[(c, c)] += 1.0;
        right[c] += gram.centre[c];
    }
    let covariance = Factor::new(normal)?.inverse();
    let coefficients = &covariance * right;
    let one = |samples: &Vec<usize>| {
        let piece = Piece::new(linearized, columns, gram, samples);
        let white = piece.predicted(&covariance, &coefficients)?;
        let mut out = Residuals::default();
        piece.report(linearized, &white, &mut out);
        Some(out)
    };
    let parts: Option<Vec<Residuals>> = pieces(linearized).par_iter().map(one).collect();
    Some(Residuals::joined(&parts?))
}

/// Samples in use, in short pieces of one stretch.
fn pieces(linearized: &LinearizedRecording) -> Vec<Vec<usize>> {
    let stretch = &linearized.observations.stretch;
    let mut list: Vec<Vec<usize>> = Vec::new();
    for i in (0..linearized.len()).filter(|&i| linearized.mask[i]) {
        match list.last_mut() {
            Some(last) if last.len() < PIECE_SAMPLES && stretch[last[0]] == stretch[i] => {
                last.push(i)
            }
            _ => list.push(vec![i]),
        }
    }
    list
}

impl Piece {
    fn new(
        linearized: &LinearizedRecording,
        columns: &Columns,
        gram: &Gram,
        samples: &[usize],
    ) -> Self {
        let regressors = &columns.regressors;
        let asked = 0..regressors.len();
        let group = Group::new(linearized, regressors, asked, samples.iter().copied());
        let rows = group.samples.iter().map(|s| s.rows.count).sum();
        let mut residual = Vec::with_capacity(rows);
        for Sample { rows, .. } in &group.samples {
            residual.extend(&rows.whitened(&rows.residual_m)[..rows.count]);
        }
        // A column of the design after the other: those that do not act leave no trace.
        let (mut active, mut design) = (Vec::new(), Vec::new());
        for &c in &group.acting {
            let start = design.len();
            for Sample {
                rows, covariates, ..
            } in &group.samples
            {
                let white = rows.whitened(&rows.response(&regressors[c], covariates));
                design.extend(white[..rows.count].iter().map(|w| w * gram.scale[c]));
            }
            if design[start..].iter().any(|d| *d != 0.0) {
                active.push(c);
            } else {
                design.truncate(start);
            }
        }
        Self {
            design: DMatrix::from_vec(rows, active.len(), design),
            samples: group
                .samples
                .into_iter()
                .map(|s| (s.number, s.rows))
                .collect(),
            active,
            residual: DVector::from_vec(residual),
        }
    }

    /// Whitened residuals as a fit without this piece predicts them.
    fn predicted(
        &self,
        covariance: &DMatrix<f64>,
        coefficients: &DVector<f64>,
    ) -> Option<DVector<f64>> {
        // Samples of which no residual is formed, as under no beacon: nothing is left, and there is nothing to solve.
        if self.residual.is_empty() {
            return Some(DVector::zeros(0));
        }
        let a = &self.active;
        let fitted = DVector::from_fn(a.len(), |k, _| coefficients[a[k]]);
        let spread = DMatrix::from_fn(a.len(), a.len(), |r, c| covariance[(a[r], a[c])]);
        let rows = self.residual.len();
        let leverage = &self.design * spread * self.design.transpose();
        let left = &self.residual + &self.design * fitted;
        (DMatrix::identity(rows, rows) - leverage).lu().solve(&left)
    }

    fn report(&self, linearized: &LinearizedRecording, white: &DVector<f64>, out: &mut Residuals) {
        let mut at = 0;
        for (i, rows) in &self.samples {
            let mut own = [0.0; ROWS];
            for (row, value) in own.iter_mut().enumerate().take(rows.count) {
                *value = white[at + row];
            }
            out.push(linearized, *i, rows, &rows.coloured(&own));
            at += rows.count;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_piece_without_a_residual_leaves_none() {
        let piece = Piece {
            samples: Vec::new(),
            active: Vec::new(),
            design: DMatrix::zeros(0, 0),
            residual: DVector::zeros(0),
        };
        let left = piece.predicted(&DMatrix::identity(3, 3), &DVector::zeros(3));
        assert_eq!(left.map(|left| left.len()), Some(0));
    }
}
