//! What the watch over the beacon says.

use super::sums::{ALONG, LEFT, ONE, Sums, WARMER};
use crate::math::sqrt;
use crate::watch::Standing;
use serde::{Deserialize, Serialize};

/// By so much a coordinate must explain more than a change that is alike everywhere. Derived from a likelihood ratio of 19 (95
/// %), twice its logarithm.
const CLOSE: f32 = 5.9;
/// Slopes are told at this deflection, of full scale. By definition the most that is looked at (`rest::MOST_DEFLECTION`).
const AT_DEFLECTION: f32 = 0.5;

/// What a change of g_x or g_y goes with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Goes {
    /// Nothing: it is alike everywhere. The beacon, the diode or what holds them has moved.
    #[default]
    Alike,
    /// The temperature.
    Temperature,
    /// The place along x.
    AlongX,
    /// The place along y.
    AlongY,
}

/// A change of g_x or g_y.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BeaconChange {
    /// 0: g_x, 1: g_y.
    pub axis: u8,
    /// What it goes with.
    pub goes: Goes,
    /// Its size, metres: of the last rests on average, and of one that goes with the place, at half of the diode's full scale.
    pub size_m: f32,
    /// Its standard deviation, metres.
    pub deviation_m: f32,
    /// When there was last no sign of it, seconds since the board's start.
    pub since_s: u32,
    /// When it was told.
    pub told_s: u32,
    /// Mean temperature of these rests over that of the reference, kelvin.
    pub warmer_k: f32,
    /// Size at which the calibration is stale, metres.
    pub limit_m: f32,
}

/// What is known of the beacon's part of the calibration in force.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BeaconVerdict {
    /// How it stands.
    pub standing: Standing,
    /// Windows of 16 rests since the reference.
    pub windows: u32,
    /// What is left of g_x and g_y at a rest, metres; zero while that is learned.
    pub scatter_m: [f32; 2],
    /// When the last rest that counted was, seconds since the board's start.
    pub at_s: u32,
    /// What has changed, if that is told.
    pub change: Option<BeaconChange>,
}

/// What rests say of a change of an axis: where it goes, size and deviation, metres. `sigma_m`: of a rest.
pub(super) fn size(sums: &Sums, axis: usize, sigma_m: f32) -> (Goes, f32, f32) {
    let left = LEFT[axis & 1];
    let ways = [
        (Goes::Alike, ONE, 1.0),
        (Goes::Temperature, WARMER, sums.mean(WARMER)),
        (Goes::AlongX, ALONG[0], AT_DEFLECTION),
        (Goes::AlongY, ALONG[1], AT_DEFLECTION),
    ];
    let mut best = (Goes::Alike, 0.0, 0.0);
    let mut most = 0.0;
    for (goes, number, at) in ways {
        let square = sums.of(number, number);
        if !(square > 0.0) {
            continue;
        }
        let slope_m = sums.of(number, left) / square;
        // What is alike everywhere comes first, and is ahead.
        let ahead = if number == ONE {
            CLOSE * sigma_m * sigma_m
        } else {
            0.0
        };
        let gain = slope_m * slope_m * square + ahead;
        if gain > most {
            most = gain;
            best = (goes, at * slope_m, at.abs() * sigma_m / sqrt(square));
        }
    }
    best
}

/// In words, for people.
impl core::fmt::Display for BeaconVerdict {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match (self.standing, &self.change) {
            (Standing::Unwatched, _) => {
                f.write_str("not watched: no joint calibration is in force")
            }
            (Standing::Learning | Standing::NotObservable, _) => f.write_str(
                "not known yet: too few rests under the beacon since the calibration came in force",
            ),
            (_, Some(change)) => write!(f, "{change}"),
            (_, None) if self.windows == 0 => f.write_str("as it was found after the calibration"),
            (_, None) => write!(
                f,
                "g_x and g_y as calibrated, by {} windows of 16 rests up to {} s",
                self.windows, self.at_s
            ),
        }
    }
}

impl core::fmt::Display for BeaconChange {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let um = |metres: f32| 1.0e6 * f64::from(metres);
        let channel = if self.axis == 0 { "g_x" } else { "g_y" };
        write!(
            f,
            "{channel} has changed by {:+.1} ± {:.1} µm",
            um(self.size_m),
            um(self.deviation_m)
        )?;
        match self.goes {
            Goes::Alike => f.write_str(" alike everywhere"),
            Goes::Temperature => f.write_str(" with the temperature"),
            Goes::AlongX => f.write_str(" at half of full scale along x"),
            Goes::AlongY => f.write_str(" at half of full scale along y"),
        }?;
        write!(f, ", after {} s, told at {} s", self.since_s, self.told_s)?;
        if self.warmer_k.abs() >= 1.0 {
            write!(f, ", {:+.1} K from the reference", self.warmer_k)?;
        }
        let between = if self.size_m.abs() < self.limit_m {
            "at"
        } else {
            "above"
        };
        write!(f, "; stale {between} {:.1} µm", um(self.limit_m))
    }
}
