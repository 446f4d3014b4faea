//! How a session ends: a calibration with its evidence, or a refusal that names the limit and both numbers.

use crate::frame::{SEGMENTS, Status};
use crate::lsq::SolveError;
use crate::model::ErrorModel;
use crate::motion;

/// What a calibration must meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AcceptanceLimits {
    /// Largest condition number. The paper's motion gives 8; 20 is half its turn.
    pub condition: f32,
    /// Largest share of poses that may be outliers or not have stood still.
    pub lost_share: f32,
    /// Held-out residual over the one by the calibration in force, at most.
    pub held_out_ratio: f32,
}

impl Default for AcceptanceLimits {
    fn default() -> Self {
        Self {
            condition: 20.0,
            lost_share: 0.1,
            held_out_ratio: 1.0,
        }
    }
}

/// What is known about a fit. Residuals are standard deviations of the parity, as in the paper's 3.1.2.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Evidence {
    /// Poses that were fitted.
    pub poses: u32,
    /// Poses left out: outliers and such as did not stand still.
    pub lost: u32,
    /// Unknowns, and how many directions of them the poses determine.
    pub unknowns: u32,
    /// Determined directions.
    pub rank: u32,
    /// Condition number of the regressors.
    pub condition: f32,
    /// Residual over the fitted poses, metres.
    pub residual_m: f32,
    /// Residual over the fitted poses without any correction, metres.
    pub raw_m: f32,
    /// Largest predicted standard deviation of a segment's correction over the pitch, its constant aside, metres.
    pub worst_deviation_m: f32,
    /// Poses held out.
    pub held_out_poses: u32,
    /// Their residual without any correction, metres.
    pub held_out_raw_m: f32,
    /// Their residual by the calibration in force, metres.
    pub held_out_in_force_m: f32,
    /// Their residual by the new one, metres.
    pub held_out_m: f32,
    /// Mean amplitudes, counts.
    pub amplitude_counts: [f32; SEGMENTS],
    /// Mean temperature over the reference, kelvin.
    pub temperature_delta_k: f32,
}

/// How a session ended.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// The calibration, to be stored and put in force; or why the one in force stays.
    pub result: Result<ErrorModel, Refusal>,
    /// What is known.
    pub evidence: Evidence,
}

/// A length of the coordination sensor's mounting.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Length {
    /// h.
    Height,
    /// l_x.
    LeverX,
    /// l_y.
    LeverY,
}

impl core::fmt::Display for Length {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Height => "height h",
            Self::LeverX => "lever arm l_x",
            Self::LeverY => "lever arm l_y",
        })
    }
}

