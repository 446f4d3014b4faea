//! The channels of a sample, and a sample as a host sees it.

use crate::frame::{Coordinate, Pose, SEGMENTS, Status};

bitflags::bitflags! {
    /// Which channels are sent.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub struct Channels: u16 {
        /// Status bits.
        const STATUS = 1 << 0;
        /// Raw counts.
        const RAW = 1 << 1;
        /// Unmodified outputs.
        const UNMODIFIED = 1 << 2;
        /// Calibrated outputs.
        const CALIBRATED = 1 << 3;
        /// Amplitudes.
        const AMPLITUDE = 1 << 4;
        /// Pose.
        const POSE = 1 << 5;
        /// Parity.
        const PARITY = 1 << 6;
        /// Coordination sensor.
        const TAN_PSI = 1 << 7;
        /// Temperature.
        const TEMPERATURE = 1 << 8;
    }
}

impl Channels {
    /// What a recording needs of each sample.
    pub const RECORDING: Self = Self::STATUS.union(Self::RAW).union(Self::TEMPERATURE);

    /// Bytes of one sample.
    pub const fn sample_bytes(self) -> usize {
        const BYTES: [usize; 9] = [4, 24, 32, 32, 16, 28, 4, 8, 4];
        let mut sum = 0;
        let mut bit = 0;
        while bit < BYTES.len() {
            if self.bits() >> bit & 1 == 1 {
                sum += BYTES[bit];
            }
            bit += 1;
        }
        sum
    }
}

/// One sample as a host sees it; channels that were not sent are none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// The frame's sequence number.
    pub sequence: u32,
    /// Status bits.
    pub status: Option<Status>,
    /// Raw counts of the segments and the electrodes.
    pub raw: Option<([[i16; 2]; SEGMENTS], [i16; 4])>,
    /// Unmodified outputs.
    pub unmodified: Option<[Coordinate; SEGMENTS]>,
    /// Calibrated outputs.
    pub calibrated: Option<[Coordinate; SEGMENTS]>,
    /// Amplitudes, counts.
    pub amplitude_counts: Option<[f32; SEGMENTS]>,
    /// Pose.
    pub pose: Option<Pose>,
    /// Parity, metres.
    pub parity_m: Option<f32>,
    /// Coordination sensor.
    pub tan_psi: Option<[f32; 2]>,
    /// Temperature minus the calibration's, kelvin.
    pub temperature_delta_k: Option<f32>,
}
