//! The table of the paper's section 3.2.1 with our own figures beside it.

use super::options::JointOptions;
use super::synthetic::PROBLEMS;
use crate::Preset;
use courier_sensor::calibration::joint::StepReport;
use serde::Serialize;
use tooth_map::Evidence;

/// A row of the table: name in JSON, words, unit, the paper's figure.
type PaperRow = (&'static str, &'static str, &'static str, f64);

/// Section 3.2.1: what each method ends with, in its order; then the angles before that.
const PAPER: [PaperRow; 15] = [
    ("height_um", "synthetic, worst error of h", "µm", 20.0),
    ("lever_um", "synthetic, worst error of l_x, l_y", "µm", 20.0),
    (
        "other_um",
        "synthetic, worst error of any coefficient",
        "µm",
        1.0,
    ),
    (
        "g_x_residual_um",
        "g_x residual, held-out poses, joint",
        "µm",
        8.06,
    ),
    (
        "g_y_residual_um",
        "g_y residual, held-out poses, joint",
        "µm",
        25.2,
    ),
    (
        "g_p_residual_um",
        "g_p residual, held-out poses, joint",
        "µm",
        5.19,
    ),
    (
        "position_uncalibrated_um",
        "position error, 8 mm fly-by, uncalibrated",
        "µm",
        7.3,
    ),
    (
        "position_separate_um",
        "position error, 8 mm fly-by, separate",
        "µm",
        4.4,
    ),
    (
        "position_joint_um",
        "position error, 8 mm fly-by, joint",
        "µm",
        2.9,
    ),
    (
        "theta_x_joint_mrad",
        "θ_x error, 8 mm fly-by, joint",
        "mrad",
        0.30,
    ),
    (
        "theta_y_joint_mrad",
        "θ_y error, 8 mm fly-by, joint",
        "mrad",
        0.43,
    ),
    (
        "theta_x_uncalibrated_mrad",
        "θ_x error, 8 mm fly-by, uncalibrated",
        "mrad",
        0.13,
    ),
    (
        "theta_x_separate_mrad",
        "θ_x error, 8 mm fly-by, separate",
        "mrad",
        0.17,
    ),
    (
        "theta_y_uncalibrated_mrad",
        "θ_y error, 8 mm fly-by, uncalibrated",
        "mrad",
        1.4,
    ),
    (
        "theta_y_separate_mrad",
        "θ_y error, 8 mm fly-by, separate",
        "mrad",
        0.40,
    ),
];

/// One row of the table.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct JointRow {
    /// Its name, with the unit.
    pub name: &'static str,
    /// The paper's figure.
    pub paper: f64,
    /// This system's method; none where the run did not come so far.
    pub here: Option<f64>,
    /// The paper's method on the same poses and flights.
    pub paper_method: Option<f64>,
    /// In words.
    #[serde(skip)]
    pub words: &'static str,
    /// Unit.
    #[serde(skip)]
    pub unit: &'static str,
}

/// A fly-by with the board's own joint calibration, before a tooth map comes in force.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct WithoutMap {
    /// Position error along the way, µm.
    pub position_um: f64,
    /// Error of the angle by segments 1 and 3, mrad.
    pub theta_x_mrad: f64,
    /// Error of the angle by segments 2 and 4, mrad.
    pub theta_y_mrad: f64,
}

/// What a demonstration found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JointReport {
    /// Which courier.
    pub preset: Preset,
    /// Its seed.
    pub seed: u64,
    /// Synthetic problems solved; the worst error over all is in the table.
    pub synthetic_problems: u64,
    /// Worst error over them of the beacon's place and the angle's offset, µm: this system's method, the paper's.
    pub synthetic_place_um: [f64; 2],
    /// Poses fitted under the beacon.
    pub poses: u32,
    /// Both calibrations accepted by the firmware's own tests, stored and in force.
    pub accepted: bool,
    /// Why not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub refusal: Option<String>,
    /// How much of a rotation segments 1 and 3 answer on the fly-by before calibration, by the separate calibration: of errors that are
    /// not theirs (teeth, lateral waves) they show as much. None where the run did not come so far.
    pub theta_x_answer_uncalibrated: Option<f64>,
    /// The fly-by without the tooth map; none where the run did not come so far.
    pub without_map: Option<WithoutMap>,
    /// Share of the fly-by's frames with the map in force in which a segment was outside its trusted cells.
    pub outside_map: Option<f64>,
    /// What the tooth map rests on, where one is in force.
    pub map: Option<Evidence>,
    /// Why none is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map_refusal: Option<String>,
    /// Steps of the joint schedule.
    pub steps: Vec<StepReport>,
    /// The table.
    pub rows: Vec<JointRow>,
}

/// Whose figure it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// This system's.
    Here,
    /// The paper's.
    Paper,
}

impl JointReport {
    /// No figures yet.
    pub(super) fn new(options: &JointOptions) -> Self {
        let row = |(name, words, unit, paper)| JointRow {
            name,
            paper,
            here: None,
            paper_method: None,
            words,
            unit,
        };
        Self {
            preset: options.preset,
            seed: options.seed,
            synthetic_problems: PROBLEMS,
            synthetic_place_um: [f64::NAN; 2],
            poses: 0,
            accepted: false,
            refusal: None,
            theta_x_answer_uncalibrated: None,
            without_map: None,
            outside_map: None,
            map: None,
            map_refusal: None,
            steps: Vec::new(),
            rows: PAPER.into_iter().map(row).collect(),
        }
    }

    /// Enters a figure into the row of this name.
    pub(super) fn set(&mut self, method: Method, name: &str, value: f64) {
        if let Some(row) = self.rows.iter_mut().find(|row| row.name == name) {
            *match method {
                Method::Here => &mut row.here,
                Method::Paper => &mut row.paper_method,
            } = Some(value);
        }
    }
}
