//! Pose under the beacon by all six readings: four calibrated segments and the coordination sensor, by weighted least squares.
//!
//! 1 µm over the lever arm of 90 mm is 11 µrad, over the span of 9.7 mm 100 µrad: the beacon gives the angle, the platen what
//! is then left of y.

use courier_sensor::calibration::joint::{StepReport, sensor};
use courier_sensor::calibration::record::Calibration;
use courier_sensor::frame::{Frame, SEGMENTS};
use courier_sensor::geometry::Geometry;
use nalgebra::{Matrix3, RowVector3, Vector3};

/// Steps of Gauss-Newton: the second moves a pose of some degrees by less than a nanometre.
const STEPS: usize = 2;
/// Least that is believed of a reading's deviation, metres: what a session states.
const LEAST_M: f64 = 0.05e-6;

/// A joint calibration, made ready.
pub struct Fusion {
    geometry: Geometry,
    origin_m: [f64; 2],
    sensor: Vec<f32>,
    segment_m: f64,
    displacement_m: f64,
}

impl Fusion {
    /// From a calibration and the step that gave it: what its held-out poses leave is the readings' noise. None without a
    /// beacon in it.
    pub fn new(calibration: &Calibration, step: &StepReport) -> Option<Self> {
        let beacon = calibration.beacon.as_ref()?;
        let [g_p, g_x, _] = step.after.rms_m.map(f64::from);
        let segment_m = (0.5 * g_p).max(LEAST_M);
        let geometry = calibration.geometry;
        // Segments in g_x: half of two, and through l_y theta a share of all four.
        let through_angle = f64::from(geometry.lever_m[1]) / (2.0 * f64::from(geometry.span_m));
        let share = 0.5 + SEGMENTS as f64 * through_angle.powi(2);
        let displacement_m = (g_x * g_x - share * segment_m * segment_m)
            .max(0.0)
            .sqrt()
            .max(LEAST_M);
        let sensor = beacon.sensor.to_vec();
        (sensor.len() >= 2).then(|| Self {
            geometry,
            origin_m: beacon.origin_m.map(f64::from),
            sensor,
            segment_m,
            displacement_m,
        })
    }

    /// x, y (metres) and angle; the frame's own calibrated outputs.
    pub fn pose(&self, frame: &Frame) -> [f64; 3] {
        let pitch_m = self.geometry.pitch_m;
        let p = frame
            .segments
            .map(|segment| segment.calibrated.metres(pitch_m));
        let span_m = f64::from(self.geometry.span_m);
        let mut pose = Vector3::new(
            0.5 * (p[0] + p[2]),
            0.5 * (p[1] + p[3]),
            ((p[0] - p[2]) + (p[1] - p[3])) / (2.0 * span_m),
        );
        let body = self.body_m(frame);
        for _ in 0..STEPS {
            if let Some(change) = self.step(&pose, &p, body) {
                pose += change;
            }
        }
        [pose.x, pose.y, pose.z]
    }

    /// Beacon to platen sensor in the courier's axes: equation (10), the sensor's own errors, and the lever arm.
    fn body_m(&self, frame: &Frame) -> [f64; 2] {
        let full_scale = self.geometry.tan_full_scale;
        let deflection = frame.tan_psi.map(|tan_psi| tan_psi / full_scale);
        let (misalignment, nonlinearity) = self.sensor.split_at(2);
        let corrected = sensor::corrected(
            deflection,
            &[misalignment[0], misalignment[1]],
            nonlinearity,
        );
        let scale_m = self.geometry.height_m * full_scale;
        std::array::from_fn(|i| {
            f64::from(corrected[i] * scale_m) + f64::from(self.geometry.lever_m[i])
        })
    }

    /// One weighted step; none if it cannot be solved.
    fn step(&self, pose: &Vector3<f64>, p: &[f64; 4], [bx, by]: [f64; 2]) -> Option<Vector3<f64>> {
        let arm = 0.5 * f64::from(self.geometry.span_m);
        let (sine, cosine) = pose.z.sin_cos();
        let (turned_x, turned_y) = (cosine * bx - sine * by, sine * bx + cosine * by);
        let rows = [
            (
                RowVector3::new(1.0, 0.0, arm),
                p[0] - pose.x - arm * pose.z,
                self.segment_m,
            ),
            (
                RowVector3::new(0.0, 1.0, arm),
                p[1] - pose.y - arm * pose.z,
                self.segment_m,
            ),
            (
                RowVector3::new(1.0, 0.0, -arm),
                p[2] - pose.x + arm * pose.z,
                self.segment_m,
            ),
            (
                RowVector3::new(0.0, 1.0, -arm),
                p[3] - pose.y + arm * pose.z,
                self.segment_m,
            ),
            (
                RowVector3::new(1.0, 0.0, turned_y),
                turned_x + self.origin_m[0] - pose.x,
                self.displacement_m,
            ),
            (
                RowVector3::new(0.0, 1.0, -turned_x),
                turned_y + self.origin_m[1] - pose.y,
                self.displacement_m,
            ),
        ];
        let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
        for (row, misclosure, deviation) in rows {
            let weight = deviation.powi(-2);
            normal += row.transpose() * row * weight;
            right += row.transpose() * (misclosure * weight);
        }
        normal.cholesky().map(|factor| factor.solve(&right))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use courier_sensor::frame::Coordinate;

    /// A beacon seen exactly pulls a wrong angle of the segments right, and leaves y where they say it is.
    #[test]
    fn the_beacon_gives_the_angle() {
        let geometry = Geometry::PAPER;
        let fusion = Fusion {
            geometry,
            origin_m: geometry.lever_m.map(|l| -f64::from(l)),
            sensor: vec![0.0; 14],
            segment_m: 2.0e-6,
            displacement_m: 0.1e-6,
        };
        // Courier at zero under the beacon; segments 2 and 4 say y = 1 µm, and an angle 0.2 mrad off.
        let mut frame = Frame::default();
        for (segment, p) in
            frame
                .segments
                .iter_mut()
                .zip([0.0, 1.0e-6 + 0.97e-6, 0.0, 1.0e-6 - 0.97e-6])
        {
            segment.calibrated = Coordinate {
                teeth: 0,
                fraction_turns: (p / 1.016e-3) as f32,
            };
        }
        let [x, y, theta] = fusion.pose(&frame);
        assert!(x.abs() < 0.1e-6, "{x:e}");
        assert!((y - 1.0e-6).abs() < 0.1e-6, "{y:e}");
        // y = 1 µm with the beacon where it is means that the courier has turned by 1 µm / 90 mm.
        assert!((theta - y / 90.0e-3).abs() < 2.0e-6, "{theta:e}");
    }
}
