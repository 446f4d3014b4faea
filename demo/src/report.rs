//! The table of the paper's section 3.1.2 with our own figures beside it.

use super::options::Options;
use super::preset::Preset;
use serde::Serialize;

/// A row of the table: name in JSON, words, unit, the paper's figure.
type PaperRow = (&'static str, &'static str, &'static str, f64);

/// Section 3.1.2, in its order.
const PAPER: [PaperRow; 11] = [
    (
        "condition_number",
        "condition number, offsets merged",
        "",
        8.0,
    ),
    (
        "scatter_residual_before_um",
        "g_p residual, scatter, uncalibrated",
        "µm",
        29.3,
    ),
    (
        "scatter_residual_after_um",
        "g_p residual, scatter, calibrated",
        "µm",
        4.1,
    ),
    (
        "flyby_residual_before_um",
        "g_p residual, 40 mm fly-by, uncalibrated",
        "µm",
        12.1,
    ),
    (
        "flyby_residual_after_um",
        "g_p residual, 40 mm fly-by, calibrated",
        "µm",
        5.5,
    ),
    (
        "flyby_position_before_um",
        "position error, fly-by, uncalibrated",
        "µm",
        8.9,
    ),
    (
        "flyby_position_after_um",
        "position error, fly-by, calibrated",
        "µm",
        6.5,
    ),
    (
        "theta_x_before_mrad",
        "θ_x error, fly-by, uncalibrated",
        "mrad",
        0.4,
    ),
    (
        "theta_x_after_mrad",
        "θ_x error, fly-by, calibrated",
        "mrad",
        0.4,
    ),
    (
        "theta_y_before_mrad",
        "θ_y error, fly-by, uncalibrated",
        "mrad",
        1.2,
    ),
    (
        "theta_y_after_mrad",
        "θ_y error, fly-by, calibrated",
        "mrad",
        0.4,
    ),
];

/// One row of the table.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ReportRow {
    /// Its name, with the unit.
    pub name: &'static str,
    /// The paper's figure.
    pub paper: f64,
    /// Ours; none where the run did not come so far.
    pub here: Option<f64>,
    /// In words.
    #[serde(skip)]
    pub words: &'static str,
    /// Unit.
    #[serde(skip)]
    pub unit: &'static str,
}

/// What a demonstration found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// Which courier.
    pub preset: Preset,
    /// Its seed.
    pub seed: u64,
    /// Poses fitted.
    pub poses: u32,
    /// Accepted by the firmware's own tests, stored, and in force after a restart.
    pub accepted: bool,
    /// Why not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub refusal: Option<String>,
    /// Held-out poses by which the firmware decided: residual without and with the calibration, µm.
    pub held_out_residual_um: [f64; 2],
    /// The table.
    pub rows: Vec<ReportRow>,
}

impl Report {
    /// No figures yet.
    pub(super) fn new(options: &Options) -> Self {
        let row = |(name, words, unit, paper)| ReportRow {
            name,
            paper,
            here: None,
            words,
            unit,
        };
        Self {
            preset: options.preset,
            seed: options.seed,
            poses: 0,
            accepted: false,
            refusal: None,
            held_out_residual_um: [f64::NAN; 2],
            rows: PAPER.into_iter().map(row).collect(),
        }
    }

    /// Enters our figure into the row of this name.
    pub(super) fn set(&mut self, name: &str, here: f64) {
        if let Some(row) = self.rows.iter_mut().find(|row| row.name == name) {
            row.here = Some(here);
        }
    }

    /// Our figure in the row of this name.
    pub fn figure(&self, name: &str) -> Option<f64> {
        self.rows.iter().find(|row| row.name == name)?.here
    }
}
