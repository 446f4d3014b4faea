//! A conversion frame's bytes: pure, so that a board that reads by DMA decodes them with the same function.

use super::error::ChipError;
use crc::{Algorithm, Crc};

/// Channels of one chip.
pub const CHANNELS: usize = 8;
/// Eight words and their CRC.
pub const FRAME_BYTES: usize = 2 * CHANNELS + 2;

/// CRC of a conversion frame: 0x755B from zero over the sixteen data bytes; one table of 512 bytes, a look-up a byte.
pub static CRC16: Crc<u16> = Crc::<u16>::new(&Algorithm {
    width: 16,
    poly: 0x755B,
    init: 0,
    refin: false,
    refout: false,
    xorout: 0,
    check: 0x20FE,
    residue: 0,
});

/// A frame as it came over the wire.
pub type FrameBytes = [u8; FRAME_BYTES];

/// Counts of channels 1 to 8 from a frame as it came over the wire. Runs in the interrupt: no loop without a bound, no panic.
///
/// # Errors
/// [`ChipError::FrameCrc`] or [`ChipError::Silent`].
pub fn decode_frame(bytes: &FrameBytes) -> Result<[i16; CHANNELS], ChipError> {
    let [data @ .., _, _] = bytes;
    check_frame(bytes, |_| CRC16.checksum(data))?;
    let pairs = pairs(bytes);
    Ok(core::array::from_fn(|channel| {
        pairs[channel / 2][channel % 2]
    }))
}

/// Whether a frame holds what the chip has sent: its CRC, by a function that computes [`CRC16`] over the data, given as [`words`], and not
/// all zeros.
///
/// # Errors
/// As [`decode_frame`].
#[inline(always)]
pub fn check_frame(
    bytes: &FrameBytes,
    checksum: impl FnOnce([u32; CHANNELS / 2]) -> u16,
) -> Result<(), ChipError> {
    let [data @ .., high, low] = bytes;
    let received = u16::from_be_bytes([*high, *low]);
    let [a, b, c, d] = words(data);
    // Of words that are at hand: looked at afterwards they would be loaded anew.
    let any = a | b | c | d;
    let computed = checksum([a, b, c, d]);
    if received != computed {
        return Err(ChipError::FrameCrc { received, computed });
    }
    match any {
        0 => Err(ChipError::Silent),
        _ => Ok(()),
    }
}

/// Counts of channels 1 and 2, 3 and 4, and so on; nothing is checked.
#[inline(always)]
pub fn pairs(bytes: &FrameBytes) -> [[i16; 2]; CHANNELS / 2] {
    let [data @ .., _, _] = bytes;
    let [a, b, c, d] = words(data);
    [pair(a), pair(b), pair(c), pair(d)]
}

/// The data as words whose most significant byte came first.
#[inline(always)]
pub fn words(data: &[u8; 2 * CHANNELS]) -> [u32; CHANNELS / 2] {
    let [
        a0,
        a1,
        a2,
        a3,
        b0,
        b1,
        b2,
        b3,
        c0,
        c1,
        c2,
        c3,
        d0,
        d1,
        d2,
        d3,
    ] = *data;
    [
        u32::from_be_bytes([a0, a1, a2, a3]),
        u32::from_be_bytes([b0, b1, b2, b3]),
        u32::from_be_bytes([c0, c1, c2, c3]),
        u32::from_be_bytes([d0, d1, d2, d3]),
    ]
}

#[inline(always)]
fn pair(word: u32) -> [i16; 2] {
    [(word >> 16) as i16, word as i16]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The polynomial as the data sheet writes it, divided bit by bit.
    fn long_division(data: &[u8]) -> u16 {
        let exponents = [14, 13, 12, 10, 8, 6, 4, 3, 1, 0];
        let polynomial = exponents.iter().fold(0u16, |sum, bit| sum | 1 << bit);
        let mut remainder = 0u16;
        for bit in data
            .iter()
            .flat_map(|byte| (0..8).rev().map(move |n| byte >> n & 1))
        {
            let out = (remainder >> 15) as u8 ^ bit;
            remainder = remainder << 1 ^ if out == 1 { polynomial } else { 0 };
        }
        remainder
    }

    fn frame(counts: [i16; CHANNELS]) -> [u8; FRAME_BYTES] {
        let mut bytes = [0; FRAME_BYTES];
        for (index, count) in counts.iter().enumerate() {
            bytes[2 * index..][..2].copy_from_slice(&count.to_be_bytes());
        }
        let crc = long_division(&bytes[..16]);
        bytes[16..].copy_from_slice(&crc.to_be_bytes());
        bytes
    }

    #[test]
    fn decodes_what_long_division_signed() {
        let counts = [1, -1, i16::MAX, i16::MIN, 12345, -12345, 0, 256];
        assert_eq!(decode_frame(&frame(counts)), Ok(counts));
    }

    #[test]
    fn every_single_and_double_bit_error_is_refused() {
        let good = frame([20000, -3, 77, 0, -20000, 12, 9, -1]);
        for first in 0..8 * FRAME_BYTES {
            for second in first..8 * FRAME_BYTES {
                let mut bad = good;
                bad[first / 8] ^= 1 << (first % 8);
                if second != first {
                    bad[second / 8] ^= 1 << (second % 8);
                }
                assert!(
                    matches!(decode_frame(&bad), Err(ChipError::FrameCrc { .. })),
                    "bits {first}, {second}"
                );
            }
        }
    }

    #[test]
    fn check_value_is_the_algorithms() {
        assert_eq!(CRC16.checksum(b"123456789"), CRC16.algorithm.check);
        assert_eq!(long_division(b"123456789"), CRC16.algorithm.check);
    }

    #[test]
    fn dead_lines_are_refused() {
        assert_eq!(decode_frame(&[0x00; FRAME_BYTES]), Err(ChipError::Silent));
        assert!(matches!(
            decode_frame(&[0xFF; FRAME_BYTES]),
            Err(ChipError::FrameCrc { .. })
        ));
    }
}
