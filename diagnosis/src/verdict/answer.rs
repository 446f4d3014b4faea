//! What the diagnosis answers, as it is written in JSON.

use crate::data::faint::WithoutSignal;
use crate::verdict::odds::Odds;
use plausibility::{Finding, Fitted};
use serde::{Deserialize, Serialize};

/// The answer of `courier diagnose`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Diagnosis {
    /// 1.
    pub schema: u32,
    /// Path of the recording.
    pub recording: String,
    /// `no_gap`, `named`, `alias`, `unknown` or `insufficient_data`.
    pub verdict: Verdict,
    /// The violated limit with both numbers, where the data are insufficient, and anything else that must be said.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// Wires, units and stated values that cannot be right: then the data are insufficient.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub findings: Vec<Finding>,
    /// What is stated of the geometry and what the data say of it, as far as this motion tells it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub geometry: Vec<Fitted>,
    /// Where segments gave no signal. These samples are left out of all else.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub without_signal: Vec<WithoutSignal>,
    /// Each channel's residual.
    pub gap: Vec<Gap>,
    /// Where the gap lies.
    #[serde(rename = "where")]
    pub place: Vec<Share>,
    /// What is named, by share.
    pub effects: Vec<Named>,
    /// How far the gap shrinks on held-out data.
    pub held_out: HeldOut,
    /// What nothing named explains.
    pub unexplained: Unexplained,
}

/// The verdicts of diagnosis.md.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The excess is not distinguishable from the simulator's own scatter.
    NoGap,
    /// One or more effects explain it.
    Named,
    /// Several explain it equally.
    Alias,
    /// There is a gap that no catalogued effect explains.
    Unknown,
    /// The recording cannot answer.
    #[default]
    InsufficientData,
}

/// Residual of a channel in the recording and in the simulation, m.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Gap {
    /// `g_p`, `g_x`, `g_y`, `segment_1` to `segment_4`.
    pub channel: String,
    /// Held-out samples.
    pub samples: usize,
    /// Rms in the recording, m.
    pub real_rms_m: f64,
    /// Rms in the simulation, m.
    pub simulated_rms_m: f64,
    /// Root of the difference of squares, m; negative if the recording is the quieter one.
    pub excess_rms_m: f64,
    /// 95 % interval of the excess, m.
    pub excess_ci95_m: [f64; 2],
}

/// Share of the excess over one coordinate.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Share {
    /// The channel that shows most of it.
    pub channel: String,
    /// Coordinate in the words of diagnosis.md, with the segments that make it where not all of them do.
    pub coordinate: String,
    /// Share of the squared excess of all channels.
    pub share: f64,
}

/// An effect that is named.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Named {
    /// Name in diagnosis.md.
    pub name: String,
    /// Probability that it acts; of an alias, that it or one of its class does ([`crate::link`]).
    pub probability: f64,
    /// Effects that explain the same on this motion.
    pub aliases: Vec<String>,
    /// The motion that would tell them apart.
    pub break_alias: Option<String>,
    /// Amounts with their units.
    pub magnitude: Vec<Magnitude>,
    /// What the effect does altogether on this recording's motion: rms over the channels that it acts in, each about its mean, m; of
    /// slips, over the segments that slipped.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub total_rms_m: Option<f64>,
    /// Standard deviation of that, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub total_deviation_m: Option<f64>,
    /// Share of the squared excess that it takes beyond the others.
    pub share: f64,
    /// Largest channel's held-out rms with this effect alone, m.
    pub gap_after_alone_m: f64,
    /// What its probability is made of. Not written.
    #[serde(skip)]
    pub odds: Odds,
}

/// One amount.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Magnitude {
    /// What it is.
    pub name: String,
    /// How much.
    pub value: f64,
    /// Its standard deviation, in the same unit, as [`crate::inference::posterior`] tells it; zero where it was counted, none where it is not told.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub deviation: Option<f64>,
    /// Its unit.
    pub unit: String,
}

/// Held-out residuals before and after.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HeldOut {
    /// Rms of residuals over the simulator's own scatter, baseline alone.
    pub whitened_before: f64,
    /// The same with what is named.
    pub whitened_after: f64,
    /// By channel.
    pub channels: Vec<HeldOutChannel>,
}

/// One channel's held-out residual.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HeldOutChannel {
    /// Channel.
    pub channel: String,
    /// Baseline alone, rms m.
    pub before_rms_m: f64,
    /// With what is named, rms m.
    pub after_rms_m: f64,
    /// 95 % interval by bootstrap over blocks, m.
    pub after_ci95_m: [f64; 2],
    /// Simulator's own scatter, rms m.
    pub floor_rms_m: f64,
}

/// What is left.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Unexplained {
    /// Share of the squared excess.
    pub share: f64,
    /// Where it lies.
    #[serde(rename = "where")]
    pub place: Vec<Share>,
    /// What of it follows a logged column, the most first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub follows: Vec<Follows>,
    /// How far a correction without a name would get, where no effect is named.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub correction: Option<Correction>,
}

/// How what is left follows a logged column.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Follows {
    /// Name of the column, with its `aux_`.
    pub column: String,
    /// What follows it: `segment_1` to `segment_4`, or a channel where no segment can be told.
    pub of: String,
    /// True if the error changes its sign over a tooth as well, false if all phases of a tooth move alike.
    pub over_teeth: bool,
    /// Change of the error for one unit of the column about its mean, m rms over the samples.
    pub per_unit_m: f64,
    /// Standard deviation of that, m.
    pub deviation_m: f64,
}

/// What shapes without a name over the coordinates where a gap lies leave of it, held out: how far a table over them would get.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Correction {
    /// Coordinates, that which takes most first.
    pub coordinates: Vec<String>,
    /// Rms of residuals over the simulator's own scatter with it.
    pub whitened_after: f64,
    /// By channel.
    pub channels: Vec<HeldOutChannel>,
}
