//! What is left of the normal equations beside a set.

use super::eliminated::Eliminated;
use super::reduced::{Common, Reduced, ranges};
use nalgebra::DVector;

impl Reduced {
    /// What is left of some blocks when the columns of a set are eliminated with their priors, at a variance of the
    /// noise. What the data tell of the set's columns is theirs, and shapes beside them explain the rest. The noise that
    /// the columns carry is not told of what is left. Cost: the square of the others' columns for each of the set's.
    pub fn beside(
        &self,
        set: &[usize],
        eliminated: &Eliminated,
        blocks: &[usize],
        noise: f64,
    ) -> Self {
        let (list, own) = (self.columns(set), self.columns(blocks));
        let (target, squares) = self.about_the_means(&list);
        // The set's means are taken off the target, the blocks' own are not.
        let mut across = self.across(&list, &own);
        let means = DVector::from_fn(list.len(), |k, _| self.centre[list[k]]);
        let right = DVector::from_fn(own.len(), |k, _| self.right[own[k]]) - across.tr_mul(&means);
        across = across.insert_column(own.len(), 0.0);
        across.set_column(own.len(), &target);
        let half = eliminated.half(&across) / noise.sqrt();
        let (across, target) = (half.columns(0, own.len()), half.column(own.len()));
        let mut normal = self.square(&own);
        normal.gemm(-1.0, &across.transpose(), &across, 1.0);
        Self {
            blocks: ranges(blocks.iter().map(|b| self.blocks[*b].len())),
            centre: DVector::from_fn(own.len(), |k, _| self.centre[own[k]]),
            carried: None,
            in_own_axes: set.is_empty() && self.in_own_axes,
            right: right - across.tr_mul(&target),
            squares: squares - target.norm_squared(),
            normal,
            // It is at its noise for good.
            common: Common {
                right: DVector::zeros(own.len()),
                squares: [0.0; 2],
            },
            ..*self
        }
    }
}
