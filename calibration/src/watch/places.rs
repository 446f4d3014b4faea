//! Where a change may be: a segment and an order of equation (3).

use crate::equations::OWN_ORDERS;
use crate::frame::SEGMENTS;
use serde::{Deserialize, Serialize};

/// Segments times orders.
pub const PLACES: usize = SEGMENTS * OWN_ORDERS.len();
/// A segment and an order of equation (3).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Place(u8);

impl Place {
    /// Segment 1's order 1.
    pub(super) const FIRST: Self = Self(0);

    /// The place of a number; none of one that there is not.
    pub(super) fn from_index(index: u8) -> Option<Self> {
        (usize::from(index) < PLACES).then_some(Self(index))
    }

    /// All, in their order.
    pub fn all() -> impl Iterator<Item = Self> {
        (0..PLACES as u8).map(Self)
    }

    /// The place of a segment, 0 to 3, and an order of equation (3); none of another.
    #[must_use]
    pub fn of(segment: usize, order: u8) -> Option<Self> {
        let index = OWN_ORDERS.iter().position(|known| *known == order)?;
        (segment < SEGMENTS).then_some(Self((segment * OWN_ORDERS.len() + index) as u8))
    }

    /// Its number, and that of its pair of columns: segment by segment, order by order.
    pub(super) const fn index(self) -> usize {
        self.0 as usize
    }

    /// Its bit in a set of places.
    pub(super) const fn bit(self) -> u16 {
        1 << (self.0 % PLACES as u8)
    }

    /// The same order of the other segment of the pair.
    pub(super) const fn other(self) -> Self {
        Self((self.0 + PLACES as u8 / 2) % PLACES as u8)
    }

    /// Segment, 0 to 3.
    #[must_use]
    pub const fn segment(self) -> usize {
        self.0 as usize / OWN_ORDERS.len() % SEGMENTS
    }

    /// Order of its own phase.
    #[must_use]
    pub const fn order(self) -> u8 {
        OWN_ORDERS[self.0 as usize % OWN_ORDERS.len()]
    }
}
