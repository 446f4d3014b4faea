//! The board's end: frames into blocks.

use super::{BODY_BYTES, Block, Channels, SPAN_SAMPLES, StreamOrder};
use crate::frame::{Coordinate, Frame, Segment};
use crate::link::framing;
use heapless::Vec;

/// Packs frames into blocks. One stream at a time; starts with none.
#[derive(Clone, Debug, Default)]
pub struct Packer {
    pub(super) block: Block,
    order: StreamOrder,
    left: Option<u32>,
    next: Option<u32>,
}

impl Packer {
    /// Starts a stream, or ends it if no channel is asked for. What was packed of the one before is dropped.
    pub fn start(&mut self, order: StreamOrder) {
        let number = self.block.number;
        *self = Self::default();
        self.block.number = number;
        self.block.channels = Channels::from_bits_truncate(order.channels).bits();
        self.block.decimation = order.decimation.max(1);
        self.order = order;
        self.left = (order.samples > 0).then_some(order.samples);
    }

    /// Whether frames are wanted.
    pub const fn is_streaming(&self) -> bool {
        self.block.channels != 0 && !matches!(self.left, Some(0))
    }

    /// The running stream's order.
    pub const fn order(&self) -> StreamOrder {
        self.order
    }

    /// Samples that should have been sent and were not.
    pub const fn lost(&self) -> u32 {
        self.block.lost
    }

    /// Takes a frame; sends blocks as they fill, or at the latest every [`SPAN_SAMPLES`] samples. `send` gets a whole frame for the
    /// channel and says whether the channel took it; what it does not take is counted as lost. Never blocks.
    pub fn push(&mut self, frame: &Frame, buffer: &mut [u8], mut send: impl FnMut(&[u8]) -> bool) {
        if !self.is_streaming() {
            return;
        }
        let (step, bytes) = (u32::from(self.block.decimation), self.sample_bytes());
        let due = *self.next.get_or_insert(frame.sequence);
        let ahead = frame.sequence.wrapping_sub(due) as i32;
        if ahead < 0 {
            return;
        }
        if ahead > 0 {
            // Samples that were due never came up the queue; a block holds none but consecutive ones.
            self.flush(buffer, &mut send);
            let missed = (ahead as u32).div_ceil(step);
            self.block.lost = self.block.lost.wrapping_add(missed);
            self.next = Some(due.wrapping_add(missed.wrapping_mul(step)));
            if self.next != Some(frame.sequence) {
                return;
            }
        }
        self.add(frame, step);
        let span = frame
            .sequence
            .wrapping_sub(self.block.first)
            .wrapping_add(step);
        if self.block.body.len() + bytes > BODY_BYTES
            || span >= SPAN_SAMPLES
            || !self.is_streaming()
        {
            self.flush(buffer, &mut send);
        }
    }

    /// Sends what is packed, if anything.
    pub fn flush(&mut self, buffer: &mut [u8], send: &mut impl FnMut(&[u8]) -> bool) {
        if self.block.body.is_empty() {
            return;
        }
        let block = &self.block;
        let head = (
            block.number,
            block.lost,
            block.first,
            block.decimation,
            block.channels,
        );
        if !framing::encode_with_body(&head, &block.body, buffer).is_ok_and(send) {
            let samples = self.block.body.len() / self.sample_bytes();
            self.block.lost = self.block.lost.wrapping_add(samples as u32);
        }
        self.block.number = self.block.number.wrapping_add(1);
        self.block.body.clear();
    }

    fn add(&mut self, frame: &Frame, step: u32) {
        if self.block.body.is_empty() {
            self.block.first = frame.sequence;
        }
        pack(self.channels(), frame, &mut self.block.body);
        self.next = Some(frame.sequence.wrapping_add(step));
        self.left = self.left.map(|left| left.saturating_sub(1));
    }

    fn channels(&self) -> Channels {
        Channels::from_bits_truncate(self.block.channels)
    }

    fn sample_bytes(&self) -> usize {
        self.channels().sample_bytes().max(1)
    }
}

/// Appends; the caller has made sure of the room.
fn pack(channels: Channels, frame: &Frame, body: &mut Vec<u8, BODY_BYTES>) {
    let mut put = |bytes: &[u8]| {
        let _ = body.extend_from_slice(bytes);
    };
    if channels.contains(Channels::STATUS) {
        put(&frame.status.bits().to_le_bytes());
    }
    if channels.contains(Channels::RAW) {
        let raw = &frame.raw;
        let [[a, b], [c, d], [e, f], [g, h]] = raw.quadrature_counts;
        let [i, j, k, l] = raw.electrode_counts;
        put(&joined::<2, 24>(
            [a, b, c, d, e, f, g, h, i, j, k, l].map(i16::to_le_bytes),
        ));
    }
    let outputs = |pick: fn(&Segment) -> &Coordinate| {
        joined::<8, 32>(
            frame
                .segments
                .each_ref()
                .map(|segment| coordinate(pick(segment))),
        )
    };
    if channels.contains(Channels::UNMODIFIED) {
        put(&outputs(|segment| &segment.unmodified));
    }
    if channels.contains(Channels::CALIBRATED) {
        put(&outputs(|segment| &segment.calibrated));
    }
    if channels.contains(Channels::AMPLITUDE) {
        let amplitudes = frame.segments.each_ref();
        put(&joined::<4, 16>(
            amplitudes.map(|segment| segment.amplitude_counts.to_le_bytes()),
        ));
    }
    if channels.contains(Channels::POSE) {
        let pose = &frame.pose;
        put(&coordinate(&pose.x));
        put(&coordinate(&pose.y));
        let angles = [pose.theta_x_rad, pose.theta_y_rad, pose.theta_rad];
        put(&joined::<4, 12>(angles.map(f32::to_le_bytes)));
    }
    if channels.contains(Channels::PARITY) {
        put(&frame.parity_m.to_le_bytes());
    }
    if channels.contains(Channels::TAN_PSI) {
        put(&joined::<4, 8>(frame.tan_psi.map(f32::to_le_bytes)));
    }
    if channels.contains(Channels::TEMPERATURE) {
        put(&frame.raw.temperature_delta_k.to_le_bytes());
    }
}

fn coordinate(coordinate: &Coordinate) -> [u8; 8] {
    let [a, b, c, d] = coordinate.teeth.to_le_bytes();
    let [e, f, g, h] = coordinate.fraction_turns.to_le_bytes();
    [a, b, c, d, e, f, g, h]
}

/// One behind the other. One copy of many bytes costs less than many of a few.
fn joined<const N: usize, const ALL: usize>(parts: impl AsRef<[[u8; N]]>) -> [u8; ALL] {
    let mut all = [0; ALL];
    let bytes = parts.as_ref().as_flattened();
    all.iter_mut()
        .zip(bytes)
        .for_each(|(place, byte)| *place = *byte);
    all
}
