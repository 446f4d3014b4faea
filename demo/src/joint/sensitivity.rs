//! How much of a motion a pair answers before calibration: what it hides of real motion it hides of displaced teeth too.

use courier_sensor::calibration::record::Calibration;
use courier_sensor::frame::{Frame, SEGMENTS};
use courier_sensor::model::{Basis, Observation};

/// Difference over which the error's slope is taken, turns: 5 µm.
const STEP_TURNS: f32 = 0.005;

/// Of a rotation, by segments 1 and 3 (axis 0) or 2 and 4 uncalibrated: mean of `1 / (1 + de/dp)` over a flight, e by a calibration.
pub fn of_pair(calibration: &Calibration, frames: &[Frame], axis: usize) -> f64 {
    let answers = frames.iter().flat_map(|frame| {
        [axis, axis + 2].map(|segment| 1.0 / (1.0 + slope(calibration, frame, segment)))
    });
    answers.sum::<f64>() / (2 * frames.len().max(1)) as f64
}

/// de/dp of a segment at a frame.
fn slope(calibration: &Calibration, frame: &Frame, segment: usize) -> f64 {
    let at = |turns: f32| {
        let mut seen = Observation::default();
        for i in 0..SEGMENTS {
            seen.unmodified[i] = frame.segments[i].unmodified;
        }
        seen.unmodified[segment].fraction_turns += turns;
        let basis = Basis::new(&calibration.geometry, &seen);
        f64::from(calibration.model.error_m(&basis, segment))
    };
    let length_m = 2.0 * f64::from(STEP_TURNS * calibration.geometry.pitch_m);
    (at(STEP_TURNS) - at(-STEP_TURNS)) / length_m
}

#[cfg(test)]
mod tests {
    use super::*;
    use courier_sensor::frame::Segment;
    use courier_sensor::geometry::Geometry;
    use courier_sensor::model::{ErrorModel, TermTable};
    use std::f64::consts::TAU;

    /// 20 µm of order 1 at phase 0 steepen the output by a tenth: 2 pi 20 / 1016.
    #[test]
    fn a_steep_place_answers_less_before_calibration() {
        let geometry = Geometry::PAPER;
        let mut calibration = Calibration::identity(geometry);
        calibration.model = ErrorModel::zero(TermTable::equation_3());
        calibration.model.set_columns(0, &[20.0e-6]);
        let frame = Frame {
            segments: [Segment::default(); SEGMENTS],
            ..Frame::default()
        };
        let steep = 1.0 / (1.0 + TAU * 20.0e-6 / f64::from(geometry.pitch_m));
        let answered = of_pair(&calibration, &[frame; 3], 0);
        assert!(
            (answered - 0.5 * (steep + 1.0)).abs() < 1.0e-3,
            "{answered}"
        );
        assert!((of_pair(&calibration, &[frame], 1) - 1.0).abs() < 1.0e-6);
    }
}
