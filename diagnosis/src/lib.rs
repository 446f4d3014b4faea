//! Where the simulation and the real sensor part, which effect does it, and how far adding it closes the gap.
//!
//! The input is a [`recording::Recording`], read from a folder or filled by the caller; [`diagnose`] never fails: what the
//! recording cannot answer is [`Verdict::InsufficientData`] with the limit and both numbers. [`diagnose_fully`] adds the model
//! for [`check`] on another recording, and the residuals and evidence that a report draws.
//!
//! # Other sensors
//!
//! What is compared are redundant readings, not this courier's: one sensor with a periodic output beside any reference is a
//! recording, and so are four with or without the coordination sensor. A resolver with one turn a period is a segment whose
//! pitch is the length that one turn is written as:
//!
//! ```
//! use diagnosis::{Options, Verdict, diagnose};
//! use recording::{Electronics, Geometry, Meta, Recording, Row, Samples};
//!
//! let pitch_m = 1.0e-3; // one turn of the shaft
//! let mut samples = Samples::default();
//! let mut noise = 1_u32;
//! for k in 0..4000 {
//!     let t_s = f64::from(k) * 1.0e-3;
//!     let reference_m = 5.0 * pitch_m * (1.0 - (1.3 * t_s).cos()); // to and fro, at every speed
//!     let phase = std::f64::consts::TAU * reference_m / pitch_m;
//!     noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
//!     let noise_m = (f64::from(noise) / f64::from(u32::MAX) - 0.5) * 12.0_f64.sqrt() * 0.1e-6;
//!     let eccentric_m = 3.0e-6 * phase.sin(); // within equation (3): calibrated away
//!     let lag_m = 50.0e-6 * 6.5 * pitch_m * (1.3 * t_s).sin(); // the output is 50 µs late: a gap
//!     samples.push(&Row {
//!         t_s,
//!         run: "sweep",
//!         position_m: [Some(reference_m + eccentric_m - lag_m + noise_m), None, None, None],
//!         reference: [Some(reference_m), None, None],
//!         ..Row::default()
//!     });
//! }
//! let recording = Recording {
//!     meta: Meta {
//!         geometry: Geometry { pitch_m, ..Geometry::default() },
//!         electronics: Electronics { position_noise_m: Some(0.1e-6), ..Electronics::default() },
//!         ..Meta::default()
//!     },
//!     samples,
//!     warnings: Vec::new(),
//! };
//! let answer = diagnose(&recording, "resolver", &Options::default());
//! assert_eq!(answer.verdict, Verdict::Named);
//! assert_eq!(answer.effects[0].name, "velocity_lag");
//! ```
//!
//! # Order of the work
//!
//! The modules stand in the order of the data. [`data`] reads, repairs and marks; [`linearization`] has the residuals of a recording
//! about a point, their derivatives and the baseline; [`spectra`] finds lines in what is left, [`noise`] is what the stated noise alone leaves;
//! [`design`] lays out the columns of the baseline, of every effect of the catalogue and of shapes over the coordinates, with their
//! products fold by fold; [`inference`] fits them; [`posterior`] tells how probable each set of effects is, and decides;
//! [`figures`] has the figures of what was decided;
//! [`verdict`] is the answer's data, and [`link`] states the probability of what is named; [`transfer`] writes the model and checks it on another recording. [`algebra`] knows no sensor.
//!
//! Telling an answer to a reader, and checking the whole on couriers whose effects are withheld, are crates of their own:
//! `report` and `blind`.

// In the order of the data: blank lines keep it so.
pub mod algebra;

pub mod data;

pub mod hypothesis;

pub mod linearization;

pub mod spectra;

pub mod noise;

pub mod design;

pub mod inference;

pub mod posterior;

pub mod figures;

pub mod verdict;

pub mod link;

pub mod transfer;

pub mod progress;
#[cfg(test)]
mod synthetic_problem;
pub mod trace;

pub use data::faint::WithoutSignal;
pub use design::assembly::Options;
pub use figures::{Answer, diagnose, diagnose_fully, diagnose_watched};
pub use transfer::check::{Check, Checked, check, check_fully, check_watched};
pub use transfer::model::Model;
pub use verdict::answer::{Diagnosis, HeldOut, Verdict};

/// The recording cannot answer: the limit that it violates, and both numbers.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{quantity}: {}, at least {} wanted{}", with_unit(*found, unit), with_unit(*wanted, unit), lacks(motions))]
pub struct Insufficient {
    /// What is too little.
    pub quantity: String,
    /// What there is.
    pub found: f64,
    /// What would be needed.
    pub wanted: f64,
    /// Unit of both.
    pub unit: String,
    /// What is to be recorded besides, where motion is what lacks.
    pub motions: Vec<String>,
}

/// The motions as the end of a sentence.
fn lacks(motions: &[String]) -> String {
    if motions.is_empty() {
        return String::new();
    }
    format!("; what lacks: {}", motions.join("; "))
}

impl Insufficient {
    /// From its parts.
    pub fn new(quantity: &str, found: f64, wanted: f64, unit: &str) -> Self {
        Self {
            quantity: quantity.into(),
            found,
            wanted,
            unit: unit.into(),
            motions: Vec::new(),
        }
    }

    /// The same with what is to be recorded besides.
    #[must_use]
    pub fn lacking(self, motions: Vec<String>) -> Self {
        Self { motions, ..self }
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
