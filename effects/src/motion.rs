//! True motion of the courier: a pose at any time, so that a delay is a pose at another time and not a formula.

use serde::Serialize;

/// Planar pose of the platen sensor's centre in the platen's frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Pose {
    /// Along the direction that segments 1 and 3 measure, metres.
    pub x_m: f64,
    /// Along the direction that segments 2 and 4 measure, metres.
    pub y_m: f64,
    /// Counter-clockwise, radians.
    pub theta_rad: f64,
}

impl Pose {
    /// From components in metres and radians.
    #[must_use]
    pub const fn new(x_m: f64, y_m: f64, theta_rad: f64) -> Self {
        Self {
            x_m,
            y_m,
            theta_rad,
        }
    }

    /// `self + factor * other`, component by component.
    #[must_use]
    pub fn plus(self, other: Self, factor: f64) -> Self {
        Self {
            x_m: self.x_m + factor * other.x_m,
            y_m: self.y_m + factor * other.y_m,
            theta_rad: self.theta_rad + factor * other.theta_rad,
        }
    }
}

/// Half the time over which the default velocity is differenced: short against any mechanical motion (tens of hertz), long
/// against the resolution of f64 over an hour. Derived from both: at 50 Hz the slope over it is right to 1e-5, and a place in
/// metres keeps 11 digits of it.
const HALF_STEP_S: f64 = 20.0e-6;

/// A motion: pose as a function of time. Must be defined before its start and after its end (standing still).
pub trait Motion {
    /// True pose at a time, seconds.
    fn pose(&self, time_s: f64) -> Pose;

    /// Velocity (m/s, m/s, rad/s); by default a central difference.
    fn velocity(&self, time_s: f64) -> Pose {
        let (before, after) = (
            self.pose(time_s - HALF_STEP_S),
            self.pose(time_s + HALF_STEP_S),
        );
        let difference = after.plus(before, -1.0);
        Pose::default().plus(difference, 0.5 / HALF_STEP_S)
    }
}

/// Standing still.
impl Motion for Pose {
    fn pose(&self, _time_s: f64) -> Pose {
        *self
    }

    fn velocity(&self, _time_s: f64) -> Pose {
        Pose::default()
    }
}
