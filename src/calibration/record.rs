//! The calibration record: what is stored in flash and exchanged with a host, byte for byte.
//!
//! ```text
//!  byte  0       4      6      8        12         16               16+n   20+n
//!        | magic | ver. | zero | length n | sequence | body, n bytes | CRC-32 |
//!        | CSRC  | u16  | u16  | u32      | u32      | postcard      | u32    |
//! ```
//! Little endian; the CRC (ISO-HDLC, the one of zlib) is over everything before it. Magic, version, length, sequence and the CRC's
//! place are the same in every version, so that a record of a later firmware is recognised, named and left alone. The body of
//! version [`VERSION`] is [`Calibration`] in postcard's format; a change of its fields is a new version.

use crate::diode::DiodeErrors;
use crate::frame::SEGMENTS;
use crate::geometry::Geometry;
use crate::model::{ErrorModel, MAX_TERMS, ModelError, TermCoefficients};
use crate::quadrature::PairCorrection;
use crate::sink;
use crc::{CRC_32_ISO_HDLC, Crc, NoTable};
use serde::de::{DeserializeSeed, Error as _, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

/// Layout version that this firmware writes and reads.
pub const VERSION: u16 = 2;
/// First bytes of every record.
pub const MAGIC: [u8; 4] = *b"CSRC";
/// Magic, version, length and sequence.
pub const HEADER_BYTES: usize = 16;
/// Longest record.
pub const MAX_BYTES: usize = 2040;

/// Most postcard bytes of a calibration of this version.
pub const BODY_BYTES: usize = 1152;

const CRC_BYTES: usize = 4;
// Without a table: a record is written once in a session, and the table is 1 KiB.
static CRC32: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);

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
    /// The board's own number, 96 bits.
    pub device: [u8; 12],
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
}

/// Why bytes are no usable record.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
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
    #[error("layout version {version} is not known here, this firmware reads {VERSION}")]
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
    /// A number of the body is not finite.
    #[error("{name} is not a finite number")]
    NotFinite {
        /// Which.
        name: &'static str,
    },
    /// The record does not fit.
    #[error("the record does not fit {MAX_BYTES} bytes")]
    TooLong,
}

/// First 16 bytes of a record, whatever its version.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Header {
    /// Layout version.
    pub version: u16,
    /// Length of the body, bytes.
    pub body_bytes: usize,
    /// Counts commits.
    pub sequence: u32,
}

impl Header {
    /// Takes the header apart; says nothing of the body or the CRC yet.
    ///
    /// # Errors
    /// [`RecordError::Empty`] for erased flash, [`RecordError::Torn`] for anything else without magic or with an impossible length.
    pub fn parse(bytes: &[u8; HEADER_BYTES]) -> Result<Self, RecordError> {
        let [
            m0,
            m1,
            m2,
            m3,
            v0,
            v1,
            z0,
            z1,
            l0,
            l1,
            l2,
            l3,
            s0,
            s1,
            s2,
            s3,
        ] = *bytes;
        if bytes.iter().all(|&byte| byte == 0xFF) {
            return Err(RecordError::Empty);
        }
        let body_bytes = u32::from_le_bytes([l0, l1, l2, l3]) as usize;
        let fits = body_bytes <= MAX_BYTES - HEADER_BYTES - CRC_BYTES;
        if [m0, m1, m2, m3] != MAGIC || [z0, z1] != [0, 0] || !fits {
            return Err(RecordError::Torn);
        }
        let (version, sequence) = (
            u16::from_le_bytes([v0, v1]),
            u32::from_le_bytes([s0, s1, s2, s3]),
        );
        Ok(Self {
            version,
            body_bytes,
            sequence,
        })
    }

    /// Length of the whole record, bytes.
    pub const fn record_bytes(&self) -> usize {
        HEADER_BYTES + self.body_bytes + CRC_BYTES
    }
}

/// Writes a record into `buffer` and returns its length, bytes.
///
/// # Errors
/// [`RecordError::TooLong`], or what [`Calibration::validate`] says: a record that could not be read back is not written.
pub fn encode(
    calibration: &Calibration,
    sequence: u32,
    buffer: &mut [u8; MAX_BYTES],
) -> Result<usize, RecordError> {
    calibration.validate()?;
    let (header, rest) = buffer
        .split_first_chunk_mut::<HEADER_BYTES>()
        .ok_or(RecordError::TooLong)?;
    let body_bytes = sink::write(calibration, rest)
        .ok_or(RecordError::TooLong)?
        .len();
    header[..4].copy_from_slice(&MAGIC);
    header[4..6].copy_from_slice(&VERSION.to_le_bytes());
    header[6..8].copy_from_slice(&[0; 2]);
    header[8..12].copy_from_slice(&(body_bytes as u32).to_le_bytes());
    header[12..].copy_from_slice(&sequence.to_le_bytes());
    let end = HEADER_BYTES + body_bytes;
    let (message, rest) = buffer
        .split_at_mut_checked(end)
        .ok_or(RecordError::TooLong)?;
    let crc = rest
        .first_chunk_mut::<CRC_BYTES>()
        .ok_or(RecordError::TooLong)?;
    *crc = CRC32.checksum(message).to_le_bytes();
    Ok(end + CRC_BYTES)
}

