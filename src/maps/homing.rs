//! Whole teeth by the beacon: how far a board's tooth count, which begins anew at each start, is ahead of a stored map's.
//!
//! A pose under the beacon has one place on the platen, by equation (11) of the map's own fit: `p = o' + R(theta)(h tan psi + l)`. What the
//! board counts there, less that, must be a whole number of teeth along x and y. What is left over is the error of both, some
//! hundredths of a tooth; where it is more than a quarter, the beacon was moved or it is another one's.

use crate::calibration::rest_watch::{FASTEST_M_S, MOST_DEFLECTION};
use crate::frame::{Coordinate, Frame, Pose, Status};
use crate::geometry::Geometry;
use crate::math;
use core::f32::consts::FRAC_1_PI;
use serde::{Deserialize, Serialize};

/// Largest part of a tooth left over. A prior: half of what would be the next tooth as likely; the diode's bending and the platen's
/// errors are some hundredths.
pub const MOST_LEFT_TURNS: f32 = 0.25;
/// A window's frames may not lie further apart than this, turns. A prior: a tenth of what decides; noise is a thousandth.
pub const MOST_SPREAD_TURNS: f32 = 0.05;

/// The beacon as a map's fit found it, in the tooth count of the map's recording.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Anchor {
    /// Place of the platen sensor with the coordination sensor under the beacon at angle zero: whole teeth of x and y.
    pub beacon_teeth: [i32; 2],
    /// The rest of it, metres.
    pub beacon_m: [f32; 2],
    /// Height h, metres.
    pub height_m: f32,
    /// Lever arm l_x, l_y, metres.
    pub lever_m: [f32; 2],
}

impl Anchor {
    /// Whether its numbers are within what a courier can have ([`crate::settings::Settings::validate`]).
    pub fn is_possible(&self) -> bool {
        let within = |value: f32, low: f32, high: f32| (low..=high).contains(&value);
        let all = |values: [f32; 2], limit: f32| values.iter().all(|v| within(*v, -limit, limit));
        within(self.height_m, 1.0e-4, 10.0) && all(self.lever_m, 10.0) && all(self.beacon_m, 0.1)
    }

    /// What a board counts at a pose under the beacon, less the map's count there, along x and y; the fraction is within ±0.5.
    /// `geometry`: its pitch.
    pub fn ahead(&self, geometry: &Geometry, pose: &Pose, tan_psi: [f32; 2]) -> [Coordinate; 2] {
        let (sine, cosine) = math::sincos_turns(pose.theta_rad * (0.5 * FRAC_1_PI));
        let [lx, ly] = self.lever_m;
        let [x, y] = [
            self.height_m * tan_psi[0] + lx,
            self.height_m * tan_psi[1] + ly,
        ];
        // The anchor is the place at angle zero: o' + l.
        let from_beacon_m = [cosine * x - sine * y - lx, sine * x + cosine * y - ly];
        let counted = [pose.x, pose.y];
        core::array::from_fn(|axis| {
            let place_turns = (self.beacon_m[axis] + from_beacon_m[axis]) / geometry.pitch_m;
            let (whole, left) = split(counted[axis].fraction_turns - place_turns);
            let teeth = counted[axis].teeth.wrapping_sub(self.beacon_teeth[axis]);
            Coordinate {
                teeth: teeth.wrapping_add(whole),
                fraction_turns: left,
            }
        })
    }

    /// The beacon's place o' in the count of a board that is so many teeth ahead, for its own lever arm: whole teeth, and metres.
    pub fn origin(&self, ahead_teeth: [i32; 2], geometry: &Geometry) -> ([i32; 2], [f32; 2]) {
        let places: [(i32, f32); 2] = core::array::from_fn(|axis| {
            let here_m = self.beacon_m[axis] - geometry.lever_m[axis];
            let (whole, left) = split(here_m / geometry.pitch_m);
            let teeth = self.beacon_teeth[axis].wrapping_add(ahead_teeth[axis]);
            (teeth.wrapping_add(whole), left * geometry.pitch_m)
        });
        (places.map(|place| place.0), places.map(|place| place.1))
    }
}

/// Nearest whole number and what is left. Lengths here are some thousand teeth at most; not a number stays none.
fn split(turns: f32) -> (i32, f32) {
    let (whole, number) = math::round(turns);
    (number, turns - whole)
}

