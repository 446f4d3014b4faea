//! Messages on a byte channel: postcard, CRC-32, COBS, zero as delimiter on both sides.
//!
//! ```text
//! | 0x00 | COBS( postcard(message) | CRC-32 little endian ) | 0x00 |
//! ```
//! The leading zero ends whatever noise came before, so that noise costs no good frame. A receiver that starts in the middle of a
//! frame loses that frame alone. CRC-32/ISCSI catches every error of up to 5 bits in the decoded bytes of a message below 655 bytes
//! (Koopman 2002).

use crate::sink;
use crate::update::header::CRC32; // its table is 1 KiB, once for both
use cobs::CobsEncoder;
use core::ops::Range;
use serde::Serialize;
use serde::de::DeserializeOwned;

const CRC_BYTES: usize = 4;
/// Longest head of [`encode_with_body`] and the length behind it.
const HEAD_BYTES: usize = 32;

/// Bytes that a message of so many postcard bytes can take on the wire at most.
pub const fn encoded_bytes(message_bytes: usize) -> usize {
    let inner = message_bytes + CRC_BYTES;
    inner + inner / 254 + 1 + 2
}

/// The message does not fit the buffer it was to be encoded into.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooLong {
    /// What there was room for, bytes.
    pub room: usize,
}

impl core::fmt::Display for TooLong {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "the message does not fit {} bytes", self.room)
    }
}

impl core::error::Error for TooLong {}

/// Encodes one message with its delimiters; returns the bytes to send.
///
/// # Errors
/// [`TooLong`]; the buffer's contents are then of no use.
pub fn encode<'a, T: Serialize>(message: &T, buffer: &'a mut [u8]) -> Result<&'a [u8], TooLong> {
    frame(buffer, |put| sink::pour(message, put))
}

/// As [`encode`], of a message that ends in a list of bytes: `head` is what stands before the list. The same bytes on the
/// wire, at a third of the cost: telemetry has 20 000 samples a second to encode.
///
/// # Errors
/// [`TooLong`]; the buffer's contents are then of no use.
pub fn encode_with_body<'a, T: Serialize>(
    head: &T,
    body: &[u8],
    buffer: &'a mut [u8],
) -> Result<&'a [u8], TooLong> {
    frame(buffer, |put| {
        let mut short = [0; HEAD_BYTES];
        // Not by way of a sink: no call through a pointer, on a stack that is small.
        let head = postcard::to_slice(&(head, body.len()), &mut short);
        head.is_ok_and(|head| put(head) && put(body))
    })
}

/// Delimiters, COBS and CRC around what `fill` gives in pieces to the function that it is given.
fn frame(
    buffer: &mut [u8],
    fill: impl FnOnce(&mut dyn FnMut(&[u8]) -> bool) -> bool,
) -> Result<&[u8], TooLong> {
    let room = buffer.len();
    let full = TooLong { room };
    let (first, rest) = buffer.split_first_mut().ok_or(full)?;
    *first = 0;
    let (mut cobs, mut digest) = (CobsEncoder::new(rest), CRC32.digest());
    let filled = fill(&mut |piece| {
        digest.update(piece);
        // The encoder counts one too many for a piece of nothing.
        piece.is_empty() || cobs.push(piece).is_ok()
    });
    let crc = digest.finalize().to_le_bytes();
    if !filled || cobs.push(&crc).is_err() {
        return Err(full);
    }
    let end = 1 + cobs.finalize();
    *buffer.get_mut(end).ok_or(full)? = 0;
    buffer.get(..=end).ok_or(full)
}

/// Why a frame was thrown away.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FrameError {
    /// Longer than the receiver allows.
    TooLong,
    /// Not a COBS frame with room for a CRC: noise or half a frame.
    Malformed,
    /// The CRC does not match.
    Crc,
    /// A good frame that is no message of the expected kind.
    Unknown,
}

/// What a receiver has seen; each count saturates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, serde::Deserialize)]
pub struct FrameCounters {
    /// Messages.
    pub good: u32,
    /// [`FrameError::TooLong`].
    pub too_long: u32,
    /// [`FrameError::Malformed`].
    pub malformed: u32,
    /// [`FrameError::Crc`].
    pub crc: u32,
    /// [`FrameError::Unknown`].
    pub unknown: u32,
}

