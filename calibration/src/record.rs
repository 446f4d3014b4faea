//! The calibration record: what is stored in flash and exchanged with a host.

mod bytes;
mod number;
mod plausible;
mod poses;

pub use number::Number;
pub use plausible::check_sensor;
pub use poses::Poses;

pub use bytes::{
    BODY_BYTES, HEADER_BYTES, Header, MAGIC, MAX_BYTES, decode, decode_into, encode, read_body,
    read_model,
};

use crate::device::Device;
use crate::diode::DiodeErrors;
use crate::frame::SEGMENTS;
use crate::geometry::Geometry;
use crate::model::{ErrorModel, ModelError};
use crate::quadrature::PairCorrection;
use serde::{Deserialize, Serialize};

/// Layout version that this firmware writes. By definition of the layout.
pub const VERSION: u16 = 3;
/// The oldest version that it reads. By definition of the layout: version 2 has no [`Poses`], and is the same otherwise.
pub const OLDEST_VERSION: u16 = 2;

/// When a calibration was made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Instant {
    /// Seconds since 1970 UTC, if a host has set the time.
    pub unix_s: Option<u64>,
    /// Seconds since the board started.
    pub uptime_s: u32,
}

/// Which constraints the calibration rests on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Method {
    /// The parity g_p of the platen sensor alone, equation (5).
    #[default]
    Platen,
    /// g_p, g_x and g_y together, equations (5), (10), (11).
    Joint,
}

/// What the data cannot tell and by which convention it was chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Gauge {
    /// Only k_1 - k_2 - k_3 + k_4 is identified; it is spread equally, so that each pair's mean is left alone.
    #[default]
    OffsetsSpread,
    /// As before; each segment pair's mean offset is exchangeable with the beacon's place o' and is put into o'.
    OffsetsSpreadBeaconFree,
}

impl core::fmt::Display for Gauge {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::OffsetsSpread => "offsets: only k1 - k2 - k3 + k4 is identified, spread equally",
            Self::OffsetsSpreadBeaconFree => {
                "offsets: only k1 - k2 - k3 + k4 is identified, spread equally; pair means are in the beacon's place"
            }
        })
    }
}

/// How good the calibration was when it was accepted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Quality {
    /// Held-out g_p residual with the calibration before this one, metres rms.
    pub residual_before_m: f32,
    /// The same with this one, metres rms.
    pub residual_after_m: f32,
    /// Worst predicted standard deviation of a calibrated position, metres.
    pub predicted_worst_m: f32,
    /// Condition number of the scaled triangle.
    pub condition_number: f32,
    /// Rank found.
    pub rank: u16,
    /// Unknowns fitted.
    pub unknowns: u16,
    /// Poses that were fitted.
    pub poses: u16,
    /// Poses that were left out as outliers.
    pub rejected: u16,
}

/// The coordination sensor's part of a joint calibration.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Beacon {
    /// The beacon's place o'_x, o'_y: whole teeth from the platen sensor's zero.
    pub origin_teeth: [i32; 2],
    /// The rest of it, metres.
    pub origin_m: [f32; 2],
    /// The sensor's own errors: gain difference, angle, terms of x and y; zero where a term is off.
    pub sensor: DiodeErrors,
    /// Standard deviation of a segment's calibrated output, metres, as the poses showed it.
    pub segment_sd_m: f32,
    /// Standard deviation of a displacement under the beacon, metres.
    pub displacement_sd_m: f32,
}

/// Everything that a calibration consists of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Calibration {
    /// The board that made it, or that has taken it over from another by order. It counts on this board alone.
    pub device: Device,
    /// When it was made.
    pub made: Instant,
    /// Board temperature during it, degrees Celsius; temperature terms count from here.
    pub temperature_c: f32,
    /// What it rests on.
    pub method: Method,
    /// Convention for what the data cannot tell.
    pub gauge: Gauge,
    /// Mean amplitude of each segment during it, counts: a change tells of another air gap.
    pub amplitude_counts: [f32; SEGMENTS],
    /// Geometry in force with it.
    pub geometry: Geometry,
    /// Corrections of each pair of channels.
    pub pairs: [PairCorrection; SEGMENTS],
    /// Terms and coefficients.
    pub model: ErrorModel,
    /// Coordination sensor, after a joint calibration.
    pub beacon: Option<Beacon>,
    /// How good it was.
    pub quality: Quality,
    /// Which poses a platen calibration visited. None of a joint one, of one that was changed since it was fitted, and in a record of version 2.
    pub poses: Option<Poses>,
}

/// Why bytes are no usable record.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum RecordError {
    /// Erased flash.
    #[error("empty")]
    Empty,
    /// Neither erased nor a whole record: its writing was cut off, or it decayed.
    #[error("torn: magic, length or CRC does not hold")]
    Torn,
    /// The flash could not be read there.
    #[error("the flash could not be read")]
    Unreadable,
    /// A whole record of a layout that this firmware does not know.
    #[error(
        "layout version {version} is not known here, this firmware reads {OLDEST_VERSION} to {VERSION}"
    )]
    UnknownVersion {
        /// Its version.
        version: u16,
    },
    /// A whole record whose body does not decode: not written by this project.
    #[error("the body does not decode")]
    Body,
    /// A whole record with an error model that cannot be used.
    #[error("error model: {0}")]
    Model(#[from] ModelError),
    /// A number of the body is none, or one that nothing physical has.
    #[error("{number} is {value}, wanted {low} to {high}")]
    Range {
        /// Which.
        number: Number,
        /// Its value.
        value: f32,
        /// Smallest.
        low: f32,
        /// Largest.
        high: f32,
    },
    /// A whole record that another board made, or that was taken over by another.
    #[error("it is of another board, {device}")]
    OtherDevice {
        /// The board that it is of.
        device: Device,
    },
    /// The record does not fit.
    #[error("the record does not fit {MAX_BYTES} bytes")]
    TooLong,
}

impl Calibration {
    /// One that corrects nothing, for a geometry; the starting point of a first calibration.
    #[inline(never)]
    pub fn identity(geometry: Geometry) -> Self {
        Self {
            device: Device::default(),
            made: Instant::default(),
            temperature_c: 0.0,
            method: Method::default(),
            gauge: Gauge::default(),
            amplitude_counts: [0.0; SEGMENTS],
            geometry,
            pairs: [PairCorrection::default(); SEGMENTS],
            model: ErrorModel::default(),
            beacon: None,
            quality: Quality::default(),
            poses: None,
        }
    }
}
