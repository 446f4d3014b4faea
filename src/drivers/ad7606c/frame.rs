//! A conversion frame's bytes: pure, so that a board that reads by DMA decodes them with the same function.

use super::ChipError;
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

/// Counts of channels 1 to 8 from a frame as it came over the wire. Runs in the interrupt: no loop without a bound, no panic.
///
/// # Errors
/// [`ChipError::FrameCrc`] or [`ChipError::Silent`].
pub fn decode_frame(bytes: &[u8; FRAME_BYTES]) -> Result<[i16; CHANNELS], ChipError> {
    let [data @ .., high, low] = bytes;
    let received = u16::from_be_bytes([*high, *low]);
    let computed = CRC16.checksum(data);
    if received != computed {
        return Err(ChipError::FrameCrc { received, computed });
    }
    let mut counts = [0; CHANNELS];
    let mut seen = 0;
    for (count, word) in counts.iter_mut().zip(data.as_chunks::<2>().0) {
        *count = i16::from_be_bytes(*word);
        seen |= *count;
    }
    if seen == 0 {
        Err(ChipError::Silent)
    } else {
        Ok(counts)
    }
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
