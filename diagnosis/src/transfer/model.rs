//! The diagnosed model on disk.

use crate::inference::covariance::PosteriorCovariance;
use crate::linearization::baseline::Baseline;
use crate::linearization::recording::ReferenceValues;
use crate::transfer::amplitude_support::AmplitudeSupport;
use crate::transfer::support::TrainingSupport;
use crate::verdict::answer::{HeldOut, Magnitude};
use effects::Card;
use effects::identity::Wave;
use effects::sensor::BasisInputs;
use serde::{Deserialize, Serialize};

/// What `diagnose --model` writes: everything that `check` needs, in SI.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Model {
    /// 1.
    pub schema: u32,
    /// The recording that it is of.
    pub recording: String,
    /// Baseline calibrated alone.
    pub baseline: Baseline,
    /// Baseline fitted together with the effects.
    pub baseline_with_effects: Baseline,
    /// Amounts of each effect: what is added to the readings, in the convention of equation (3).
    pub effects: Vec<EffectAmounts>,
    /// Values that amounts are relative to.
    pub normal: ReferenceValues,
    /// What was surveyed: frequencies, clip levels, speeds.
    #[serde(rename = "survey")]
    pub inputs: BasisInputs,
    /// Held-out figures that `check` should confirm.
    pub claimed: HeldOut,
    /// True where bursts were named: another recording has others, and `check` sets them aside.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub bursts: bool,
    /// Where it knows the field over the platen, if it has one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub visited: Option<TrainingSupport>,
    /// How well the other amounts are known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub certainty: Option<PosteriorCovariance>,
    /// What shapes without a name add to the readings, where nothing is named.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nameless: Option<NamelessAmounts>,
    /// How far the amplitudes went, where it speaks of the gap.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reached: Option<AmplitudeSupport>,
}

/// Amounts of those shapes of a correction without a name that are waves over a segment's tooth phases, in the convention of equation (3),
/// fitted to all samples in use together with the baseline and without its other shapes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct NamelessAmounts {
    /// Coordinates that its shapes are laid over, in the words of diagnosis.md.
    pub coordinates: Vec<String>,
    /// Baseline fitted together with them.
    pub baseline: Baseline,
    /// The waves, with what each adds: m where its factor is 1 in SI.
    pub waves: Vec<(Wave, f64)>,
    /// How many shapes of the correction are none.
    pub other_shapes: usize,
}

/// Amounts of one effect.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EffectAmounts {
    /// Name in diagnosis.md.
    pub name: String,
    /// False where the amounts belong to that recording's own time (a drift's course): `check` leaves them out.
    pub carries_over: bool,
    /// All amounts but those that stand for how a vibration swells and strays, which is another on the next recording.
    pub amounts: Vec<Magnitude>,
}

impl Model {
    /// True if an effect of it goes with the temperature.
    pub(crate) fn follows_temperature(&self) -> bool {
        let mut effects = self.effects.iter();
        effects.any(|e| effects::has(&e.name, Card::follows_temperature))
    }
}

/// True if the amounts of an effect are tied to a recording's own time. A pair's counts show its course in any recording.
pub(crate) fn is_time_bound(effect: &str, inputs: &BasisInputs) -> bool {
    effects::has(effect, Card::keeps_its_own_time) && !inputs.counts
}
