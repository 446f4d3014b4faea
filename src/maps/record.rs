//! A stored tooth map byte for byte.
//!
//! ```text
//!  byte  0       4      6        8       10     12        16       20       24         24+h, to 8 bytes
//!        | magic | ver. | head h | nodes | zero | sequence | CRC-32 | inverse | head     | nodes         |
//!        | CSTM  | u16  | u16    | u16   | u16  | u32      | u32    | of it   | postcard | i16 each, nm  |
//! ```
//! Little endian; the CRC (ISO-HDLC) is over bytes 0 to 15 and everything behind byte 23. Magic, version, lengths, sequence and CRC
//! are the same in every version, so that a later firmware's map is recognised and left alone. The head of version [`VERSION`] is
//! [`MapInfo`], the error model and the map's header in postcard's format. The first 24 bytes are written last: a map without them
//! is none.

use super::homing::Anchor;
use crate::device::Device;
use crate::model::ErrorModel;
use crate::sink;
use crate::teeth::{MAX_NODES, MapHeader};
use crc::{CRC_32_ISO_HDLC, Crc, NoTable};
use heapless::String;
use serde::{Deserialize, Serialize};

/// First bytes of every stored map.
pub const MAGIC: [u8; 4] = *b"CSTM";
/// Layout version that this firmware writes and reads.
pub const VERSION: u16 = 1;
/// Bytes before the head.
pub const HEADER_BYTES: usize = 24;
/// Longest head, in whole double words: what a slot leaves beside the header, the most nodes and the mark at its end.
pub const MAX_HEAD_BYTES: usize = 2040;
/// Part of the header that the CRC covers.
const COVERED_BYTES: usize = 16;
/// A head longer than this begins with no more than [`MapInfo`].
pub(super) const INFO_BYTES: usize = 80;

// Without a table, as for calibrations: maps are checked at a start and when one is stored.
static CRC32: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);

/// Name of a place: printable characters, 1 to 16.
pub type Name = String<16>;

/// What a board needs to know of a stored map before it reads the rest.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MapInfo {
    /// The board that stored it. It counts on this board alone.
    pub device: Device,
    /// Name of the place. Of maps of one name the newest counts.
    pub name: Name,
    /// Check value of the stored calibration in force with which it was stored: it counts beside that one alone.
    pub calibration: u32,
    /// The beacon in the tooth count of the map's recording.
    pub anchor: Anchor,
    /// g_p that was left with the map on held-out poses, their noise taken off, metres rms.
    pub parity_m: f32,
}

/// What is stored before the nodes.
#[derive(Debug, Serialize)]
pub struct MapHead<'a> {
    /// What it is of.
    pub info: &'a MapInfo,
    /// Equations (3) and (9) as fitted with the map: in force together with it.
    pub model: &'a ErrorModel,
    /// Lattices in the tooth count of the map's recording, waves, trusted cells.
    pub header: &'a MapHeader,
}

/// Why a slot's bytes are no map that can be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
#[non_exhaustive]
pub enum MapRecordError {
    /// Erased flash.
    #[error("empty")]
    Empty,
    /// Neither erased nor a whole map.
    #[error("torn: its writing was cut off, or it decayed")]
    Torn,
    /// The flash could not be read there.
    #[error("the flash could not be read")]
    Unreadable,
    /// A whole map of a layout that this firmware does not know.
    #[error("layout version {0} is not known to the board's firmware")]
    UnknownVersion(u16),
    /// A whole map that another board stored.
    #[error("it is of another board, {0}")]
    OtherDevice(Device),
    /// A whole map with numbers that cannot be used.
    #[error("its numbers cannot be used")]
    Invalid,
}

