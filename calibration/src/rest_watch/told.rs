//! What the watch over rests says.

use super::rest::RestKind;
use super::sums::{ALONG, LEFT, ONE, Sums, WARMER};
use crate::math::sqrt;
use crate::watch::Standing;
use serde::{Deserialize, Serialize};

/// By so much a coordinate must explain more than a change that is alike everywhere. Derived from a likelihood ratio of 19 (95
/// %), twice its logarithm.
const CLOSE: f32 = 5.9;
/// Slopes are told at this place. By definition the largest deflection that is looked at (`rest::MOST_DEFLECTION`), or five teeth.
const AT_DEFLECTION: f32 = 0.5;

/// What a change at rests goes with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Goes {
    /// Nothing: it is alike everywhere. The beacon, the diode or what holds them has moved, or a segment by g_p.
    #[default]
    Alike,
    /// The temperature.
    Temperature,
    /// The place along x.
    AlongX,
    /// The place along y.
    AlongY,
}

/// A change of g_x, g_y or g_p.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RestChange {
    /// 0: g_x, 1: g_y, 2: g_p.
    pub axis: u8,
    /// What it goes with.
    pub goes: Goes,
    /// Its size, metres: of the last rests on average, and of one that goes with the place, at half of the diode's full scale, or over five teeth.
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

/// What is known by one kind of rests of the calibration in force.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RestVerdict {
    /// How it stands.
    pub standing: Standing,
    /// Windows of 16 rests since the reference.
    pub windows: u32,
    /// What is left of g_x and g_y at a rest, or of g_p by the first number, metres; zero while that is learned.
    pub scatter_m: [f32; 2],
    /// When the last rest that counted was, seconds since the board's start.
    pub at_s: u32,
    /// What has changed, if that is told.
    pub change: Option<RestChange>,
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

impl RestVerdict {
    /// In words, for people.
    #[must_use]
    pub const fn words(&self, kind: RestKind) -> Words<'_> {
        Words(self, kind)
    }
}

/// A verdict in words.
#[derive(Clone, Copy, Debug)]
pub struct Words<'v>(&'v RestVerdict, RestKind);

impl core::fmt::Display for Words<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self(verdict, kind) = *self;
        let [without, rests, channels] = match kind {
            RestKind::Beacon => [
                "no joint calibration",
                "rests under the beacon",
                "g_x and g_y",
            ],
            RestKind::Parity => ["no calibration", "rests", "g_p"],
        };
        match (verdict.standing, &verdict.change) {
            (Standing::Unwatched, _) => write!(f, "not watched: {without} is in force"),
            (Standing::Learning | Standing::NotObservable, _) => write!(
                f,
                "not known yet: too few {rests} since the calibration came in force"
            ),
            (_, Some(change)) => write!(f, "{change}"),
            (_, None) if verdict.windows == 0 => {
                f.write_str("as it was found after the calibration")
            }
            (_, None) => write!(
                f,
                "{channels} as calibrated, by {} windows of 16 rests up to {} s",
                verdict.windows, verdict.at_s
            ),
        }
    }
}

impl core::fmt::Display for RestChange {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let um = |metres: f32| 1.0e6 * f64::from(metres);
        let (channel, at) = match self.axis {
            0 => ("g_x", "at half of full scale"),
            1 => ("g_y", "at half of full scale"),
            _ => ("g_p", "over 5 teeth"),
        };
        write!(
            f,
            "{channel} has changed by {:+.1} ± {:.1} µm",
            um(self.size_m),
            um(self.deviation_m)
        )?;
        match self.goes {
            Goes::Alike => f.write_str(" alike everywhere"),
            Goes::Temperature => f.write_str(" with the temperature"),
            Goes::AlongX => write!(f, " {at} along x"),
            Goes::AlongY => write!(f, " {at} along y"),
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
