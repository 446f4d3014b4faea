//! What `courier calibrate --joint` tells beside the ending: the steps, and the coordination sensor as found.

use crate::terminal::{figure, micrometres, pairs, table};
use courier_sensor::calibration::joint::{StepReport, sensor::TERMS};
use courier_sensor::calibration::record::Calibration;
use courier_sensor::link::report::Progress;
use serde::Serialize;

/// The coordination sensor after an accepted joint calibration.
#[derive(Clone, Debug, Serialize)]
pub struct Found {
    /// Beacon's height over the diode, metres.
    pub height_m: f32,
    /// Lever arm l_x, l_y, metres.
    pub lever_m: [f32; 2],
    /// The beacon's place o'_x, o'_y from the platen sensor's zero, metres.
    pub beacon_m: [f32; 2],
    /// The sensor's own errors, those that the data wanted; empty where held-out poses did not.
    pub sensor_terms: Vec<SensorTerm>,
}

/// One term of the coordination sensor's own errors.
#[derive(Clone, Debug, Serialize)]
pub struct SensorTerm {
    /// Its name.
    pub name: String,
    /// Coefficient at full scale; radians for the angle.
    pub value: f32,
}

impl Found {
    /// Of a joint calibration; zeros where it holds no beacon.
    pub fn new(calibration: &Calibration) -> Self {
        let beacon = calibration.beacon.clone().unwrap_or_default();
        let names = sensor_names();
        let terms = names
            .into_iter()
            .zip(&beacon.sensor)
            .filter(|(_, value)| **value != 0.0);
        Self {
            height_m: calibration.geometry.height_m,
            lever_m: calibration.geometry.lever_m,
            beacon_m: std::array::from_fn(|i| {
                beacon.origin_teeth[i] as f32 * calibration.geometry.pitch_m + beacon.origin_m[i]
            }),
            sensor_terms: terms
                .map(|(name, value)| SensorTerm {
                    name,
                    value: *value,
                })
                .collect(),
        }
    }

    /// For the terminal.
    pub fn text(&self) -> String {
        let mm = |length_m: f32| format!("{:.4} mm", 1.0e3 * f64::from(length_m));
        let both = |[x, y]: [f32; 2]| format!("{}, {}", mm(x), mm(y));
        let mounting = pairs(&[
            ("height h", mm(self.height_m)),
            ("lever arm l_x, l_y", both(self.lever_m)),
            ("beacon's place o'_x, o'_y", both(self.beacon_m)),
        ]);
        if self.sensor_terms.is_empty() {
            return format!(
                "{mounting}\ncoordination sensor's own errors: none that held-out poses want"
            );
        }
        let terms = self
            .sensor_terms
            .iter()
            .map(|term| format!("{} {:.4}", term.name, term.value));
        format!(
            "{mounting}\ncoordination sensor's own errors: {}",
            terms.collect::<Vec<_>>().join(", ")
        )
    }
}

/// In the order of a record's `beacon.sensor`.
fn sensor_names() -> Vec<String> {
    let axes = [("x", "u", "v"), ("y", "v", "u")];
    let terms = axes.into_iter().flat_map(|(axis, own, other)| {
        let power = |name: &str, exponent: u8| match exponent {
            0 => String::new(),
            1 => format!(" {name}"),
            _ => format!(" {name}^{exponent}"),
        };
        TERMS
            .into_iter()
            .map(move |(n, m)| format!("{axis}:{}{}", power(own, n), power(other, m)))
    });
    ["difference of gains", "angle in the mount"]
        .map(String::from)
        .into_iter()
        .chain(terms)
        .collect()
}

/// The steps made, each with the residuals of held-out poses before and after it, µm.
pub fn steps_table(progress: &Progress) -> String {
    let rows: Vec<Vec<String>> = progress.steps.iter().flatten().map(row).collect();
    if rows.is_empty() {
        return "no step of the schedule was made".to_owned();
    }
    table(
        &[
            "step",
            "verdict",
            "held-out g_p, µm",
            "g_x, µm",
            "g_y, µm",
            "whitened",
            "gain / its error",
        ],
        &rows,
    )
}

fn row(report: &StepReport) -> Vec<String> {
    let (before, after) = (report.before, report.after);
    let channel = |i: usize| {
        let um = |length_m: f32| micrometres(f64::from(length_m));
        format!("{} -> {}", um(before.rms_m[i]), um(after.rms_m[i]))
    };
    vec![
        format!("{:?}", report.step),
        if report.accepted {
            "accepted"
        } else {
            "reverted"
        }
        .to_owned(),
        channel(0),
        channel(1),
        channel(2),
        format!(
            "{} -> {}",
            figure(before.whitened_rms.into()),
            figure(after.whitened_rms.into())
        ),
        figure(report.significance.into()),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_coefficient_has_its_name() {
        let names = sensor_names();
        assert_eq!(names.len(), 16);
        assert_eq!(
            (names[2].as_str(), names[3].as_str(), names[15].as_str()),
            ("x: u^3", "x: u^2 v", "y: u^3")
        );
    }
}
