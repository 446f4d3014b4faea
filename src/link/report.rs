//! What a calibration session tells a host: how far it is, and how the last one ended.

use crate::calibration::joint::StepReport;
use crate::calibration::record::Method;
use crate::calibration::slots::Place;
use crate::calibration::{Evidence, Refusal, Stage};
use serde::{Deserialize, Serialize};

/// State of the session that runs, or ran last.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    /// What it rests on.
    pub method: Method,
    /// What it is at.
    pub stage: Stage,
    /// Poses, or steps of the joint schedule, done in this stage.
    pub done: u32,
    /// How many there are.
    pub of: u32,
    /// Poses lost so far.
    pub lost: u32,
    /// Worst predicted standard deviation of a calibrated position so far, metres; infinite at first.
    pub worst_deviation_m: f32,
    /// Steps of a joint calibration's schedule that were made so far, each accepted or reverted by itself.
    pub steps: [Option<StepReport>; 5],
    /// How it ended, if it has.
    pub ending: Option<Ending>,
}

/// How a session ended.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Ending {
    /// Its result is in force.
    Accepted {
        /// Why it is believed.
        evidence: Evidence,
        /// Where it is stored, if that was ordered and done.
        stored: Option<Place>,
    },
    /// It passed its own tests, but could not be put in force or stored: the calibration before is in force.
    NotKept {
        /// Why it is believed.
        evidence: Evidence,
        /// What stood in the way.
        refusal: crate::link::message::Refusal,
    },
    /// The calibration before is in force.
    Refused {
        /// Which limit, and both numbers.
        refusal: Refusal,
        /// What was known by then.
        evidence: Evidence,
    },
}
