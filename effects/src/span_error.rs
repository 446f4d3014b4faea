//! `span_error`: the segments do not sit where the drawing says.

// --- plant side: where the segments are over the ruling ---

use crate::plant::{Instant, PlantEffect, SEGMENTS, Scene, SegmentPoint};
use crate::random::ChaCha8Rng;
use crate::shape::segment_offsets;

/// Angles at which the size is stated: uniform within +-0.5 degrees. A definition: the angles of the paper's self-calibration
/// (3.1.2).
const REFERENCE_RAD: f64 = 0.5 * core::f64::consts::PI / 180.0;

/// Plant side. Size: rms of the displacement over angles uniform within +-0.5 degrees, pooled over the segments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpanError {
    /// How much further than half a span each segment sits from the centre, metres.
    pub arm_m: [f64; SEGMENTS],
    /// How much further than l_o each sits sideways, metres.
    pub side_m: [f64; SEGMENTS],
}

impl SpanError {
    /// Both directions of every segment, of like size.
    pub fn draw(_scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        let size = size_rms_m * 3.0_f64.sqrt() / REFERENCE_RAD;
        Box::new(Self { arm_m: segment_offsets(rng, size), side_m: segment_offsets(rng, size) })
    }
}

impl PlantEffect for SpanError {
    fn scale(&mut self, factor: f64) {
        self.arm_m = self.arm_m.map(|m| m * factor);
        self.side_m = self.side_m.map(|m| m * factor);
    }

    fn platen(&mut self, at: &Instant, points: &mut [SegmentPoint; SEGMENTS]) {
        for (s, point) in points.iter_mut().enumerate() {
            point.own_m += self.arm_m[s] * at.pose.theta_rad;
            point.across_m += self.side_m[s] * at.pose.theta_rad;
        }
    }
}

// --- sensor side: the angle in g_p ---

/// What a sensor can know of it: shares nothing with the plant side above.
pub mod sensor_side {
    use crate::sensor::{Regressor, BasisInputs};

    /// Prior deviation of what both spans are longer by, half the sum of the four arms: an assembly places each to a millimetre. Stated as such,
    /// since the lever arms take over nearly all that a common error does to the beacon's channels.
    const BOTH_M: f64 = 1.0e-3;
    /// What each reading takes of a metre that both spans are longer by, per radian. Derived from equation (4) and p = x ±
    /// (l_s/2) θ: half to either segment.
    pub(super) const TOGETHER: [f64; 4] = [-0.5, -0.5, 0.5, 0.5];
    /// What it takes of a metre that the span of segments 1 and 3 is longer by than the other, per radian. Derived from the same:
    /// a quarter to each segment, of the other sign to the other pair.
    pub(super) const APART: [f64; 4] = [-0.25, 0.25, 0.25, -0.25];

    /// Sensor side: the two pairs' distances differ. A common error is the angle's scale, which the lever arms take over but for
    /// its second order: seen under a beacon only. Against a reference each segment's own arm shows.
    ///
    /// Amounts are what is to be added to the drawing. A reading takes the opposite: with a span l stated and l + d built, equation (4) makes
    /// l theta of the pair's difference (l + d) theta by adding -d/2 theta to the one segment and d/2 theta to the other.
    pub fn regressors(inputs: &BasisInputs) -> Vec<Regressor> {
        if inputs.reference {
            return against_reference(inputs);
        }
        if !inputs.segments.iter().all(|s| *s) {
            return Vec::new();
        }
        let mut list = vec![span("span of segments 1 and 3 over 2 and 4", APART)];
        if inputs.beacon {
            let both = span("span of both pairs", TOGETHER);
            list.push(both.of_deviation(BOTH_M));
        }
        list
    }

    fn span(name: &str, shares: [f64; 4]) -> Regressor {
        Regressor::readings(name, "m", 5.0e-6, move |m, out| {
            for (s, share) in shares.into_iter().enumerate() {
                out[s] += share * m.theta_rad;
            }
        })
    }

    fn against_reference(inputs: &BasisInputs) -> Vec<Regressor> {
        let arm = |s: usize| {
            let name = format!("arm of segment {}", s + 1);
            let outwards = if s < 2 { -1.0 } else { 1.0 };
            Regressor::reading(name, "m", 5.0e-6, s, move |m| outwards * m.theta_rad)
        };
        (0..4).filter(|s| inputs.segments[*s]).map(arm).collect()
    }
}

// --- what is known of it ---

use crate::effect::{Card, Confusable, Effect, Need, Quantity, Recordings};
use crate::sensor::{Regressor, BasisInputs};

/// The effect.
pub struct Definition;

/// Its card.
pub static CARD: Card = Card {
    name: "span_error",
    summary: "the segments do not sit where the drawing says",
    sizes: "5 µm at the recording's angles for a difference of the pairs' spans; 1 mm for what both spans are longer by: an assembly places each of four arms to a millimetre",
    telling_motion: "slow turns over ±1.2° at one place",
    recordings: Recordings::Turned,
    needs: &[Need::Turning],
    follows: Quantity::Angle,
    coordinate: "theta",
    confusable: &[
        Confusable { with: "angle_dependence", parted_by: "both grow with the angle: harmonics that change come back at every tooth, an arm does not; slow turns at one place tell" },
    ],
    ..Card::PLAIN
};

impl Effect for Definition {
    fn card(&self) -> &'static Card {
        &CARD
    }

    fn draw(&self, scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        SpanError::draw(scene, rng, size_rms_m)
    }

    fn shapes(&self, inputs: &BasisInputs) -> Vec<Regressor> {
        sensor_side::regressors(inputs)
    }
}

#[cfg(test)]
mod tests {
    use super::sensor_side::{APART, TOGETHER};

    /// Stated plus told is right: a courier whose spans are longer than the drawing's by these amounts reads, with them added, what one of the
    /// drawing would.
    #[test]
    fn amounts_are_what_is_added_to_the_stated_spans() {
        let (stated_m, longer_m, theta_rad) = (8.2e-3, [1.5e-3, 1.1e-3], 0.01);
        let arm = |span_m: f64, segment: usize| {
            let side = if segment < 2 { 0.5 } else { -0.5 };
            side * span_m * theta_rad
        };
        let both_m = 0.5 * (longer_m[0] + longer_m[1]);
        let apart_m = longer_m[0] - longer_m[1];
        for segment in 0..4 {
            let built_m = arm(stated_m + longer_m[segment % 2], segment);
            let added_m = (TOGETHER[segment] * both_m + APART[segment] * apart_m) * theta_rad;
            assert!((built_m + added_m - arm(stated_m, segment)).abs() < 1e-15);
        }
    }
}
