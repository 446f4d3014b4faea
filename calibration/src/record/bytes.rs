//! A record byte for byte.
//!
//! ```text
//!  byte  0       4      6      8        12         16               16+n   20+n
//!        | magic | ver. | zero | length n | sequence | body, n bytes | CRC-32 |
//!        | CSRC  | u16  | u16  | u32      | u32      | postcard      | u32    |
//! ```
//! Little endian; the CRC (ISO-HDLC, the one of zlib) is over everything before it. Magic, version, length, sequence and the CRC's
//! place are the same in every version, so that a record of a later firmware is recognised, named and left alone. The body of
//! version [`VERSION`](super::VERSION) is [`Calibration`] in postcard's format; a change of its fields is a new version. Version 2 ends
//! before the poses.

use super::{Calibration, OLDEST_VERSION, RecordError, VERSION};
use crate::geometry::Geometry;
use crate::model::{ErrorModel, MAX_TERMS, TermCoefficients};
use crate::sink;
use crc::{CRC_32_ISO_HDLC, Crc, NoTable};
use serde::de::{DeserializeSeed, Error as _, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

/// First bytes of every record. By definition of the layout.
pub const MAGIC: [u8; 4] = *b"CSRC";
/// Magic, version, length and sequence. By definition of the layout: four bytes, two and two zeros, four, four.
pub const HEADER_BYTES: usize = 16;
/// Longest record. Derived from a page of 2,048 bytes less a double word for its mark.
pub const MAX_BYTES: usize = 2040;

/// Most postcard bytes of a calibration of this version. By definition of this version, for buffers; a longer body does not fit
/// the link.
pub const BODY_BYTES: usize = 1168;

/// Bytes of the check value, by definition of a CRC-32.
const CRC_BYTES: usize = 4;
// Without a table: a record is written once in a session, and the table is 1 KiB.
static CRC32: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);

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
    let version = header.version;
    if !(OLDEST_VERSION..=VERSION).contains(&version) {
        return Err(RecordError::UnknownVersion { version });
    }
    let body = message.get(HEADER_BYTES..).ok_or(RecordError::Torn)?;
    match read_version(version, body, place) {
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
    read_version(VERSION, bytes, place)
}

/// [`read_body`] of a body of a known version.
#[inline(never)] // one copy, for size
fn read_version<'b>(version: u16, bytes: &'b [u8], place: &mut Calibration) -> Option<&'b [u8]> {
    let mut source = postcard::Deserializer::from_bytes(bytes);
    read(&mut source, &mut place.device)?;
    read(&mut source, &mut place.made)?;
    read(&mut source, &mut place.temperature_c)?;
    read(&mut source, &mut place.method)?;
    read(&mut source, &mut place.gauge)?;
    read(&mut source, &mut place.amplitude_counts)?;
    read(&mut source, &mut place.geometry)?;
    read(&mut source, &mut place.pairs)?;
    read_rows(&mut source, &mut place.model)?;
    read(&mut source, &mut place.beacon)?;
    read(&mut source, &mut place.quality)?;
    place.poses = None;
    if version != OLDEST_VERSION {
        read(&mut source, &mut place.poses)?;
    }
    source.finalize().ok()
}

/// Reads an error model's postcard bytes into its place, as [`read_body`] does. Returns the bytes behind it.
pub fn read_model<'b>(bytes: &'b [u8], place: &mut ErrorModel) -> Option<&'b [u8]> {
    let mut source = postcard::Deserializer::from_bytes(bytes);
    read_rows(&mut source, place)?;
    source.finalize().ok()
}

#[inline(never)]
fn read_rows(source: &mut Source<'_>, place: &mut ErrorModel) -> Option<()> {
    read(source, &mut place.constants_m)?;
    read(source, &mut place.terms)?;
    let rows = Rows(&mut place.coefficients);
    rows.deserialize(source).ok()
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
