//! What an image says of itself, before its body.
//!
//! ```text
//! |   0 | b"COURIER" and the header's layout, 1          |   8 B |
//! |   8 | name of the board, padded with zeros           |  16 B |
//! |  24 | version: major, minor, patch, zero             |   8 B |
//! |  32 | length of the body, a multiple of 8            |   4 B |
//! |  36 | CRC-32/ISCSI of the body                       |   4 B |
//! |  40 | public key of the signature                    |  32 B |
//! |  72 | Ed25519 signature of bytes 0 to 71 and body    |  64 B |
//! | 136 | CRC-32/ISCSI of bytes 0 to 135, and zeros      |   8 B |
//! ```
//! Numbers are little endian. An image's file is the header, 0xFF up to [`HEADER_ROOM`], and the body.

use super::key::PublicKey;
use super::layout::{HEADER_ROOM, MOST_BODY_BYTES, WORD_BYTES};
use super::version::Version;
use crc::{CRC_32_ISCSI, Crc, NoTable};

/// CRC of a body.
pub static CRC32: Crc<u32> = Crc::<u32>::new(&CRC_32_ISCSI);
/// The same for a header and for a mark, without a table: these are short, and the first stage has no room for one.
pub static SHORT_CRC32: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISCSI);
/// Polynomial and first value, for a unit of the chip's that does the same.
pub const CRC32_POLYNOMIAL: u32 = CRC_32_ISCSI.poly;
/// First value.
pub const CRC32_INITIAL: u32 = CRC_32_ISCSI.init;

/// Bytes of a header.
pub const BYTES: usize = 144;
/// What the signature covers of it: everything before itself.
pub const SIGNED_BYTES: usize = 72;
/// Bytes of a signature.
pub const SIGNATURE_BYTES: usize = 64;
const NAME_BYTES: usize = 16;
const CHECKED_BYTES: usize = SIGNED_BYTES + SIGNATURE_BYTES;
const MAGIC: [u8; 7] = *b"COURIER";
/// Layout of the header that this firmware knows.
pub const LAYOUT: u8 = 1;

const _: () = assert!(
    BYTES.is_multiple_of(WORD_BYTES as usize) && BYTES + 8 <= HEADER_ROOM as usize,
    "whole double words, and room for the number behind"
);

/// A header, taken apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Header {
    /// Name of the board that it is for, padded with zeros.
    pub board: [u8; NAME_BYTES],
    /// The image's version.
    pub version: Version,
    /// Length of the body.
    pub body_bytes: u32,
    /// CRC of the body.
    pub body_crc: u32,
    /// Whose signature it is.
    pub key: PublicKey,
    /// Over [`Header::signed`] and the body.
    pub signature: [u8; SIGNATURE_BYTES],
}

/// Why some bytes are no header.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum HeaderError {
    /// Something else, or nothing.
    #[error("no image of this firmware")]
    NoImage,
    /// A later tool made it.
    #[error("header of layout {found}, wanted {LAYOUT}")]
    Layout {
        /// Its layout.
        found: u8,
    },
    /// The check value is wrong.
    #[error("the header is damaged")]
    Damaged,
    /// A body that is empty, too long or not whole double words.
    #[error("a body of {found} bytes, wanted 8 to {MOST_BODY_BYTES} in steps of 8")]
    Length {
        /// Its length.
        found: u32,
    },
}

impl Header {
    /// Takes it apart.
    ///
    /// # Errors
    /// [`HeaderError`].
    pub fn parse(bytes: &[u8; BYTES]) -> Result<Self, HeaderError> {
        let mut rest = Reader(bytes);
        let (magic, layout) = (rest.take::<7>(), rest.take::<1>()[0]);
        if magic != MAGIC {
            return Err(HeaderError::NoImage);
        }
        if layout != LAYOUT {
            return Err(HeaderError::Layout { found: layout });
        }
        let crc = SHORT_CRC32.checksum(&bytes[..CHECKED_BYTES]);
        if bytes[CHECKED_BYTES..CHECKED_BYTES + 4] != crc.to_le_bytes() {
            return Err(HeaderError::Damaged);
        }
        let board = rest.take();
        let [major, minor, patch, _] = [(); 4].map(|()| u16::from_le_bytes(rest.take()));
        let header = Self {
            board,
            version: Version {
                major,
                minor,
                patch,
            },
            body_bytes: u32::from_le_bytes(rest.take()),
            body_crc: u32::from_le_bytes(rest.take()),
            key: rest.take(),
            signature: rest.take(),
        };
        let found = header.body_bytes;
        let fits = (WORD_BYTES..=MOST_BODY_BYTES).contains(&found);
        if fits && found.is_multiple_of(WORD_BYTES) {
            Ok(header)
        } else {
            Err(HeaderError::Length { found })
        }
    }

