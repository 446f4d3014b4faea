//! What of the watch is kept over a restart, as bytes: the reference, and what has been told.
//!
//! ```text
//!  byte  0    1              2       4            68      72            76            80     84         88              92
//!       | 58 | place, flags | known | 32 amounts | sigma | correlation | temperature | size | deviation | apart, amended | CRC-32 |
//!         u8   u8             u16     i16, nm      f32     f32           f32, K        f32 m  f32 m       u16, u16 nm      ISO-HDLC
//! ```
//! Little endian. Bits 0 to 3 are the place; bit 4: a tooth map was in force; bit 5: a change had been told; bit 6: of either segment of its
//! pair; bit 7: a recalibration may compare with it. The first byte is D8 where it waits for a window that agrees with it. Known, apart: a bit
//! for each place that the reference knows, and tells from the other segment's. Amended: by how much the calibration has been amended since the
//! reference was learned, rms.

use super::places::Place;
use super::row::OWN_COLUMNS;
use super::told::{Present, Told};
use crc::{CRC_32_ISO_HDLC, Crc, NoTable};

/// How many bytes: whole double words of flash, by definition of this layout.
pub const KEPT_BYTES: usize = 96;
/// First byte, by definition of this layout.
const MAGIC: u8 = 0x58;
/// Bit of the first byte, by definition of this layout.
const WAITS: u8 = 1 << 7;
/// Bits of the place, by definition of this layout.
const PLACE: u8 = 0x0F;
/// Bit by definition of this layout.
const WITH_MAP: u8 = 1 << 4;
/// Bit by definition of this layout.
const HAS_TOLD: u8 = 1 << 5;
/// Bit by definition of this layout.
const OF_EITHER: u8 = 1 << 6;
/// Bit by definition of this layout.
const IS_MEASURE: u8 = 1 << 7;
/// Place of the amounts, by definition of this layout.
const AMOUNTS: usize = 4;
const NUMBERS: usize = AMOUNTS + 2 * OWN_COLUMNS;
/// Place of the check value, by definition the last four bytes.
const CHECK: usize = KEPT_BYTES - 4;
/// Place of how well they are known apart, by definition of this layout.
const APART: usize = NUMBERS + 5 * 4;
const AMENDED: usize = APART + 2;
const _: () = assert!(AMENDED + 2 == CHECK);

/// Nanometres in a metre: an amount is kept to the nearest, up to 32 µm. By definition of the unit nanometre.
const PER_M: f32 = 1.0e9;

static CRC32: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);

/// The CRC of an entry's bytes before it.
fn check(bytes: &[u8; KEPT_BYTES]) -> [u8; 4] {
    CRC32.checksum(&bytes[..CHECK]).to_le_bytes()
}

/// Writes numbers to an entry from a place on, then its CRC.
#[inline(never)] // one copy in the images
pub(crate) fn seal(bytes: &mut [u8; KEPT_BYTES], from: usize, numbers: &[f32]) {
    let places = bytes[from..CHECK].as_chunks_mut().0;
    for (place, number) in places.iter_mut().zip(numbers) {
        *place = number.to_le_bytes();
    }
    let sum = check(bytes);
    bytes[CHECK..].copy_from_slice(&sum);
}

/// Reads an entry's numbers from a place on; whether its CRC is right and all are finite.
#[inline(never)] // one copy in the images
pub(crate) fn unseal(bytes: &[u8; KEPT_BYTES], from: usize, numbers: &mut [f32]) -> bool {
    let mut is_whole = check(bytes)[..] == bytes[CHECK..];
    for (number, kept) in numbers.iter_mut().zip(bytes[from..CHECK].as_chunks().0) {
        *number = f32::from_le_bytes(*kept);
        is_whole &= number.is_finite();
    }
    is_whole
}

/// What is kept.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Kept {
    /// Equation (3)'s amounts of the reference, metres.
    pub reference_m: [f32; OWN_COLUMNS],
    /// Places that it knows, a bit each.
    pub known: u16,
    /// Places that it tells from those of the other segment.
    pub apart: u16,
    /// A recalibration may compare with it: it tells all of them from those of the other segment, and a window has agreed with it.
    pub is_measure: bool,
    /// It tells them, and no window has agreed with it yet.
    pub waits: bool,
    /// Deviation of a row, metres.
    pub sigma_m: f32,
    /// Correlation of a pair.
    pub correlation: f32,
    /// Of the reference, over the calibration's, kelvin.
    pub temperature_k: f32,
    /// By how much the calibration has been amended since the reference was learned, metres rms; kept up to 65 µm.
    pub amended_m: f32,
    /// What has been told; its times are of a start before.
    pub(super) told: Option<Told>,
}

