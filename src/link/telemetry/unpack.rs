//! The host's end: a block's bytes into samples.

use super::sample::{Channels, Sample};
use crate::frame::{Coordinate, Pose, Status};

/// Takes values off the front of a packed sample.
struct Reader<'b>(&'b [u8]);

impl Reader<'_> {
    fn bytes<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (head, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*head)
    }

    fn f32(&mut self) -> Option<f32> {
        self.bytes().map(f32::from_le_bytes)
    }

    fn array<T: Copy + Default, const N: usize>(
        &mut self,
        mut one: impl FnMut(&mut Self) -> Option<T>,
    ) -> Option<[T; N]> {
        let mut values = [T::default(); N];
        for value in &mut values {
            *value = one(self)?;
        }
        Some(values)
    }

    fn coordinate(&mut self) -> Option<Coordinate> {
        let teeth = i32::from_le_bytes(self.bytes()?);
        Some(Coordinate {
            teeth,
            fraction_turns: self.f32()?,
        })
    }

    fn i16(&mut self) -> Option<i16> {
        self.bytes().map(i16::from_le_bytes)
    }
}

/// A channel if it was sent: none inside, none outside where bytes are missing.
fn sent<T>(
    channels: Channels,
    channel: Channels,
    read: impl FnOnce() -> Option<T>,
) -> Option<Option<T>> {
    if channels.contains(channel) {
        read().map(Some)
    } else {
        Some(None)
    }
}

/// One sample of these channels; none where bytes are missing.
pub(super) fn sample(channels: Channels, sequence: u32, bytes: &[u8]) -> Option<Sample> {
    let mut r = Reader(bytes);
    Some(Sample {
        sequence,
        status: sent(channels, Channels::STATUS, || {
            Some(Status::from_bits_retain(u32::from_le_bytes(r.bytes()?)))
        })?,
        raw: sent(channels, Channels::RAW, || {
            let pairs = r.array(|r| r.array(Reader::i16))?;
            Some((pairs, r.array(Reader::i16)?))
        })?,
        unmodified: sent(channels, Channels::UNMODIFIED, || {
            r.array(Reader::coordinate)
        })?,
        calibrated: sent(channels, Channels::CALIBRATED, || {
            r.array(Reader::coordinate)
        })?,
        amplitude_counts: sent(channels, Channels::AMPLITUDE, || r.array(Reader::f32))?,
        pose: sent(channels, Channels::POSE, || {
            let [x, y] = r.array(Reader::coordinate)?;
            let [theta_x_rad, theta_y_rad, theta_rad] = r.array(Reader::f32)?;
            Some(Pose {
                x,
                y,
                theta_x_rad,
                theta_y_rad,
                theta_rad,
            })
        })?,
        parity_m: sent(channels, Channels::PARITY, || r.f32())?,
        tan_psi: sent(channels, Channels::TAN_PSI, || r.array(Reader::f32))?,
        temperature_delta_k: sent(channels, Channels::TEMPERATURE, || r.f32())?,
    })
}