impl FrameCounters {
    fn count(&mut self, error: FrameError) {
        let counter = match error {
            FrameError::TooLong => &mut self.too_long,
            FrameError::Malformed => &mut self.malformed,
            FrameError::Crc => &mut self.crc,
            FrameError::Unknown => &mut self.unknown,
        };
        *counter = counter.saturating_add(1);
    }

    /// Frames thrown away.
    pub const fn bad(&self) -> u32 {
        self.too_long
            .saturating_add(self.malformed)
            .saturating_add(self.crc)
            .saturating_add(self.unknown)
    }
}

/// Collects bytes into frames of at most `N` bytes between delimiters. Never panics, whatever comes.
#[derive(Clone, Debug)]
pub struct Decoder<const N: usize> {
    buffer: [u8; N],
    len: usize,
    overflowed: bool,
    /// What a message of [`Decoder::feed_head`] left over; good until the next byte.
    rest: Range<usize>,
    counters: FrameCounters,
}

impl<const N: usize> Default for Decoder<N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize> Decoder<N> {
    /// An empty receiver.
    pub const fn new() -> Self {
        let counters = FrameCounters {
            good: 0,
            too_long: 0,
            malformed: 0,
            crc: 0,
            unknown: 0,
        };
        Self {
            buffer: [0; N],
            len: 0,
            overflowed: false,
            rest: 0..0,
            counters,
        }
    }

    /// What it has seen so far.
    pub const fn counters(&self) -> FrameCounters {
        self.counters
    }

    /// Takes one byte. `Some` when it ends a frame that is not empty: the message, or why there is none (also counted).
    pub fn feed<T: DeserializeOwned>(&mut self, byte: u8) -> Option<Result<T, FrameError>> {
        self.feed_head(byte, |_| false)
    }

    /// The same for a message that may have more behind it, where `has_rest` says so: [`Decoder::rest`] has that.
    pub fn feed_head<T: DeserializeOwned>(
        &mut self,
        byte: u8,
        has_rest: fn(&T) -> bool,
    ) -> Option<Result<T, FrameError>> {
        if byte != 0 {
            self.store(byte);
            return None;
        }
        if self.len == 0 && !self.overflowed {
            return None;
        }
        self.rest = 0..0;
        let result = self.finish(has_rest);
        self.len = 0;
        self.overflowed = false;
        match &result {
            Ok(_) => self.counters.good = self.counters.good.saturating_add(1),
            Err(error) => self.counters.count(*error),
        }
        Some(result)
    }

    /// Bytes behind the last message, until the next byte is fed.
    pub fn rest(&self) -> &[u8] {
        self.buffer.get(self.rest.clone()).unwrap_or_default()
    }

    fn store(&mut self, byte: u8) {
        match self.buffer.get_mut(self.len) {
            Some(slot) => {
                *slot = byte;
                self.len += 1;
            }
            None => self.overflowed = true,
        }
    }

