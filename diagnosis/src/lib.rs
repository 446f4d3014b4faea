//! Where the simulation and the real sensor part, which effect does it, and how far adding it closes the gap.

pub mod adequacy;
pub mod advice;
pub mod arena;
pub mod baseline;
pub mod blind;
mod bootstrap;
pub mod calibrate;
pub mod carried;
pub mod channels;
pub mod clean;
pub mod clip;
pub mod diagnose;
pub mod evidence;
pub mod fourier;
pub mod gram;
pub mod heldout;
pub mod hollow;
pub mod html;
pub mod hum;
pub mod judge;
pub mod leftout;
pub mod lines;
pub mod model;
pub mod motion;
pub mod nodes;
pub mod observe;
pub mod phase;
pub mod places;
mod products;
pub mod refine;
pub mod relevance;
pub mod report;
pub mod scene;
pub mod search;
pub mod shared;
pub mod simulate;
pub mod slips;
pub mod smooth;
pub mod statistics;
pub mod thinning;
pub mod travel;
pub mod visited;

pub use diagnose::Options;
pub use judge::{Answer, diagnose, diagnose_fully};
pub use model::{Check, Checked, Model, check, check_fully};
pub use report::{Diagnosis, HeldOut, Verdict};

/// The recording cannot answer: the limit that it violates, and both numbers.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{quantity}: {}, at least {} wanted", with_unit(*found, unit), with_unit(*wanted, unit))]
pub struct Insufficient {
    /// What is too little.
    pub quantity: String,
    /// What there is.
    pub found: f64,
    /// What would be needed.
    pub wanted: f64,
    /// Unit of both.
    pub unit: String,
}

impl Insufficient {
    /// From its parts.
    pub fn new(quantity: &str, found: f64, wanted: f64, unit: &str) -> Self {
        Self {
            quantity: quantity.into(),
            found,
            wanted,
            unit: unit.into(),
        }
    }
}

/// A number in at most four digits with its unit, if it has one.
fn with_unit(value: f64, unit: &str) -> String {
    let number = if value.fract() == 0.0 {
        format!("{value}")
    } else {
        format!("{value:.3}")
    };
    format!("{number} {unit}").trim_end().into()
}
