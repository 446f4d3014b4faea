//! Single teeth of the platen are displaced.
// --- sensor side: a field over the platen ---

use effects::sensor::{Regressor, SensorEffect, Survey};

/// Sensor side: a bilinear field for each segment, with nodes a few teeth apart, since a segment averages over some teeth.
pub struct FieldModel;

impl SensorEffect for FieldModel {
    fn name(&self) -> &'static str {
        "tooth_variation"
    }

    fn sentence(&self) -> &'static str {
        "single teeth of the platen are displaced: a field over the platen"
    }

    fn telling_motion(&self) -> &'static str {
        "dense poses over the same teeth, there and back, so that each place is passed several times"
    }

    fn regressors(&self, survey: &Survey) -> Vec<Regressor> {
        let mut list = Vec::new();
        let step_m = survey.node_step_m;
        for s in (0..4).filter(|s| survey.segments[*s] && step_m > 0.0) {
            for &[i, j] in &survey.nodes[s] {
                let name = format!("node {i} along, {j} across, segment {}", s + 1);
                let (i, j) = (f64::from(i), f64::from(j));
                list.push(Regressor::reading(name, "m", 2.0e-6, s, move |m| {
                    let along = 1.0 - (m.place_m[s][0] / step_m - i).abs();
                    let across = 1.0 - (m.place_m[s][1] / step_m - j).abs();
                    along.max(0.0) * across.max(0.0)
                }));
            }
        }
        list
    }
}
