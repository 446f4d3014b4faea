//! What one half of the stretches says of the orders of the turn.

use crate::lsq::Triangle;
use crate::model::Unit;

/// Unknowns of the motion in each stretch: a quintic of time. A prior: a shaft that is spun by hand and coasts, or is driven, keeps to it
/// over two turns.
pub const TURN_DRIFT: usize = 6;
/// Weight of what is held of every order before any row: that it is zero, as a row of three times the noise says it. A prior: it decides only
/// where a motion's polynomial can do the same, and makes nothing up there; an order that a hundred rows tell it makes less by a thousandth.
const PRIOR: f32 = 0.3;

/// Rows of `place = quintic of time - error`: the motion's unknowns come first, so that what is below them is what all stretches say of the
/// error, whatever the motion was in each.
#[derive(Clone, Debug)]
pub(super) struct Half<const UNKNOWNS: usize, const PACKED: usize> {
    pub(super) factor: Triangle<UNKNOWNS, PACKED>,
    /// Without those of [`PRIOR`].
    pub(super) rows: u32,
    /// Way of all stretches, periods.
    pub(super) way: f32,
}

impl<const UNKNOWNS: usize, const PACKED: usize> Half<UNKNOWNS, PACKED> {
    pub(super) const fn new() -> Self {
        Self {
            factor: Triangle::new(UNKNOWNS),
            rows: 0,
            way: 0.0,
        }
    }

    /// Empty but for what is held of every order before a row speaks of it.
    fn begin(&mut self) {
        self.factor.reset(UNKNOWNS);
        self.rows = 0;
        self.way = 0.0;
        for unknown in TURN_DRIFT..UNKNOWNS {
            let mut row = [0.0; UNKNOWNS];
            row[unknown] = PRIOR;
            // Refused is only what is not finite.
            let _ = self.factor.enter(&row, 0.0);
        }
    }

    /// Enters a row: time within the stretch, place since its beginning, periods, and the angle of the turn.
    pub(super) fn enter(&mut self, time: f32, place: f32, angle: Unit) {
        if self.rows == 0 {
            self.begin();
        }
        let mut row = [0.0; UNKNOWNS];
        let (drift, orders) = row.split_at_mut(TURN_DRIFT);
        let mut power = 1.0;
        for slot in drift {
            *slot = power;
            power *= time;
        }
        let mut multiple = Unit::ZERO;
        for pair in orders.as_chunks_mut::<2>().0 {
            multiple = multiple.plus(angle);
            *pair = [-multiple.sine, -multiple.cosine];
        }
        if self.factor.enter(&row, place).is_ok() {
            self.rows = self.rows.saturating_add(1);
        }
    }

    /// Takes over what another says of the error, and leaves that empty.
    pub(super) fn take(&mut self, other: &mut Self) {
        self.factor.release(TURN_DRIFT);
        for index in TURN_DRIFT..UNKNOWNS {
            let mut row = [0.0; UNKNOWNS];
            for (column, slot) in row.iter_mut().enumerate().skip(index) {
                *slot = other.factor.entry(index, column);
            }
            let _ = self.factor.enter(&row, other.factor.right_hand_side(index));
        }
        self.rows = self.rows.saturating_add(other.rows);
        self.way += other.way;
        // Its next row begins it anew.
        (other.rows, other.way) = (0, 0.0);
    }
}
