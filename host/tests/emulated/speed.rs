//! How fast the link is on this machine: printed, never asserted.

use crate::rig::Rig;
use courier_sensor::link::message::TELEMETRY_CHANNEL;
use courier_sensor::link::telemetry::Channels;
use std::time::Instant;

/// Commands of which the median is told.
const COMMANDS: usize = 500;
/// Milliseconds of the board's for which everything is streamed.
const STREAM_MS: u64 = 2000;

#[test]
fn speed_of_the_link_is_told() {
    let mut rig = Rig::start(18);
    let mut times_us: Vec<f64> = (0..COMMANDS)
        .map(|_| {
            let begin = Instant::now();
            rig.status();
            begin.elapsed().as_secs_f64() * 1.0e6
        })
        .collect();
    times_us.sort_by(f64::total_cmp);
    // Status, counts, calibrated outputs: 60 bytes a sample, 1.2 MB/s of the board's time.
    let channels = Channels::STATUS | Channels::RAW | Channels::CALIBRATED;
    rig.link.stream(channels, 1).expect("a stream");
    let (mut bytes, mut buffer) = (0, [0; 1 << 14]);
    let begin = Instant::now();
    for _ in 0..STREAM_MS / 2 {
        rig.run(2);
        let taken = rig.link.wire().receive(TELEMETRY_CHANNEL, &mut buffer);
        bytes += taken.expect("the board is there");
    }
    let wall_s = begin.elapsed().as_secs_f64();
    let status = rig.status();
    let mb = bytes as f64 * 1.0e-6;
    let board_s = STREAM_MS as f64 * 1.0e-3;
    println!(
        "command to reply: median {:.2} ms, worst {:.2} ms of {COMMANDS}, wall clock; telemetry: {:.2} MB/s of the board's time, {:.2} \
         MB/s by the wall clock, {} samples lost, {} interrupts missed",
        times_us[COMMANDS / 2] * 1.0e-3,
        times_us[COMMANDS - 1] * 1.0e-3,
        mb / board_s,
        mb / wall_s,
        status.lost_telemetry,
        status.missed
    );
    assert_eq!(status.missed, 0);
    assert!(bytes > 0);
}
