//! the beacon or its mount vibrates at one or a few frequencies.
// --- sensor side: lines in the spectrum of g_x and g_y ---

use core::f64::consts::TAU;
use effects::sensor::{Regressor, SensorEffect, Survey};

/// Sensor side: sine and cosine at each line that the survey found, along x and y, by stretch.
pub struct VibrationModel;

impl SensorEffect for VibrationModel {
    fn name(&self) -> &'static str {
        "beacon_vibration"
    }

    fn sentence(&self) -> &'static str {
        "the beacon or its mount vibrates at one or a few frequencies"
    }

    fn telling_motion(&self) -> &'static str {
        "standing still under the beacon for a few seconds at the full sample rate"
    }

    fn regressors(&self, survey: &Survey) -> Vec<Regressor> {
        let mut list = Vec::new();
        for &hz in survey.beacon_lines_hz.iter().filter(|_| survey.beacon) {
            for axis in 0..2 {
                let name = |part| format!("{hz:.3} Hz {part}, {}", ["x", "y"][axis]);
                list.push(Regressor::channel(
                    name("sine"),
                    "m",
                    4.0e-6,
                    1 + axis,
                    move |m| (TAU * hz * m.t_s).sin(),
                ));
                list.push(Regressor::channel(
                    name("cosine"),
                    "m",
                    4.0e-6,
                    1 + axis,
                    move |m| (TAU * hz * m.t_s).cos(),
                ));
            }
        }
        list
    }
}
