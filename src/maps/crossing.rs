//! The board's own reference mark: where in its count the mark's input switches on, and how that place lies in flash beside a map.
//!
//! The place is the courier's at the edge from off to on, by the frames before and after the edge, which may lie no further apart than the
//! frames of a window under the beacon. The input must stay on for a moment: contacts bounce, and a spike is no mark. A mark is to be
//! crossed on the way on which it was learned; one that is wider than a quarter of a tooth has another edge on the other side.

use super::homing::{MOST_SPREAD_TURNS, is_doubtful};
use super::mark::is_slow;
use crate::frame::{Coordinate, Frame};
use crc::{CRC_32_ISO_HDLC, Crc, NoTable};

/// So long the input stays on, seconds. A prior: contacts bounce for some milliseconds; at the fastest the courier goes on by 0.1 mm.
const HOLD_S: f32 = 0.01;

/// Follows the input.
#[derive(Clone, Debug, Default)]
pub struct Crossing {
    was_off: bool,
    before: [Coordinate; 2],
    /// Of an edge that may still be a bounce: its place, and the frame's number.
    edge: Option<([Coordinate; 2], u32)>,
    last: Option<[Coordinate; 2]>,
}

impl Crossing {
    /// Takes a frame and the input's level at its time; where the mark was crossed, once it is sure. `rate_hz`: of sampling.
    #[inline(never)]
    pub fn look(&mut self, frame: &Frame, is_on: bool, rate_hz: f32) -> Option<[Coordinate; 2]> {
        if is_doubtful(frame) {
            // The count is another one from here on.
            *self = Self::default();
            return None;
        }
        let here = [frame.pose.x, frame.pose.y];
        let before = core::mem::replace(&mut self.before, here);
        let was_off = core::mem::replace(&mut self.was_off, !is_on);
        if !is_on {
            self.edge = None;
            return None;
        }
        let is_near = |axis: usize| here[axis].minus_turns(before[axis]).abs() <= MOST_SPREAD_TURNS;
        if was_off && is_slow(frame) && is_near(0) && is_near(1) {
            self.edge = Some((here, frame.sequence));
        }
        let (place, since) = self.edge?;
        let is_sure = frame.sequence.wrapping_sub(since) as f32 >= HOLD_S * rate_hz;
        if is_sure {
            (self.edge, self.last) = (None, Some(place));
        }
        is_sure.then_some(place)
    }

    /// Where it was crossed last, in the board's count.
    #[must_use]
    pub fn last(&self) -> Option<[Coordinate; 2]> {
        self.last
    }
}

/// Bytes of a mark's place in flash, whole double words.
///
/// ```text
/// | x: teeth i32, fraction f32 | y: the same | CRC-32 of these 16 bytes | zero, 4 B |
/// ```
pub const BYTES: usize = 24;

static CRC32: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);

/// A mark's place in a map's count, as bytes.
#[must_use]
pub fn to_bytes(place: &[Coordinate; 2]) -> [u8; BYTES] {
    let mut bytes = [0; BYTES];
    let [x, y] = place;
    let words = [
        x.teeth.cast_unsigned(),
        x.fraction_turns.to_bits(),
        y.teeth.cast_unsigned(),
        y.fraction_turns.to_bits(),
    ];
    for (bytes, word) in bytes.as_chunks_mut().0.iter_mut().zip(words) {
        *bytes = word.to_le_bytes();
    }
    let crc = CRC32.checksum(&bytes[..16]);
    bytes[16..20].copy_from_slice(&crc.to_le_bytes());
    bytes
}

/// The place, if the bytes are one.
#[must_use]
pub fn from_bytes(bytes: &[u8; BYTES]) -> Option<[Coordinate; 2]> {
    let words = bytes.as_chunks().0;
    let word = |index: usize| u32::from_le_bytes(words[index]);
    let place = [0, 2].map(|first| Coordinate {
        teeth: word(first).cast_signed(),
        fraction_turns: f32::from_bits(word(first + 1)),
    });
    (to_bytes(&place) == *bytes).then_some(place)
}
