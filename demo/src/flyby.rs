//! A flight judged against the interferometer: standard deviations over places evenly spaced along the way.

use courier_sensor::frame::{Coordinate, Frame};
use effects::motion::Pose;

/// Distance between two places that are judged: twenty a pitch; a rest at either end counts once.
pub(super) const SPACING_M: f64 = 50.0e-6;

/// A flight along y: frames and what the interferometer read at the same instants.
#[derive(Debug)]
pub struct Flyby {
    pitch_m: f64,
    span_m: f64,
    last_y_m: Option<f64>,
    before: Errors,
    after: Errors,
}

/// The errors of one set of outputs, each over all places judged.
#[derive(Debug, Default)]
struct Errors {
    parity_m: Vec<f64>,
    y_m: Vec<f64>,
    theta_x_rad: Vec<f64>,
    theta_y_rad: Vec<f64>,
}

/// Standard deviations over a flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deviations {
    /// g_p, equation (5), m.
    pub parity_m: f64,
    /// Position along the way, m.
    pub position_m: f64,
    /// Angle by segments 1 and 3, rad.
    pub theta_x_rad: f64,
    /// Angle by segments 2 and 4, rad.
    pub theta_y_rad: f64,
}

impl Flyby {
    /// For a sensor of this geometry.
    pub fn new(pitch_m: f64, span_m: f64) -> Self {
        Self {
            pitch_m,
            span_m,
            last_y_m: None,
            before: Errors::default(),
            after: Errors::default(),
        }
    }

    /// One instant.
    pub fn add(&mut self, frame: &Frame, reference: &Pose) {
        if self
            .last_y_m
            .is_some_and(|last_y_m| (reference.y_m - last_y_m).abs() < SPACING_M)
        {
            return;
        }
        self.last_y_m = Some(reference.y_m);
        let outputs = |pick: fn(&courier_sensor::frame::Segment) -> Coordinate| {
            frame.segments.each_ref().map(|segment| {
                let place = pick(segment);
                (f64::from(place.teeth) + f64::from(place.fraction_turns)) * self.pitch_m
            })
        };
        self.before.add(
            outputs(|segment| segment.unmodified),
            reference,
            self.span_m,
        );
        self.after.add(
            outputs(|segment| segment.calibrated),
            reference,
            self.span_m,
        );
    }

    /// Places judged so far.
    pub fn places(&self) -> usize {
        self.before.y_m.len()
    }

    /// With unmodified and with calibrated outputs; none before there are two places.
    pub fn deviations(&self) -> Option<[Deviations; 2]> {
        (self.places() > 1).then(|| [self.before.deviations(), self.after.deviations()])
    }
}

impl Errors {
    /// Equations (4) and (5) on four outputs, metres.
    fn add(&mut self, [p1, p2, p3, p4]: [f64; 4], reference: &Pose, span_m: f64) {
        self.parity_m.push((p1 - p3) - (p2 - p4));
        self.y_m.push(0.5 * (p2 + p4) - reference.y_m);
        self.theta_x_rad
            .push((p1 - p3) / span_m - reference.theta_rad);
        self.theta_y_rad
            .push((p2 - p4) / span_m - reference.theta_rad);
    }

    fn deviations(&self) -> Deviations {
        Deviations {
            parity_m: deviation(&self.parity_m),
            position_m: deviation(&self.y_m),
            theta_x_rad: deviation(&self.theta_x_rad),
            theta_y_rad: deviation(&self.theta_y_rad),
        }
    }
}

/// Standard deviation, as the paper gives its errors.
pub(super) fn deviation(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (values
        .iter()
        .map(|value| (value - mean).powi(2))
        .sum::<f64>()
        / values.len() as f64)
        .sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use courier_sensor::frame::Segment;

    #[test]
    fn errors_are_what_was_put_in() {
        let (pitch_m, span_m) = (1.0e-3, 10.0e-3);
        let mut flyby = Flyby::new(pitch_m, span_m);
        for step in 0..801 {
            let y_m = 50.001e-6 * f64::from(step);
            // Segment 2 is off by ±4 µm in turn until it is calibrated; an offset of 3 µm in segment 1 is no error.
            let error_m = if step % 2 == 0 { 4.0e-6 } else { -4.0e-6 };
            let place = |place_m: f64| {
                let turns = place_m / pitch_m;
                Coordinate {
                    teeth: turns.round() as i32,
                    fraction_turns: (turns - turns.round()) as f32,
                }
            };
            let mut frame = Frame::default();
            let truth_m = [3.0e-6, y_m, 0.0, y_m];
            for (segment, truth_m) in frame.segments.iter_mut().zip(truth_m) {
                *segment = Segment {
                    unmodified: place(truth_m),
                    calibrated: place(truth_m),
                    ..Segment::default()
                };
            }
            frame.segments[1].unmodified = place(y_m + error_m);
            flyby.add(
                &frame,
                &Pose {
                    y_m,
                    ..Pose::default()
                },
            );
            flyby.add(
                &frame,
                &Pose {
                    y_m: y_m + 1.0e-6,
                    ..Pose::default()
                },
            );
        }
        assert_eq!(flyby.places(), 801);
        let [before, after] = flyby.deviations().unwrap();
        let close = |value: f64, wanted: f64| (value - wanted).abs() < 1.0e-3 * wanted;
        assert!(
            close(before.parity_m, 4.0e-6) && close(before.position_m, 2.0e-6),
            "{before:?}"
        );
        assert!(
            close(before.theta_y_rad, 4.0e-4) && before.theta_x_rad < 1.0e-8,
            "{before:?}"
        );
        assert!(
            after.parity_m < 1.0e-9 && after.position_m < 1.0e-9,
            "{after:?}"
        );
    }
}
