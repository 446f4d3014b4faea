//! The geometry that a board reckons with.

use super::Link;
use courier_sensor::geometry::Geometry;
use courier_sensor::link::message::{Action, Reply, Source};

/// The geometry of the calibration in force; `None` without one: the board then has its firmware's nominal geometry, which is
/// [`Geometry::PAPER`] and is not told over the link.
pub fn in_force(link: &mut Link) -> Option<Geometry> {
    match link.ask(Action::Read(Source::InForce)) {
        Ok(Reply::Calibration(calibration)) => Some(calibration.geometry),
        _ => None,
    }
}
