//! Packing and unpacking against each other.

use super::framing::Decoder;
use super::*;
use crate::frame::Frame;
use crate::frame::{Coordinate, Status};

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
        let samples: heapless::Vec<Sample, 8> = blocks.iter().flat_map(Block::samples).collect();
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
