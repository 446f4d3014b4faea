//! The catalogue of effects: one file each, with the plant side and the sensor side, which do not call each other.
//!
//! Adding an effect: one file and one line of [`CATALOGUE`]. `unlisted` holds effects that no diagnosis knows, for blind
//! tests of its answer `unknown`.

pub mod motion;
pub mod plant;
pub mod random;
pub mod shape;

pub mod lateral_dependence;

use plant::Draw;

/// One line of the catalogue.
pub struct Entry {
    /// Name, as in the diagnosis' output.
    pub name: &'static str,
    /// What it is.
    pub summary: &'static str,
    /// Draws the plant's side.
    pub draw: Draw,
}

/// Every catalogued effect.
pub const CATALOGUE: &[Entry] = &[Entry {
    name: "lateral_dependence",
    summary: "a segment's output depends on the tooth phase across it",
    draw: lateral_dependence::LateralDependence::draw,
}];

/// The catalogue's line of a name.
#[must_use]
pub fn entry(name: &str) -> Option<&'static Entry> {
    CATALOGUE.iter().find(|entry| entry.name == name)
}