    fn finish<T: DeserializeOwned>(&mut self, has_rest: fn(&T) -> bool) -> Result<T, FrameError> {
        if self.overflowed {
            return Err(FrameError::TooLong);
        }
        let frame = self
            .buffer
            .get_mut(..self.len)
            .ok_or(FrameError::Malformed)?;
        let decoded = cobs::decode_in_place(frame).map_err(|_| FrameError::Malformed)?;
        let (message, crc) = frame
            .get(..decoded)
            .and_then(|bytes| bytes.split_last_chunk::<CRC_BYTES>())
            .ok_or(FrameError::Malformed)?;
        if CRC32.checksum(message) != u32::from_le_bytes(*crc) {
            return Err(FrameError::Crc);
        }
        let (value, rest) = postcard::take_from_bytes(message).map_err(|_| FrameError::Unknown)?;
        if !rest.is_empty() && !has_rest(&value) {
            return Err(FrameError::Unknown);
        }
        self.rest = message.len() - rest.len()..message.len();
        Ok(value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Message = (u32, [u8; 8], Option<i16>);
    const MESSAGE: Message = (70_000, [0, 1, 0, 0, 255, 0, 3, 0], Some(-5));

    fn feed_all<const N: usize>(
        decoder: &mut Decoder<N>,
        bytes: &[u8],
    ) -> heapless::Vec<Result<Message, FrameError>, 8> {
        bytes
            .iter()
            .filter_map(|&byte| decoder.feed(byte))
            .collect()
    }

    #[test]
    fn a_message_survives_the_way() {
        let mut buffer = [0; 64];
        let bytes = encode(&MESSAGE, &mut buffer).unwrap();
        assert_eq!((bytes[0], bytes[bytes.len() - 1]), (0, 0));
        assert!(bytes[1..bytes.len() - 1].iter().all(|&byte| byte != 0));
        let mut decoder = Decoder::<64>::new();
        assert_eq!(feed_all(&mut decoder, bytes), [Ok(MESSAGE)]);
        assert_eq!(feed_all(&mut decoder, bytes), [Ok(MESSAGE)]);
        assert_eq!(
            decoder.counters(),
            FrameCounters {
                good: 2,
                ..Default::default()
            }
        );
    }

    #[test]
    fn noise_half_frames_and_long_ones_cost_no_good_frame() {
        let mut buffer = [0; 64];
        let bytes = encode(&MESSAGE, &mut buffer).unwrap();
        let mut decoder = Decoder::<32>::new();
        assert_eq!(feed_all(&mut decoder, &[7, 9, 200]), []);
        assert_eq!(
            feed_all(&mut decoder, bytes),
            [Err(FrameError::Malformed), Ok(MESSAGE)]
        );
        assert_eq!(feed_all(&mut decoder, &bytes[..bytes.len() / 2]), []);
        let after_half = feed_all(&mut decoder, bytes);
        assert_eq!((after_half.len(), after_half[1]), (2, Ok(MESSAGE)));
        assert!(after_half[0].is_err());
        assert_eq!(feed_all(&mut decoder, &[1; 1000]), []);
        assert_eq!(
            feed_all(&mut decoder, bytes),
            [Err(FrameError::TooLong), Ok(MESSAGE)]
        );
        assert_eq!(decoder.counters().good, 3);
        assert_eq!(decoder.counters().bad(), 3);
    }

    #[test]
    fn every_flipped_bit_is_noticed() {
        let mut buffer = [0; 64];
        let good: heapless::Vec<u8, 64> = encode(&MESSAGE, &mut buffer)
            .unwrap()
            .iter()
            .copied()
            .collect();
        for bit in 8..8 * (good.len() - 1) {
            let mut bad = good.clone();
            bad[bit / 8] ^= 1 << (bit % 8);
            let mut decoder = Decoder::<64>::new();
            assert!(
                feed_all(&mut decoder, &bad).iter().all(Result::is_err),
                "bit {bit}"
            );
        }
    }

    #[test]
    fn a_message_with_more_behind_it_is_unknown() {
        let mut buffer = [0; 64];
        let bytes = encode(&(MESSAGE, 1u8), &mut buffer).unwrap();
        assert_eq!(
            feed_all(&mut Decoder::<64>::new(), bytes),
            [Err(FrameError::Unknown)]
        );
    }

    #[test]
    fn too_small_a_buffer_is_an_error() {
        for room in 0..20 {
            assert_eq!(
                encode(&MESSAGE, &mut [0; 64][..room]),
                Err(TooLong { room })
            );
        }
    }

    #[test]
    fn the_bound_on_the_wire_holds() {
        for length in [
            0usize, 1, 249, 250, 251, 252, 253, 254, 255, 503, 504, 505, 506, 900,
        ] {
            for fill in [0u8, 1] {
                let message: heapless::Vec<u8, 1000> = core::iter::repeat_n(fill, length).collect();
                let mut buffer = [0; 1100];
                let prefix = if length < 128 { 1 } else { 2 };
                let bytes = encode(&message.as_slice(), &mut buffer).unwrap().len();
                assert!(bytes <= encoded_bytes(length + prefix), "{length}: {bytes}");
            }
        }
    }
}
