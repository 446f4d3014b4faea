//! What of a watch over rests is kept over a restart, as bytes: the reference, and what has been told.
//!
//! ```text
//!  byte  0    1       2      4                                                    92
//!       | kind | flags | zero | 7 numbers, f32                     | zeros         | CRC-32 |
//! ```
//! Little endian; kind: 59 under the beacon, 5A of the parity; the numbers: g_x and g_y, or g_p and zero, what is left of both at a rest,
//! metres; temperature, kelvin;
//! size and deviation of the change, metres. Flags: bit 0 the axis, bits 1 and 2 what the change goes with, bit 3: a tooth map was in force;
//! bit 4: a change had been told. As long as the entries of the segments' watch, so that both lie in one row.

use super::reference::Reference;
use super::rest::RestKind;
use super::told::{Goes, RestChange};
use crate::watch::{KEPT_BYTES, seal, unseal};

/// First byte of each [`RestKind`], by definition of this layout.
const MAGIC: [u8; 2] = [0x59, 0x5A];
/// Bit by definition of this layout.
const WITH_MAP: u8 = 1 << 3;
/// Bit by definition of this layout.
const HAS_TOLD: u8 = 1 << 4;
/// Place of the numbers, by definition of this layout.
const NUMBERS: usize = 4;
/// How many they are, by definition of this layout.
const COUNT: usize = 7;
const _: () = assert!(NUMBERS + 4 * COUNT + 4 <= KEPT_BYTES);
const WAYS: [Goes; 4] = [Goes::Alike, Goes::Temperature, Goes::AlongX, Goes::AlongY];

/// What is kept.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RestKept {
    pub(super) reference: Reference,
    /// Its times are of a start before.
    pub(super) change: Option<RestChange>,
}

impl RestKept {
    /// As bytes. `with_map`: whether a tooth map is in force.
    #[must_use]
    #[inline(never)] // or it is compiled as its caller is, for less smallness
    pub fn bytes(&self, kind: RestKind, with_map: bool) -> [u8; KEPT_BYTES] {
        let mut bytes = [0; KEPT_BYTES];
        let change = self.change.unwrap_or_default();
        bytes[0] = MAGIC[kind as usize];
        bytes[1] = (change.axis & 1)
            | ((change.goes as u8) << 1)
            | (u8::from(with_map) * WITH_MAP)
            | (u8::from(self.change.is_some()) * HAS_TOLD);
        let Reference {
            offset_m: [gx, gy],
            sigma_m: [sx, sy],
            temperature_k,
        } = self.reference;
        let numbers: [f32; COUNT] = [
            gx,
            gy,
            sx,
            sy,
            temperature_k,
            change.size_m,
            change.deviation_m,
        ];
        seal(&mut bytes, NUMBERS, &numbers);
        bytes
    }

    /// From bytes that were kept with a tooth map in force, or without; none if they are no such bytes, or hold what cannot be.
    #[must_use]
    #[inline(never)]
    pub fn from_bytes(bytes: &[u8; KEPT_BYTES], kind: RestKind, with_map: bool) -> Option<Self> {
        let flags = bytes[1];
        let mut numbers = [0.0; COUNT];
        if !unseal(bytes, NUMBERS, &mut numbers)
            || bytes[0] != MAGIC[kind as usize]
            || (flags & WITH_MAP != 0) != with_map
        {
            return None;
        }
        let [gx, gy, sx, sy, temperature_k, size_m, deviation_m] = numbers;
        let is_possible = sx > 0.0 && sy > 0.0;
        let change = RestChange {
            axis: kind.axis(flags),
            goes: WAYS[usize::from(flags >> 1 & 3)],
            size_m,
            deviation_m,
            ..RestChange::default()
        };
        is_possible.then_some(Self {
            reference: Reference {
                offset_m: [gx, gy],
                sigma_m: [sx, sy],
                temperature_k,
            },
            change: (flags & HAS_TOLD != 0).then_some(change),
        })
    }
}
