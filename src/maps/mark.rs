//! Whole teeth by a reference mark or an end stop: a place to which a motion controller brings the courier again and again, within a quarter
//! of a tooth.
//!
//! Where the mark lies in a map's count is learned once, with the map in force ([`place`]). A host that speaks with the motion controller
//! may keep it, and say at a later start that the courier stands there ([`ahead`]); or the board has an input for the mark, keeps the place
//! where it switches on, and needs no host (`super::crossing`). The mark is a place of the courier's middle: it is to be
//! turned there as it was, since a turn by 0.1° moves a switch that is 50 mm off the middle by 0.09 mm.

use super::homing::{Unusable, is_doubtful, moved};
use crate::calibration::rest_watch::FASTEST_M_S;
use crate::frame::{Coordinate, Frame};
use serde::{Deserialize, Serialize};

const ZERO: Coordinate = Coordinate {
    teeth: 0,
    fraction_turns: 0.0,
};

/// Why a map was not put in force by a mark.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
pub enum MarkRefusal {
    /// There is no map that counts.
    #[error("map slot {0} holds no map that counts")]
    NoMap(u8),
    /// It was made with another calibration.
    #[error("the map in slot {0} belongs to another calibration than the one in force")]
    OtherCalibration(u8),
    /// A map is in force: what it counts by is known.
    #[error("a tooth map is in force already")]
    InForce,
    /// The frame tells nothing of the place.
    #[error("the mark waits for {0}")]
    Unusable(Unusable),
    /// More than a quarter of a tooth is left.
    #[error(
        "the board counts {:.2}, {:.2} teeth ahead of the mark's place, wanted whole numbers within {}: the mark was moved, or it is another one",
        turns(.ahead[0]), turns(.ahead[1]), super::homing::MOST_LEFT_TURNS
    )]
    NotWhole {
        /// Along x and y.
        ahead: [Coordinate; 2],
    },
    /// A mark is learned in the count of a stored map that its beacon, or its mark, has put in force.
    #[error("no stored tooth map is in force: the mark is learned in its count")]
    NotInForce,
    /// The mark's input has not switched on since the start, or since the count was doubtful.
    #[error(
        "the mark's input has not been crossed: at 10 mm/s at most, from off to on, and on for 10 ms"
    )]
    NotCrossed,
    /// There is no room for the place beside the map, or the flash does not take it.
    #[error(
        "the mark's place is not kept: there is room for 17 beside a map, or the flash does not take it"
    )]
    NotKept,
}

/// A place in pitches, for people.
fn turns(place: Coordinate) -> f64 {
    f64::from(place.teeth) + f64::from(place.fraction_turns)
}

/// What a board counts at the mark, less the mark's place in the map's count, along x and y; the fraction is within ±0.5.
///
/// # Errors
/// [`MarkRefusal::Unusable`] if the count is doubtful or the courier is not at rest.
pub fn ahead(frame: &Frame, mark: &[Coordinate; 2]) -> Result<[Coordinate; 2], MarkRefusal> {
    if is_doubtful(frame) {
        return Err(MarkRefusal::Unusable(Unusable::Doubtful));
    }
    if !is_slow(frame) {
        return Err(MarkRefusal::Unusable(Unusable::TooFast));
    }
    Ok(ahead_at(&[frame.pose.x, frame.pose.y], mark))
}

/// What the board counts at a place, less the mark's place in the map's count, along x and y; the fraction is within ±0.5.
#[must_use]
pub fn ahead_at(counted: &[Coordinate; 2], mark: &[Coordinate; 2]) -> [Coordinate; 2] {
    [0, 1].map(|axis| moved(counted[axis], ZERO, mark[axis]))
}

/// Whether the courier is slow enough for a place to be told.
pub(super) fn is_slow(frame: &Frame) -> bool {
    // Not a number fails as well.
    let mut speeds = frame.speed_m_s.iter();
    speeds.all(|speed_m_s| speed_m_s.abs() <= FASTEST_M_S)
}

/// The mark's place in the map's count, from where the board counts it while it is `ahead` of the map.
#[must_use]
pub fn place(counted: [Coordinate; 2], ahead: [Coordinate; 2]) -> [Coordinate; 2] {
    [0, 1].map(|axis| Coordinate {
        teeth: counted[axis].teeth.wrapping_sub(ahead[axis].teeth),
        ..counted[axis]
    })
}
