//! What rulings that are not two equal ones at right angles add to a segment's output.

use crate::key::{Key, Ruling};

/// The unknowns, in the order of [`tooth_map::Rulings::amounts`].
pub const RULINGS: [Key; 4] = [
    Key::Ruling(Ruling::PitchDifference),
    Key::Ruling(Ruling::OutOfSquare),
    Key::Ruling(Ruling::BowOfX),
    Key::Ruling(Ruling::BowOfY),
];
