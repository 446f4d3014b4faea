//! Samples on their way to a host: decimated, packed, in blocks of consecutive samples, with a count of what was lost.
//!
//! A block is one frame of [`super::framing`] on a channel of its own. Its body holds the samples `first`, `first + decimation`, ... one
//! behind the other, each the chosen channels in the order of their bits, little endian:
//!
//! | bit | channel | bytes |
//! |---|---|---|
//! | 0 | status bits | u32 |
//! | 1 | raw counts: sine, cosine of segments 1 to 4, electrodes x+ x- y+ y- | 12 × i16 |
//! | 2 | unmodified outputs: teeth, fraction in turns, segments 1 to 4 | 4 × (i32, f32) |
//! | 3 | calibrated outputs, alike | 4 × (i32, f32) |
//! | 4 | amplitudes, counts | 4 × f32 |
//! | 5 | pose: x, y as teeth and turns; theta_x, theta_y, theta in rad | 2 × (i32, f32), 3 × f32 |
//! | 6 | parity g_p, metres | f32 |
//! | 7 | tan psi_x, tan psi_y | 2 × f32 |
//! | 8 | temperature minus the calibration's, kelvin | f32 |

mod pack;
mod sample;
#[cfg(test)]
mod tests;
mod unpack;

pub use pack::Packer;
pub use sample::{Channels, Sample};

use super::framing;
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// Most bytes of samples in a block.
pub const BODY_BYTES: usize = 480;
/// A block is sent when it spans this many samples, full or not: 50 ms at 20 kHz.
pub const SPAN_SAMPLES: u32 = 1000;
/// Longest telemetry frame on the wire.
pub const FRAME_BYTES: usize = framing::encoded_bytes(BODY_BYTES + 24);

/// Consecutive samples, as they are sent.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Block {
    /// Counts blocks sent or lost, modulo 2^32.
    pub number: u32,
    /// Samples that should have been sent and were not, since the stream was started.
    pub lost: u32,
    /// Sequence number of the first sample.
    pub first: u32,
    /// Distance between two samples.
    pub decimation: u16,
    /// [`Channels`]' bits.
    pub channels: u16,
    /// Packed samples.
    pub body: Vec<u8, BODY_BYTES>,
}

impl Block {
    /// The samples, in order. Ends early where a block is not whole; never panics, whatever came over the wire.
    pub fn samples(&self) -> impl Iterator<Item = Sample> + '_ {
        let channels = Channels::from_bits_truncate(self.channels);
        let (bytes, decimation) = (channels.sample_bytes(), u32::from(self.decimation));
        let body = if bytes == 0 {
            &[]
        } else {
            self.body.as_slice()
        };
        let packed = body.chunks_exact(bytes.max(1)).zip(0u32..);
        packed.filter_map(move |(bytes, index)| {
            let sequence = self.first.wrapping_add(index.wrapping_mul(decimation));
            unpack::sample(channels, sequence, bytes)
        })
    }
}

/// What a host asks to be sent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct StreamOrder {
    /// [`Channels`]' bits; none ends the stream.
    pub channels: u16,
    /// Every how many samples, 1 or more.
    pub decimation: u16,
    /// How many samples to send before the stream ends by itself; 0: no end.
    pub samples: u32,
}
