//! What a model leaves on another recording of the same motion: each short piece predicted from all the others, exactly and
//! without fitting anew (Cook and Weisberg 1982, deletion of several cases at once).
//!
//! Effects are chosen on five coarse folds; what is claimed of those that were chosen is counted here. A fold of a fifth
//! takes out whole places of the platen, which another recording would not: its model has seen them all.

use crate::factor::Factor;
use crate::gram::{Columns, Gram};
use crate::heldout::Residuals;
use crate::scene::{ROWS, SampleRows, Scene};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Samples that are left out together.
const PIECE: usize = 10;

/// The rows of a piece in prior deviations, whitened; only columns that act within it.
struct Piece {
    samples: Vec<(usize, SampleRows)>,
    active: Vec<usize>,
    design: DMatrix<f64>,
    residual: DVector<f64>,
}

/// Residuals of the model with these columns, each piece of some samples predicted from all others. Cost: rows times the square
/// of the columns that act at a sample, and one inverse.
pub fn left_out(scene: &Scene, columns: &Columns, gram: &Gram) -> Option<Residuals> {
    let width = gram.width();
    let training = gram.training(None);
    let all: Vec<usize> = (0..width).collect();
    let mut normal = training.square(&all);
    let mut right = training.right(&all);
    for c in 0..width {
        normal[(c, c)] += 1.0;
        right[c] += gram.centre[c];
    }
    let covariance = Factor::new(normal)?.inverse();
    let amounts = &covariance * right;
    let one = |samples: &Vec<usize>| {
        let piece = Piece::new(scene, columns, gram, samples);
        let white = piece.predicted(&covariance, &amounts)?;
        let mut out = Residuals::default();
        piece.report(scene, &white, &mut out);
        Some(out)
    };
    let parts: Option<Vec<Residuals>> = pieces(scene).par_iter().map(one).collect();
    Some(Residuals::joined(&parts?))
}

/// Samples in use, in short pieces of one stretch.
fn pieces(scene: &Scene) -> Vec<Vec<usize>> {
    let stretch = &scene.observations.stretch;
    let mut list: Vec<Vec<usize>> = Vec::new();
    for i in (0..scene.len()).filter(|&i| scene.keep[i]) {
        match list.last_mut() {
            Some(last) if last.len() < PIECE && stretch[last[0]] == stretch[i] => last.push(i),
            _ => list.push(vec![i]),
        }
    }
    list
}

impl Piece {
    fn new(scene: &Scene, columns: &Columns, gram: &Gram, samples: &[usize]) -> Self {
        let width = columns.regressors.len();
        let mut whole = DMatrix::zeros(samples.len() * ROWS, width);
        let mut residual = Vec::new();
        let mut used = vec![false; width];
        let mut list = Vec::new();
        for &i in samples {
            let rows = scene.rows(i);
            let moment = scene.moment(i);
            for (c, regressor) in columns.regressors.iter().enumerate() {
                let response = rows.response(regressor, &moment);
                if response.iter().any(|r| *r != 0.0) {
                    used[c] = true;
                    let white = rows.whitened(&response);
                    for row in 0..rows.count {
                        whole[(residual.len() + row, c)] = white[row] * gram.scale[c];
                    }
                }
            }
            residual.extend(&rows.whitened(&rows.residual_m)[..rows.count]);
            list.push((i, rows));
        }
        let active: Vec<usize> = (0..width).filter(|c| used[*c]).collect();
        let design = DMatrix::from_fn(residual.len(), active.len(), |r, k| whole[(r, active[k])]);
        Self {
            samples: list,
            active,
            design,
            residual: DVector::from_vec(residual),
        }
    }

    /// Whitened residuals as a fit without this piece predicts them.
    fn predicted(&self, covariance: &DMatrix<f64>, amounts: &DVector<f64>) -> Option<DVector<f64>> {
        let a = &self.active;
        let fitted = DVector::from_fn(a.len(), |k, _| amounts[a[k]]);
        let spread = DMatrix::from_fn(a.len(), a.len(), |r, c| covariance[(a[r], a[c])]);
        let rows = self.residual.len();
        let leverage = &self.design * spread * self.design.transpose();
        let left = &self.residual + &self.design * fitted;
        (DMatrix::identity(rows, rows) - leverage).lu().solve(&left)
    }

    fn report(&self, scene: &Scene, white: &DVector<f64>, out: &mut Residuals) {
        let mut at = 0;
        for (i, rows) in &self.samples {
            let mut own = [0.0; ROWS];
            for (row, value) in own.iter_mut().enumerate().take(rows.count) {
                *value = white[at + row];
            }
            out.push(scene, *i, rows, &rows.coloured(&own));
            at += rows.count;
        }
    }
}