/// Why a session ended without a calibration.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize, thiserror::Error)]
#[non_exhaustive]
pub enum Refusal {
    /// By the user.
    #[error("aborted")]
    Aborted,
    /// The motion controller reports a fault.
    #[error("pose {pose}: motion controller's fault: {fault:?}")]
    MotionFault {
        /// Its fault.
        fault: motion::FaultCode,
        /// Which pose was asked for.
        pose: u32,
    },
    /// The motion controller refuses a pose.
    #[error("pose {pose}: motion controller refused: {refusal:?}")]
    MotionRefused {
        /// Its reason.
        refusal: motion::Refusal,
        /// Which pose was asked for.
        pose: u32,
    },
    /// It never settled, or does not answer, or answers nonsense.
    #[error(
        "pose {pose}: not settled after {waited} samples, limit {limit} ({answers} other answers, {nonsense} nonsense)"
    )]
    NotSettled {
        /// Which pose was asked for.
        pose: u32,
        /// Samples waited.
        waited: u32,
        /// Samples allowed.
        limit: u32,
        /// Answers that said something else.
        answers: u32,
        /// Frames on the motion line that meant nothing.
        nonsense: u32,
    },
    /// Frames say that something is wrong with them.
    #[error("pose {pose}: {bad} unusable frames, limit {limit}: {status}")]
    BadFrames {
        /// At which pose.
        pose: u32,
        /// What was wrong.
        status: Status,
        /// Unusable frames.
        bad: u32,
        /// Allowed.
        limit: u32,
    },
    /// The courier does not stand still at a pose where it should.
    #[error("moved: spread {spread_m:e} m, limit {limit_m:e} m, at the last of {lost} lost poses")]
    NotStill {
        /// Spread, or drift, at the last such pose.
        spread_m: f32,
        /// Allowed, for the noise that was stated.
        limit_m: f32,
        /// Poses lost by then.
        lost: u32,
    },
    /// Too many poses disagree with the rest.
    #[error("{refused} of {poses} poses are outliers, limit {limit}")]
    Outliers {
        /// Outliers.
        refused: u32,
        /// Poses.
        poses: u32,
        /// Allowed.
        limit: u32,
    },
    /// Too few poses for the unknowns.
    #[error("{poses} usable poses, wanted {wanted} or more")]
    TooFewPoses {
        /// Usable ones.
        poses: u32,
        /// Least number.
        wanted: u32,
    },
    /// Some combination of coefficients is not determined by the motion.
    #[error("rank {rank} of {unknowns}: the motion does not determine all coefficients")]
    Rank {
        /// Determined directions.
        rank: u32,
        /// Unknowns.
        unknowns: u32,
    },
    /// The regressors are too nearly dependent.
    #[error("condition number {condition:.1}, limit {limit:.1}")]
    Condition {
        /// The regressors'.
        condition: f32,
        /// Allowed.
        limit: f32,
    },
    /// Held-out poses do not gain by the new calibration.
    #[error("held-out residual {after_m:e} m, limit {limit_m:e} m (in force: {before_m:e} m)")]
    HeldOut {
        /// By the calibration in force.
        before_m: f32,
        /// By the new one.
        after_m: f32,
        /// Allowed.
        limit_m: f32,
    },
    /// The light on the coordination sensor is not the one beacon's.
    #[error(
        "light on the coordination sensor changed: {light_counts:.0} counts at {lost} poses, {reference_counts:.0} at the first, limit {limit_share:.2} of it"
    )]
    Light {
        /// Sum of the electrodes at the last such pose, counts.
        light_counts: f32,
        /// At the first pose, counts.
        reference_counts: f32,
        /// Change allowed, as a share.
        limit_share: f32,
        /// Poses lost by then.
        lost: u32,
    },
    /// The courier did not turn enough to tell the lever arm.
    #[error(
        "turned by {turn_rad:e} rad rms, wanted {wanted_rad:e} rad or more: the lever arm cannot be told"
    )]
    NoRotation {
        /// Rms of the poses' angles.
        turn_rad: f32,
        /// Least.
        wanted_rad: f32,
    },
    /// Height or lever arm is far from what was entered: wrong sign, wrong unit, wrong drawing.
    #[error(
        "{name} is {found_m:e} m by the data, entered {entered_m:e} m, limit of the difference {limit_m:e} m"
    )]
    Geometry {
        /// Which.
        name: Length,
        /// As entered.
        entered_m: f32,
        /// By the data.
        found_m: f32,
        /// Difference allowed.
        limit_m: f32,
    },
    /// Height or lever arm is not told by the data.
    #[error("{name} is known to {deviation_m:e} m only, wanted {limit_m:e} m or better")]
    Undetermined {
        /// Which.
        name: Length,
        /// Its predicted standard deviation.
        deviation_m: f32,
        /// Wanted.
        limit_m: f32,
    },
    /// No step of the joint calibration was of use to the held-out poses.
    #[error(
        "held-out poses gain by no step: whitened residual {before:.3} before, {after:.3} after the best"
    )]
    NoGain {
        /// Before.
        before: f32,
        /// After the best step.
        after: f32,
    },
    /// Arithmetic left f32's range.
    #[error("solve: {0}")]
    Solve(#[from] SolveError),
}