/// A place moved by the way from one to another; the fraction is within ±0.5.
pub fn moved(place: Coordinate, to: Coordinate, from: Coordinate) -> Coordinate {
    let (whole, left) = split(place.fraction_turns + (to.fraction_turns - from.fraction_turns));
    let teeth = place.teeth.wrapping_add(to.teeth).wrapping_sub(from.teeth);
    Coordinate {
        teeth: teeth.wrapping_add(whole),
        fraction_turns: left,
    }
}

/// Whole teeth ahead along x and y, if they are: what is left is at most [`MOST_LEFT_TURNS`].
pub fn whole_teeth(ahead: &[Coordinate; 2]) -> Option<[i32; 2]> {
    // Not a number fails as well.
    let is_whole = ahead
        .iter()
        .all(|ahead| ahead.fraction_turns.abs() <= MOST_LEFT_TURNS);
    is_whole.then(|| ahead.map(|ahead| ahead.teeth))
}

/// Why a frame tells nothing of the place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
pub enum Unusable {
    /// No beacon is seen, or it saturates the diode.
    #[error("a beacon")]
    NoBeacon,
    /// The tooth count or the reading is doubtful.
    #[error("frames without a fault, as `status` names it")]
    Doubtful,
    /// The courier is too fast.
    #[error("the courier to come to rest")]
    TooFast,
    /// The beacon is too far from the diode's middle.
    #[error("the courier to stand nearer under the beacon")]
    TooFarOff,
    /// No beacon is seen, or it saturates the diode; beside the map lies a mark's place, which would do as well.
    #[error("a beacon, or for its mark to be crossed at 10 mm/s or less")]
    NoBeaconNorMark,
}

/// Bits with which a place is not to be believed: all but those of a state.
const DOUBTFUL: Status = Status::all().difference(
    Status::UNCALIBRATED
        .union(Status::OUTSIDE_MAP)
        .union(Status::CALIBRATION_DRIFT)
        .union(Status::BEACON_MISSING)
        .union(Status::BEACON_SATURATED),
);

/// Whether a frame's tooth count or reading is not to be believed.
pub fn is_doubtful(frame: &Frame) -> bool {
    frame.status.intersects(DOUBTFUL)
}

/// Whether a frame tells of the place.
///
/// # Errors
/// The first thing that it lacks.
pub fn check(frame: &Frame, geometry: &Geometry) -> Result<(), Unusable> {
    let blind = Status::BEACON_MISSING.union(Status::BEACON_SATURATED);
    let most = MOST_DEFLECTION * geometry.tan_full_scale;
    // Not a number fails as well.
    let within = |values: [f32; 2], most: f32| values.iter().all(|value| value.abs() <= most);
    if frame.status.intersects(blind) {
        Err(Unusable::NoBeacon)
    } else if is_doubtful(frame) {
        Err(Unusable::Doubtful)
    } else if !within(frame.speed_m_s, FASTEST_M_S) {
        Err(Unusable::TooFast)
    } else if !within(frame.tan_psi, most) {
        Err(Unusable::TooFarOff)
    } else {
        Ok(())
    }
}

/// The mean of [`Anchor::ahead`] over a window of frames.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mean {
    first: [Coordinate; 2],
    low_turns: [f32; 2],
    high_turns: [f32; 2],
    sum_turns: [f32; 2],
    frames: u16,
}

impl Mean {
    /// Takes a frame's.
    pub fn add(&mut self, ahead: &[Coordinate; 2]) {
        if self.frames == 0 {
            *self = Self {
                first: *ahead,
                ..Self::default()
            };
        }
        for axis in 0..2 {
            let turns = ahead[axis].minus_turns(self.first[axis]);
            self.sum_turns[axis] += turns;
            self.low_turns[axis] = self.low_turns[axis].min(turns);
            self.high_turns[axis] = self.high_turns[axis].max(turns);
        }
        self.frames = self.frames.saturating_add(1);
    }

    /// Frames that were taken.
    pub fn frames(&self) -> u16 {
        self.frames
    }

    /// The mean, if the frames agree within [`MOST_SPREAD_TURNS`].
    pub fn mean(&self) -> Option<[Coordinate; 2]> {
        let agree =
            (0..2).all(|axis| self.high_turns[axis] - self.low_turns[axis] <= MOST_SPREAD_TURNS);
        let share = 1.0 / f32::from(self.frames);
        (agree && self.frames > 0).then(|| {
            core::array::from_fn(|axis| {
                let first = self.first[axis];
                let (whole, left) = split(first.fraction_turns + self.sum_turns[axis] * share);
                Coordinate {
                    teeth: first.teeth.wrapping_add(whole),
                    fraction_turns: left,
                }
            })
        })
    }
}