impl Kept {
    /// As bytes. `with_map`: whether a tooth map is in force.
    #[must_use]
    #[inline(never)] // or it is compiled as its caller is, for less smallness
    pub fn bytes(&self, with_map: bool) -> [u8; KEPT_BYTES] {
        let mut bytes = [0; KEPT_BYTES];
        bytes[0] = MAGIC | (u8::from(self.waits) * WAITS);
        bytes[2..AMOUNTS].copy_from_slice(&self.known.to_le_bytes());
        let told = self.told.unwrap_or(Told::ZERO);
        bytes[1] = told.now.place.index() as u8
            | (u8::from(with_map) * WITH_MAP)
            | (u8::from(self.told.is_some()) * HAS_TOLD)
            | (u8::from(told.now.or_segment.is_some()) * OF_EITHER)
            | (u8::from(self.is_measure) * IS_MEASURE);
        let amounts = bytes[AMOUNTS..NUMBERS].as_chunks_mut().0;
        for (place, amount_m) in amounts.iter_mut().zip(self.reference_m) {
            // The conversion saturates.
            *place = ((amount_m * PER_M) as i16).to_le_bytes();
        }
        let numbers = [
            self.sigma_m,
            self.correlation,
            self.temperature_k,
            told.now.size_m,
            told.now.deviation_m,
        ];
        bytes[APART..APART + 2].copy_from_slice(&self.apart.to_le_bytes());
        // The conversion saturates.
        let amended = ((self.amended_m * PER_M) as u16).to_le_bytes();
        bytes[AMENDED..CHECK].copy_from_slice(&amended);
        seal(&mut bytes, NUMBERS, &numbers);
        bytes
    }

    /// The same once changes are taken out of the outputs, in all of so many metres rms: nothing is told.
    #[must_use]
    pub fn amended(self, amended_m: f32) -> Self {
        Self {
            told: None,
            amended_m,
            ..self
        }
    }

    /// From bytes that were kept with a tooth map in force, or without; none if they are no such bytes, or hold what cannot be.
    #[must_use]
    #[inline(never)]
    pub fn from_bytes(bytes: &[u8; KEPT_BYTES], with_map: bool) -> Option<Self> {
        let flags = bytes[1];
        let mut numbers = [0.0; 5];
        if !unseal(bytes, NUMBERS, &mut numbers)
            || bytes[0] & !WAITS != MAGIC
            || (flags & WITH_MAP != 0) != with_map
        {
            return None;
        }
        let mut reference_m = [0.0; OWN_COLUMNS];
        let amounts = bytes[AMOUNTS..NUMBERS].as_chunks().0;
        for (amount_m, kept) in reference_m.iter_mut().zip(amounts) {
            *amount_m = f32::from(i16::from_le_bytes(*kept)) / PER_M;
        }
        let [sigma_m, correlation, temperature_k, size_m, deviation_m] = numbers;
        let is_possible = sigma_m > 0.0 && (0.0..1.0).contains(&correlation);
        let place = Place::from_index(flags & PLACE)?;
        let told = Told {
            now: Present::kept(place, flags & OF_EITHER != 0, size_m, deviation_m),
            ..Told::ZERO
        };
        is_possible.then_some(Self {
            reference_m,
            known: u16::from_le_bytes([bytes[2], bytes[3]]),
            apart: u16::from_le_bytes([bytes[APART], bytes[APART + 1]]),
            is_measure: flags & IS_MEASURE != 0,
            waits: bytes[0] & WAITS != 0,
            sigma_m,
            correlation,
            temperature_k,
            amended_m: f32::from(u16::from_le_bytes([bytes[AMENDED], bytes[AMENDED + 1]])) / PER_M,
            told: (flags & HAS_TOLD != 0).then_some(told),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kept(told: Option<Told>) -> Kept {
        Kept {
            reference_m: core::array::from_fn(|i| (i as f32 - 16.0) * 0.25e-6),
            known: 0xA5C3,
            apart: 0x3C5A,
            is_measure: told.is_none(),
            waits: told.is_some(),
            sigma_m: 0.9e-6,
            correlation: 0.95,
            temperature_k: -1.5,
            amended_m: 2.5e-6,
            told,
        }
    }

    #[test]
    fn what_is_kept_comes_back_and_a_changed_byte_does_not() {
        let place = Place::of(2, 4).unwrap();
        let told = Told {
            now: Present::kept(place, true, 0.6e-6, 0.02e-6),
            ..Told::ZERO
        };
        for (told, with_map) in [(None, false), (Some(told), true)] {
            let kept = kept(told);
            let bytes = kept.bytes(with_map);
            let back = Kept::from_bytes(&bytes, with_map).unwrap();
            assert_eq!((back.told, back.sigma_m), (kept.told, kept.sigma_m));
            assert_eq!((back.known, back.apart), (kept.known, kept.apart));
            assert_eq!((back.is_measure, back.waits), (kept.is_measure, kept.waits));
            assert!((back.amended_m - kept.amended_m).abs() <= 1.0e-9);
            for (back, kept) in back.reference_m.iter().zip(kept.reference_m) {
                assert!((back - kept).abs() <= 1.0e-9, "{back} {kept}");
            }
            assert_eq!(Kept::from_bytes(&bytes, !with_map), None);
            for i in 0..KEPT_BYTES {
                let mut changed = bytes;
                changed[i] ^= 0x10;
                assert_eq!(Kept::from_bytes(&changed, with_map), None, "byte {i}");
            }
        }
        assert_eq!(Kept::from_bytes(&[0xFF; KEPT_BYTES], false), None);
        assert_eq!(Kept::from_bytes(&[0; KEPT_BYTES], false), None);
    }

    #[test]
    fn what_cannot_be_is_not_taken() {
        for sigma_m in [f32::NAN, 0.0, -1.0e-6, f32::INFINITY] {
            let bytes = Kept {
                sigma_m,
                ..kept(None)
            }
            .bytes(false);
            assert_eq!(Kept::from_bytes(&bytes, false), None, "{sigma_m}");
        }
    }
}
