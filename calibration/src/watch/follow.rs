//! What a complete window hands on to who learns from the same readings.

use super::row::OWN_COLUMNS;
use super::window::Window;
use crate::math::sqrt;

/// Amounts of equation (3): sine and cosine of each order of each segment, segment by segment.
pub type Amounts = [f32; OWN_COLUMNS];
/// How many.
pub const AMOUNTS: usize = OWN_COLUMNS;

/// Who learns from the windows beside the watch.
pub trait Follower {
    /// A window is complete. Its reference knows all places and tells them apart, or is worth nothing. Whether all cells are to be new again.
    fn window(&mut self, window: &Whole<'_>) -> bool;
    /// The reference is another one, or the outputs are: what came before does not count any more.
    fn forget(&mut self);
}

/// Nobody.
impl Follower for () {
    fn window(&mut self, _: &Whole<'_>) -> bool {
        false
    }

    fn forget(&mut self) {}
}

/// A complete window, as rows of a regression of the calibrated outputs' errors.
#[derive(Debug)]
pub struct Whole<'w> {
    pub(super) rows: &'w Window,
    pub(super) reference_m: &'w Amounts,
    pub(super) variance: f32,
    pub(super) reference_variance: f32,
}

impl Whole<'_> {
    /// Row `i` of [`AMOUNTS`], all that the window tells of equation (3): `row * amounts = rhs`, of unit variance; 1/m and 1. What other
    /// columns tell alike is taken out.
    #[must_use]
    pub fn row(&self, i: usize) -> (Amounts, f32) {
        let by = 1.0 / sqrt(self.variance);
        let row = self.rows.own_row(i).map(|entry| by * entry);
        (row, by * self.rows.own_right_hand_side(i))
    }

    /// What the calibration left, by the reference, metres.
    #[must_use]
    pub fn reference_m(&self) -> &Amounts {
        self.reference_m
    }

    /// How many times as much a row of the reference tells as one of this window: what changes leave that equation (3) does not hold is
    /// scatter now, and was none then. Zero where there is no reference that could be compared with.
    #[must_use]
    pub fn reference_worth(&self) -> f32 {
        self.variance / self.reference_variance
    }

    /// Its pairs of readings.
    #[must_use]
    pub fn pairs(&self) -> u32 {
        self.rows.taken()
    }

    /// How far the courier has turned within it: variance of the difference of the phases of a pair's segments, turns squared, as both pairs
    /// have it in common; below zero by chance where it has not turned.
    #[must_use]
    pub fn turning(&self) -> f32 {
        self.rows.turning()
    }

    /// Those of them that were taken where no pair had been since all cells were new.
    #[must_use]
    pub fn fresh_pairs(&self) -> u32 {
        self.rows.fresh()
    }
}
