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

use super::framing;
use crate::frame::{Coordinate, Frame, Pose, SEGMENTS, Segment, Status};
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// Most bytes of samples in a block.
pub const BODY_BYTES: usize = 480;
/// A block is sent when it spans this many samples, full or not: 50 ms at 20 kHz.
pub const SPAN_SAMPLES: u32 = 1000;
/// Longest telemetry frame on the wire.
pub const FRAME_BYTES: usize = framing::encoded_bytes(BODY_BYTES + 24);

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
            unpack(channels, sequence, bytes)
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

/// Packs frames into blocks. One stream at a time; starts with none.
#[derive(Clone, Debug, Default)]
pub struct Packer {
    block: Block,
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

fn unpack(channels: Channels, sequence: u32, bytes: &[u8]) -> Option<Sample> {
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

#[cfg(test)]
mod tests {
    use super::framing::Decoder;
    use super::*;

    fn frame(sequence: u32) -> Frame {
        let mut frame = Frame {
            sequence,
            status: Status::OVERRUN,
            parity_m: 1.0e-6 * sequence as f32,
            ..Frame::default()
        };
        frame.raw.quadrature_counts[3] = [sequence as i16, -1];
        frame.raw.electrode_counts[3] = 7;
        frame.raw.temperature_delta_k = 0.5;
        frame.segments[1].calibrated = Coordinate {
            teeth: -3,
            fraction_turns: 0.25,
        };
        frame.segments[2].amplitude_counts = 20_000.0;
        frame.pose.theta_rad = 0.001;
        frame.tan_psi = [0.1, -0.1];
        frame
    }

    /// Pushes frames and decodes what is sent; every `refuse`th block is not taken by the channel.
    fn stream(
        order: StreamOrder,
        sequences: impl Iterator<Item = u32>,
        refuse: usize,
    ) -> (Packer, heapless::Vec<Block, 256>) {
        let (mut packer, mut decoder) = (Packer::default(), Decoder::<FRAME_BYTES>::new());
        let (mut blocks, mut sent) = (heapless::Vec::new(), 0);
        let mut buffer = [0; FRAME_BYTES];
        packer.start(order);
        for sequence in sequences {
            packer.push(&frame(sequence), &mut buffer, |bytes| {
                sent += 1;
                let taken = sent % refuse != 0;
                if taken {
                    let got = bytes.iter().filter_map(|&byte| decoder.feed::<Block>(byte));
                    got.for_each(|block| blocks.push(block.unwrap()).unwrap());
                }
                taken
            });
        }
        (packer, blocks)
    }

    fn order(channels: Channels, decimation: u16, samples: u32) -> StreamOrder {
        StreamOrder {
            channels: channels.bits(),
            decimation,
            samples,
        }
    }

    #[test]
    fn a_block_is_encoded_as_any_message() {
        for length in [0, 1, 253, 254, 255, 480] {
            let body = (0..length).map(|k| if k % 7 == 0 { 0 } else { k as u8 });
            let block = Block {
                number: 300,
                lost: u32::MAX,
                first: 0,
                decimation: 20,
                channels: 0x1FF,
                body: body.collect(),
            };
            let (mut slow, mut fast) = ([0; FRAME_BYTES], [0; FRAME_BYTES]);
            let head = (300_u32, u32::MAX, 0_u32, 20_u16, 0x1FF_u16);
            assert_eq!(
                framing::encode_with_body(&head, &block.body, &mut fast),
                framing::encode(&block, &mut slow),
                "{length}"
            );
        }
        assert!(framing::encode_with_body(&1_u8, &[1; 30], &mut [0; 37]).is_err());
    }

    #[test]
    fn every_channel_comes_out_as_it_went_in() {
        for channels in (0..1 << 9).map(Channels::from_bits_truncate) {
            let (packer, blocks) = stream(order(channels, 1, 5), 100..200, usize::MAX);
            let samples: heapless::Vec<Sample, 8> =
                blocks.iter().flat_map(Block::samples).collect();
            assert_eq!(
                samples.len(),
                if channels.is_empty() { 0 } else { 5 },
                "{channels:?}"
            );
            assert!(!packer.is_streaming());
            for (sample, sequence) in samples.iter().zip(100..) {
                let frame = frame(sequence);
                let has = |channel| channels.contains(channel);
                assert_eq!(sample.sequence, sequence);
                assert_eq!(sample.status, has(Channels::STATUS).then_some(frame.status));
                let raw = (frame.raw.quadrature_counts, frame.raw.electrode_counts);
                assert_eq!(sample.raw, has(Channels::RAW).then_some(raw));
                assert_eq!(
                    sample.unmodified,
                    has(Channels::UNMODIFIED).then_some(frame.segments.map(|s| s.unmodified))
                );
                assert_eq!(
                    sample.calibrated,
                    has(Channels::CALIBRATED).then_some(frame.segments.map(|s| s.calibrated))
                );
                assert_eq!(
                    sample.amplitude_counts,
                    has(Channels::AMPLITUDE).then_some(frame.segments.map(|s| s.amplitude_counts))
                );
                assert_eq!(sample.pose, has(Channels::POSE).then_some(frame.pose));
                assert_eq!(
                    sample.parity_m,
                    has(Channels::PARITY).then_some(frame.parity_m)
                );
                assert_eq!(
                    sample.tan_psi,
                    has(Channels::TAN_PSI).then_some(frame.tan_psi)
                );
                assert_eq!(
                    sample.temperature_delta_k,
                    has(Channels::TEMPERATURE).then_some(0.5)
                );
            }
        }
    }

    #[test]
    fn decimated_samples_are_sent_by_fifty_milliseconds_at_the_latest() {
        let (_, blocks) = stream(order(Channels::POSE, 400, 0), 0..4000, usize::MAX);
        let firsts: heapless::Vec<(u32, usize), 8> = blocks
            .iter()
            .map(|b| (b.first, b.samples().count()))
            .collect();
        assert_eq!(firsts, [(0, 3), (1200, 3), (2400, 3)]);
        let (_, blocks) = stream(order(Channels::POSE, 2000, 0), 0..4000, usize::MAX);
        assert_eq!(blocks.len(), 2);
    }

    #[test]
    fn what_is_lost_is_counted_wherever_it_was_lost() {
        // Every third block is refused by the channel, and the queue loses 40..=139 (100 samples) and 200.
        let sequences = (0..1000).filter(|n| !(40..140).contains(n) && *n != 200);
        let (packer, blocks) = stream(order(Channels::RECORDING, 1, 0), sequences, 3);
        let got = blocks.iter().flat_map(Block::samples).count() as u32;
        let packed = (packer.block.body.len() / Channels::RECORDING.sample_bytes()) as u32;
        assert_eq!(got + packed + packer.lost(), 1000);
        assert!(packer.lost() > 101 && got > 500, "{} {got}", packer.lost());
        let mut last = None;
        for sample in blocks.iter().flat_map(Block::samples) {
            assert_eq!(
                sample.raw.unwrap().0[3][0],
                sample.sequence as i16,
                "numbered as it was taken"
            );
            assert!(last < Some(sample.sequence));
            last = Some(sample.sequence);
        }
    }

    #[test]
    fn sequence_numbers_may_wrap() {
        let sequences = (0..2000u32).map(|n| n.wrapping_sub(1000));
        let (packer, blocks) = stream(order(Channels::RECORDING, 1, 0), sequences, usize::MAX);
        assert_eq!(packer.lost(), 0);
        assert!(
            blocks
                .iter()
                .flat_map(Block::samples)
                .any(|sample| sample.sequence == 0)
        );
    }

    #[test]
    fn the_longest_block_fits_its_frame() {
        let mut block = Block {
            number: u32::MAX,
            lost: u32::MAX,
            first: u32::MAX,
            decimation: u16::MAX,
            channels: u16::MAX,
            ..Block::default()
        };
        while block.body.push(1).is_ok() {}
        assert!(framing::encode(&block, &mut [0; FRAME_BYTES]).is_ok());
    }

    #[test]
    fn nonsense_in_a_block_gives_no_sample_and_no_panic() {
        for channels in [0, 1, 0xFFFF] {
            let block = Block {
                channels,
                body: Vec::from_slice(&[9; 3]).unwrap(),
                ..Block::default()
            };
            assert_eq!(block.samples().count(), 0);
        }
    }
}
