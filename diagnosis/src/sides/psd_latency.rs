//! the coordination sensor is sampled earlier or later than the platen sensor.
// --- sensor side: the deflection's rate ---

use effects::sensor::{Regressor, SensorEffect, Survey};

/// Sensor side: one delay, common to both axes.
pub struct LatencyModel;

impl SensorEffect for LatencyModel {
    fn name(&self) -> &'static str {
        "psd_latency"
    }

    fn sentence(&self) -> &'static str {
        "the coordination sensor is sampled earlier or later than the platen sensor"
    }

    fn telling_motion(&self) -> &'static str {
        "fly-bys under the beacon at several speeds, along x and along y; a delay common to all four segments stays the same thing"
    }

    fn regressors(&self, survey: &Survey) -> Vec<Regressor> {
        if !survey.beacon || !survey.moving {
            return Vec::new();
        }
        vec![Regressor::readings(
            "delay against the platen sensor",
            "s",
            5.0e-6,
            |m, out| {
                out[4] += m.tan_psi_rate[0];
                out[5] += m.tan_psi_rate[1];
            },
        )]
    }
}
