//! The cable bends the sensor head: segments move against each other, with a memory of millimetres of travel.

use crate::plant::{Instant, PlantEffect, SEGMENTS, Scene, SegmentPoint};
use crate::random::{ChaCha8Rng, uniform};
use crate::shape::{Waves, segment_offsets};

/// Size: rms of the displacement over a long wander, pooled over the segments.
pub struct CableDrag {
    sizes_m: [f64; SEGMENTS],
    stiffness: Waves<2>,
    slack_m: f64,
    anchor_m: Option<[f64; 2]>,
}

impl CableDrag {
    /// Slack of 1 to 6 mm; the pull's direction depends on where on the platen the courier is.
    pub fn draw(_scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        Box::new(Self {
            sizes_m: segment_offsets(rng, size_rms_m),
            stiffness: Waves::draw(rng, 6, 30.0e-3, 200.0e-3),
            slack_m: uniform(rng, 1.0e-3, 6.0e-3),
            anchor_m: None,
        })
    }
}

impl PlantEffect for CableDrag {
    fn scale(&mut self, factor: f64) {
        self.sizes_m = self.sizes_m.map(|size| size * factor);
    }

    fn displacement_m(&mut self, at: &Instant, _points: &[SegmentPoint; SEGMENTS]) -> [f64; SEGMENTS] {
        let here = [at.pose.x_m, at.pose.y_m];
        let anchor = self.anchor_m.get_or_insert(here);
        let pull = [here[0] - anchor[0], here[1] - anchor[1]];
        let length = pull[0].hypot(pull[1]);
        if length > self.slack_m {
            // The cable's lying end is dragged along.
            let drag = 1.0 - self.slack_m / length;
            anchor[0] += drag * pull[0];
            anchor[1] += drag * pull[1];
        }
        let level = 1.4 * self.stiffness.at(here);
        core::array::from_fn(|s| {
            // x segments feel the pull along x, y segments along y.
            self.sizes_m[s] * (pull[s % 2] / self.slack_m).clamp(-1.0, 1.0) * (1.0 + level) / 1.2
        })
    }
}
