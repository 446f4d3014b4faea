//! What an unknown is, by name: sums of different recordings are put together by it.

use serde::{Deserialize, Serialize};
use std::fmt;

/// Name of a courier or of a recording.
pub type Name = String;

/// A platen under a beacon: another beacon's place over the teeth is not known, so its recordings stand by themselves.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Platen {
    /// The platen's name.
    pub platen_id: Name,
    /// The beacon's name; may be empty.
    pub beacon_id: Name,
}

impl fmt::Display for Platen {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.beacon_id.as_str() {
            "" => write!(f, "{}", self.platen_id),
            beacon => write!(f, "{} under {beacon}", self.platen_id),
        }
    }
}

/// One unknown of a platen's problem. Those of couriers and of the aperture come last: they are shared with other platens.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Key {
    /// Displacement of a node of a field, m: direction 0 (x) or 1 (y), teeth along and across it.
    Node(u8, [i32; 2]),
    /// The same of a whole line of nodes.
    Line(u8, i32),
    /// Shape of the rulings, see [`Ruling`].
    Ruling(Ruling),
    /// Unknown of a recording, by its number: offsets of parity and angle, the beacon's height and its place along x and y.
    Recording(Name, u16),
    /// Unknown of a courier, by its number among the tooth map's unknowns, or [`SPAN`], [`SPANS_APART`],
    /// [`DIODE_SHEAR`].
    Courier(Name, u16),
    /// The aperture of the make's segments, by the number of its coordinate (`neighbours.rs`). The bound has it among its unknowns; a fit takes it
    /// from the evidence.
    Aperture(u8),
}

impl Key {
    /// The courier that it belongs to.
    #[must_use]
    pub fn courier(&self) -> Option<&str> {
        match self {
            Self::Courier(courier, _) => Some(courier),
            _ => None,
        }
    }

    /// True if other platens share it.
    #[must_use]
    pub fn is_shared(&self) -> bool {
        matches!(self, Self::Courier(..) | Self::Aperture(_))
    }
}

/// How a platen's two rulings differ from two equal ones at right angles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Ruling {
    /// Pitch of x over that of y, less one.
    PitchDifference,
    /// Angle by which the lines of x are turned toward +x: along them, x grows by it with y, rad.
    OutOfSquare,
    /// How lines of x bend along y, 1/m: the displacement over the squared place.
    BowOfX,
    /// How lines of y bend along x, 1/m.
    BowOfY,
}

/// All of them, in the order of [`tooth_map::Rulings::amounts`].
pub const RULINGS: [Key; 4] = [
    Key::Ruling(Ruling::PitchDifference),
    Key::Ruling(Ruling::OutOfSquare),
    Key::Ruling(Ruling::BowOfX),
    Key::Ruling(Ruling::BowOfY),
];

/// By how much the axes of a courier's diode meet at less than a right angle, half of it, rad. By definition a number
/// that no unknown of the tooth map has.
pub const DIODE_SHEAR: u16 = u16::MAX - 2;
/// What both spans of a courier are longer by than stated, m. By definition a number that no unknown of
/// the tooth map has.
pub const SPAN: u16 = u16::MAX - 1;
/// What the span of segments 1 and 3 is longer by than that of 2 and 4, m. By definition a number that no unknown of
/// the tooth map has.
pub const SPANS_APART: u16 = u16::MAX;