impl MapInfo {
    /// Checks every number and the name.
    ///
    /// # Errors
    /// [`MapRecordError::Invalid`].
    pub fn validate(&self) -> Result<(), MapRecordError> {
        let is_named =
            !self.name.is_empty() && self.name.bytes().all(|byte| byte.is_ascii_graphic());
        // A g_p of a millimetre is another tooth.
        let is_known = (0.0..=1.0e-3).contains(&self.parity_m);
        match is_named && is_known && self.anchor.is_possible() {
            true => Ok(()),
            false => Err(MapRecordError::Invalid),
        }
    }
}

impl MapHead<'_> {
    /// Writes the head to the start of `buffer`; none if it does not fit.
    pub fn encode<'b>(&self, buffer: &'b mut [u8]) -> Option<&'b [u8]> {
        let most = buffer.len().min(MAX_HEAD_BYTES);
        sink::write(self, buffer.get_mut(..most)?)
    }
}

/// The first 24 bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Header {
    pub version: u16,
    pub head_bytes: u16,
    pub nodes: u16,
    pub sequence: u32,
    pub crc: u32,
}

impl Header {
    /// Of this version.
    pub const fn new(head_bytes: u16, nodes: u16, sequence: u32) -> Self {
        Self {
            version: VERSION,
            head_bytes,
            nodes,
            sequence,
            crc: 0,
        }
    }

    /// Takes it apart.
    pub fn parse(bytes: &[u8; HEADER_BYTES]) -> Result<Self, MapRecordError> {
        if bytes.iter().all(|byte| *byte == 0xFF) {
            return Err(MapRecordError::Empty);
        }
        let [
            m0,
            m1,
            m2,
            m3,
            v0,
            v1,
            h0,
            h1,
            n0,
            n1,
            z0,
            z1,
            s0,
            s1,
            s2,
            s3,
            c0,
            c1,
            c2,
            c3,
            i0,
            i1,
            i2,
            i3,
        ] = *bytes;
        let [version, head_bytes, nodes] = [[v0, v1], [h0, h1], [n0, n1]].map(u16::from_le_bytes);
        let [sequence, crc, inverse] =
            [[s0, s1, s2, s3], [c0, c1, c2, c3], [i0, i1, i2, i3]].map(u32::from_le_bytes);
        let fits = usize::from(head_bytes) <= MAX_HEAD_BYTES && usize::from(nodes) <= MAX_NODES;
        if [m0, m1, m2, m3] != MAGIC || [z0, z1] != [0, 0] || inverse != !crc || !fits {
            return Err(MapRecordError::Torn);
        }
        Ok(Self {
            version,
            head_bytes,
            nodes,
            sequence,
            crc,
        })
    }

    /// Its bytes.
    pub fn encode(&self) -> [u8; HEADER_BYTES] {
        let mut bytes = [0; HEADER_BYTES];
        bytes[..4].copy_from_slice(&MAGIC);
        bytes[4..6].copy_from_slice(&self.version.to_le_bytes());
        bytes[6..8].copy_from_slice(&self.head_bytes.to_le_bytes());
        bytes[8..10].copy_from_slice(&self.nodes.to_le_bytes());
        bytes[12..16].copy_from_slice(&self.sequence.to_le_bytes());
        bytes[16..20].copy_from_slice(&self.crc.to_le_bytes());
        bytes[20..].copy_from_slice(&(!self.crc).to_le_bytes());
        bytes
    }

    /// The check, begun with what of the header it covers.
    pub fn digest(&self) -> Digest {
        let mut digest = CRC32.digest();
        digest.update(&self.encode()[..COVERED_BYTES]);
        digest
    }

    /// Bytes of the head with what fills its last double word.
    pub const fn padded_head_bytes(&self) -> u32 {
        (self.head_bytes as u32).next_multiple_of(8)
    }

    /// Bytes behind the header, in whole double words.
    pub const fn body_bytes(&self) -> u32 {
        self.padded_head_bytes() + (2 * self.nodes as u32).next_multiple_of(8)
    }
}

/// A check under way.
pub(super) type Digest = crc::Digest<'static, u32, NoTable>;
