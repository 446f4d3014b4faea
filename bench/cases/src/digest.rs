//! A digest of every bit of a result; all NaNs count as one, since their sign and payload differ between machines.

use courier_sensor::frame::{Coordinate, Frame};

/// FNV-1a over 32-bit words (Fowler, Noll and Vo), 64 bits wide.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Digest(u64);

impl Default for Digest {
    fn default() -> Self {
        Self(0xCBF2_9CE4_8422_2325)
    }
}

impl Digest {
    /// The value so far.
    pub fn value(self) -> u64 {
        self.0
    }

    /// Takes in a word.
    pub fn word(&mut self, word: u32) {
        for byte in word.to_le_bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01B3);
        }
    }

    /// Takes in a number, to the bit.
    pub fn float(&mut self, value: f32) {
        self.word(if value.is_nan() {
            0x7FC0_0000
        } else {
            value.to_bits()
        });
    }

    /// Takes in numbers.
    pub fn floats(&mut self, values: &[f32]) {
        values.iter().for_each(|value| self.float(*value));
    }

    fn coordinate(&mut self, c: Coordinate) {
        self.word(c.teeth as u32);
        self.float(c.fraction_turns);
    }

    /// Takes in everything that a frame says.
    pub fn frame(&mut self, frame: &Frame) {
        self.word(frame.sequence);
        self.word(frame.status.bits());
        for segment in &frame.segments {
            self.coordinate(segment.unmodified);
            self.coordinate(segment.calibrated);
            self.floats(&[segment.amplitude_counts]);
        }
        let pose = &frame.pose;
        self.coordinate(pose.x);
        self.coordinate(pose.y);
        self.floats(&[
            pose.theta_x_rad,
            pose.theta_y_rad,
            pose.theta_rad,
            frame.parity_m,
        ]);
        self.floats(&frame.tan_psi);
        self.floats(&frame.speed_m_s);
        self.floats(&frame.direction);
    }
}
