//! What one stretch of motion tells of the angle's error: its phase is a cubic of time, less the error.

use super::harmonics::ORDERS;
use crate::lsq::{RowError, Triangle, packed_len};
use crate::model::Unit;

/// Unknowns of the motion: a cubic of time. A prior: over two periods a hand or a motor that keeps its torque for half of that
/// moves no otherwise; the fourth power is what a torque that changes twice would need.
pub const DRIFT: usize = 4;
/// Unknowns of the error: sine and cosine of each order.
pub const COLUMNS: usize = 2 * ORDERS;
const UNKNOWNS: usize = DRIFT + COLUMNS;
const PACKED: usize = packed_len(UNKNOWNS);

/// The rows of one stretch: `phase = cubic of time - error(phase)`. The motion's unknowns come first in the factor, so that what is below
/// them is what the stretch tells of the error whatever the motion was: [`Stretch::equation`].
#[derive(Clone, Debug)]
pub struct Stretch {
    triangle: Triangle<UNKNOWNS, PACKED>,
    orders: usize,
}

impl Stretch {
    /// Empty, with orders 1 to `orders` (at most 8).
    #[must_use]
    pub const fn new(orders: usize) -> Self {
        let orders = if orders < ORDERS { orders } else { ORDERS };
        Self {
            triangle: Triangle::new(DRIFT + 2 * orders),
            orders,
        }
    }

    /// Forgets all rows.
    pub fn reset(&mut self) {
        self.triangle.reset(DRIFT + self.columns());
    }

    /// Unknowns of the error: two an order.
    #[must_use]
    pub fn columns(&self) -> usize {
        2 * self.orders
    }

    /// Rows entered.
    #[must_use]
    pub fn rows(&self) -> u32 {
        self.triangle.rows()
    }

    /// Enters one sample: `time` within the stretch, best as -1 to 1; its place since the stretch's start, turns; its phase.
    ///
    /// # Errors
    /// A number that is not finite; nothing is changed.
    pub fn enter(&mut self, time: f32, place_turns: f32, phase: Unit) -> Result<(), RowError> {
        let mut row = [0.0; UNKNOWNS];
        let mut power = 1.0;
        for slot in &mut row[..DRIFT] {
            *slot = power;
            power *= time;
        }
        let mut multiple = Unit::ZERO;
        for pair in row[DRIFT..]
            .as_chunks_mut::<2>()
            .0
            .iter_mut()
            .take(self.orders)
        {
            multiple = multiple.plus(phase);
            *pair = [-multiple.sine, -multiple.cosine];
        }
        let row = &row[..DRIFT + self.columns()];
        self.triangle.enter(row, place_turns)?;
        Ok(())
    }

    /// What is left of the places, rms turns: noise, and motion that was no cubic. None without redundancy.
    #[must_use]
    pub fn noise_turns(&self) -> Option<f32> {
        let freedom = self.rows() as usize;
        let freedom = freedom
            .checked_sub(DRIFT + self.columns())
            .filter(|n| *n > 0)?;
        Some(self.triangle.residual_norm() / crate::math::sqrt(freedom as f32))
    }

    /// Equation `index` of [`Stretch::columns`] between the error's unknowns alone (sine, cosine of order 1, and so on): its row, of which
    /// the first `columns` count, and its right side, turns.
    #[must_use]
    pub fn equation(&self, index: usize) -> ([f32; COLUMNS], f32) {
        let mut row = [0.0; COLUMNS];
        for (column, slot) in row.iter_mut().enumerate().take(self.columns()) {
            *slot = self.triangle.entry(DRIFT + index, DRIFT + column);
        }
        (row, self.triangle.right_hand_side(DRIFT + index))
    }
}