/// Reads a record from the start of `bytes`; what follows it does not matter.
///
/// # Errors
/// [`RecordError`]: nothing is guessed or defaulted.
pub fn decode(bytes: &[u8]) -> Result<(u32, Calibration), RecordError> {
    let mut calibration = Calibration::identity(Geometry::PAPER);
    let sequence = decode_into(bytes, &mut calibration)?;
    Ok((sequence, calibration))
}

/// [`decode`] without a copy on the stack; on an error `place` is of no use.
///
/// # Errors
/// As [`decode`].
pub fn decode_into(bytes: &[u8], place: &mut Calibration) -> Result<u32, RecordError> {
    let header = Header::parse(bytes.first_chunk().ok_or(RecordError::Torn)?)?;
    let record = bytes
        .get(..header.record_bytes())
        .ok_or(RecordError::Torn)?;
    let (message, crc) = record
        .split_last_chunk::<CRC_BYTES>()
        .ok_or(RecordError::Torn)?;
    if CRC32.checksum(message) != u32::from_le_bytes(*crc) {
        return Err(RecordError::Torn);
    }
    if header.version != VERSION {
        return Err(RecordError::UnknownVersion {
            version: header.version,
        });
    }
    let body = message.get(HEADER_BYTES..).ok_or(RecordError::Torn)?;
    match read_body(body, place) {
        Some([]) => {
            place.validate()?;
            Ok(header.sequence)
        }
        _ => Err(RecordError::Body),
    }
}

/// Reads a calibration's postcard bytes field by field, in [`Calibration`]'s order, into its place: the derived way takes four
/// copies, 11 KiB of stack. Returns the bytes behind it. Not checked: see [`Calibration::validate`].
pub fn read_body<'b>(bytes: &'b [u8], place: &mut Calibration) -> Option<&'b [u8]> {
    let mut source = postcard::Deserializer::from_bytes(bytes);
    read(&mut source, &mut place.device)?;
    read(&mut source, &mut place.made)?;
    read(&mut source, &mut place.temperature_c)?;
    read(&mut source, &mut place.method)?;
    read(&mut source, &mut place.gauge)?;
    read(&mut source, &mut place.amplitude_counts)?;
    read(&mut source, &mut place.geometry)?;
    read(&mut source, &mut place.pairs)?;
    read(&mut source, &mut place.model.constants_m)?;
    read(&mut source, &mut place.model.terms)?;
    Rows(&mut place.model.coefficients)
        .deserialize(&mut source)
        .ok()?;
    read(&mut source, &mut place.beacon)?;
    read(&mut source, &mut place.quality)?;
    source.finalize().ok()
}

type Source<'b> = postcard::Deserializer<'b, postcard::de_flavors::Slice<'b>>;

#[inline(never)]
fn read<'b, T: Deserialize<'b>>(source: &mut Source<'b>, place: &mut T) -> Option<()> {
    *place = T::deserialize(source).ok()?;
    Some(())
}

/// Reads rows of coefficients in place.
struct Rows<'a>(&'a mut heapless::Vec<TermCoefficients, MAX_TERMS>);

impl<'de> DeserializeSeed<'de> for Rows<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, source: D) -> Result<(), D::Error> {
        source.deserialize_seq(self)
    }
}

impl<'de> Visitor<'de> for Rows<'_> {
    type Value = ();

    fn expecting(&self, text: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        text.write_str("rows of coefficients")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut rows: A) -> Result<(), A::Error> {
        self.0.clear();
        while let Some(row) = rows.next_element()? {
            let room = self.0.push(row);
            room.map_err(|_| A::Error::invalid_length(MAX_TERMS + 1, &"rows of coefficients"))?;
        }
        Ok(())
    }
}

impl Calibration {
    /// One that corrects nothing, for a geometry; the starting point of a first calibration.
    #[inline(never)]
    pub fn identity(geometry: Geometry) -> Self {
        Self {
            device: [0; 12],
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
        }
    }

    /// Checks that every number can be used.
    ///
    /// # Errors
    /// [`RecordError::Model`] or [`RecordError::NotFinite`].
    pub fn validate(&self) -> Result<(), RecordError> {
        self.model.validate()?;
        let g = &self.geometry;
        let q = &self.quality;
        let beacon = self.beacon.iter().flat_map(|beacon| {
            let noise = [&beacon.segment_sd_m, &beacon.displacement_sd_m];
            beacon.origin_m.iter().chain(&beacon.sensor).chain(noise)
        });
        let pairs = self.pairs.iter().flat_map(|pair| {
            [
                pair.offset_counts[0],
                pair.offset_counts[1],
                pair.gain,
                pair.angle_rad,
            ]
        });
        let geometry = [
            g.pitch_m,
            g.span_m,
            g.lateral_m,
            g.height_m,
            g.lever_m[0],
            g.lever_m[1],
            g.tan_full_scale,
        ];
        let quality = [
            q.residual_before_m,
            q.residual_after_m,
            q.predicted_worst_m,
            q.condition_number,
        ];
        finite("temperature_c", [self.temperature_c])?;
        finite("amplitude_counts", self.amplitude_counts)?;
        finite("geometry", geometry)?;
        finite("pairs", pairs)?;
        finite("beacon", beacon.copied())?;
        finite("quality", quality)
    }
}

fn finite(name: &'static str, values: impl IntoIterator<Item = f32>) -> Result<(), RecordError> {
    if values.into_iter().all(f32::is_finite) {
        Ok(())
    } else {
        Err(RecordError::NotFinite { name })
    }
}