    /// The bytes.
    pub fn encode(&self) -> [u8; BYTES] {
        let mut bytes = [0; BYTES];
        bytes[..SIGNED_BYTES].copy_from_slice(&self.signed());
        bytes[SIGNED_BYTES..CHECKED_BYTES].copy_from_slice(&self.signature);
        let crc = SHORT_CRC32.checksum(&bytes[..CHECKED_BYTES]);
        bytes[CHECKED_BYTES..CHECKED_BYTES + 4].copy_from_slice(&crc.to_le_bytes());
        bytes
    }

    /// What is signed of it.
    pub fn signed(&self) -> [u8; SIGNED_BYTES] {
        let Version {
            major,
            minor,
            patch,
        } = self.version;
        let mut bytes = [0; SIGNED_BYTES];
        bytes[..7].copy_from_slice(&MAGIC);
        bytes[7] = LAYOUT;
        bytes[8..24].copy_from_slice(&self.board);
        for (place, number) in bytes[24..].chunks_exact_mut(2).zip([major, minor, patch]) {
            place.copy_from_slice(&number.to_le_bytes());
        }
        bytes[32..36].copy_from_slice(&self.body_bytes.to_le_bytes());
        bytes[36..40].copy_from_slice(&self.body_crc.to_le_bytes());
        bytes[40..72].copy_from_slice(&self.key);
        bytes
    }

    /// Name of the board, as text.
    pub fn board_name(&self) -> &str {
        let end = self.board.iter().position(|byte| *byte == 0);
        let name = &self.board[..end.unwrap_or(NAME_BYTES)];
        core::str::from_utf8(name).unwrap_or("?")
    }
}

/// A board's name as a header has it; what is beyond 16 bytes is left out.
pub const fn board(name: &str) -> [u8; NAME_BYTES] {
    let (from, mut to, mut at) = (name.as_bytes(), [0; NAME_BYTES], 0);
    while at < from.len() && at < NAME_BYTES {
        to[at] = from[at];
        at += 1;
    }
    to
}

struct Reader<'b>(&'b [u8]);

impl Reader<'_> {
    /// The next bytes; zeros behind the end.
    fn take<const N: usize>(&mut self) -> [u8; N] {
        match self.0.split_first_chunk() {
            Some((first, rest)) => {
                self.0 = rest;
                *first
            }
            None => [0; N],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header() -> Header {
        Header {
            board: board("g474"),
            version: Version {
                major: 1,
                minor: 22,
                patch: 333,
            },
            body_bytes: 4096,
            body_crc: 0x1234_5678,
            key: [7; 32],
            signature: [9; 64],
        }
    }

    #[test]
    fn what_is_encoded_is_read_back() {
        let header = header();
        assert_eq!(Header::parse(&header.encode()), Ok(header));
        assert_eq!(header.encode()[..SIGNED_BYTES], header.signed());
        assert_eq!(header.board_name(), "g474");
    }

    #[test]
    fn every_flipped_bit_is_found() {
        let whole = header().encode();
        for bit in 0..8 * (CHECKED_BYTES + 4) {
            let mut bytes = whole;
            bytes[bit / 8] ^= 1 << (bit % 8);
            assert!(Header::parse(&bytes).is_err(), "bit {bit}");
        }
    }

    #[test]
    fn lengths_that_no_bank_can_hold_are_refused() {
        for found in [0, 4, 12, MOST_BODY_BYTES + 8, u32::MAX] {
            let header = Header {
                body_bytes: found,
                ..header()
            };
            let parsed = Header::parse(&header.encode());
            assert_eq!(parsed, Err(HeaderError::Length { found }));
        }
        let most = Header {
            body_bytes: MOST_BODY_BYTES,
            ..header()
        };
        assert!(Header::parse(&most.encode()).is_ok());
        assert_eq!(Header::parse(&[0xFF; BYTES]), Err(HeaderError::NoImage));
    }
}
