//! Which form an effect is told in: fuller than its simplest where that leaves a gap, or for another kind of sensor.

use serde::{Deserialize, Serialize};
use tooth_field::MeshKernel;

/// What more is told of effects whose simplest form leaves a gap.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct NestedForms {
    /// Products of more orders along and across a segment are told.
    pub lateral_mixes: bool,
    /// Harmonics that change with the angle bend over it as they please.
    pub bends_with_theta: bool,
    /// What a segment remembers of its way is there in motion and at rest by different amounts.
    pub fades_at_rest: bool,
    /// What a segment remembers of its way is stronger here than there over a tooth.
    pub memory_waves: bool,
    /// What a segment remembers of its way is felt less by a slow courier.
    pub softens: bool,
    /// Mounts follow the temperature after the last of [`LAGS_S`](crate::sensor::LAGS_S) as well.
    pub warms_slowly: bool,
    /// Offsets, gain and angle of a pair follow the temperature as well as a segment's place does.
    pub pairs_warm: bool,
    /// What lags with speed lags more here than there over a tooth.
    pub lag_waves: bool,
    /// One channel of a pair turns against the other with the angle, and shifts the pair by its mean over a tooth.
    pub turns_with_theta: Option<Channel>,
    /// The diode bends by percents of its range, as one of quadrants does, and not by thousandths.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub bends_far: bool,
    /// The sensor reads one tooth, or one pole pair, at a time, and not several at once.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub single_teeth: Option<SingleTeeth>,
}

/// Teeth, or pole pairs, that a sensor reads one at a time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SingleTeeth {
    /// The same ones come round again after so many, as on a ring; none where each is another.
    pub a_turn: Option<u32>,
}

impl NestedForms {
    /// How much a knot of a field over the teeth weighs in a reading, on a mesh of so many pitches.
    #[must_use]
    pub fn field_kernel(&self, step_pitches: f64) -> MeshKernel {
        if self.single_teeth.is_some() {
            MeshKernel::of_one_tooth(step_pitches)
        } else {
            MeshKernel::of_segment(step_pitches)
        }
    }

    /// A segment's place, m along and across, as a field over the teeth tells it: single teeth are a row, within whose turn it is told.
    #[must_use]
    pub fn field_place_m(&self, [along_m, across_m]: [f64; 2], pitch_m: f64) -> [f64; 2] {
        match self.single_teeth {
            None => [along_m, across_m],
            Some(SingleTeeth { a_turn: None }) => [along_m, 0.0],
            Some(SingleTeeth {
                a_turn: Some(count),
            }) => [along_m.rem_euclid(f64::from(count) * pitch_m), 0.0],
        }
    }
}

/// A channel of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Channel {
    /// The sine.
    Sine,
    /// The cosine.
    Cosine,
}
