//! A simulated courier seen from outside: which sample saw what.

use board_link::{Simulated, Starter};
use courier_sensor::link::telemetry::Channels;
use hal_sim::presets;
use std::time::Duration;

/// Instants that the board misses.
const MISSED: u32 = 37;

/// The demonstration finds by the number what the interferometer saw at a sample. No conversion belongs to an instant that was missed, so
/// that a count of conversions would be off by those from there on.
#[test]
fn the_interferometers_readings_have_their_samples_numbers_also_after_missed_instants() {
    let mut board = Simulated::start(Starter::default(), presets::ideal(1), 1).unwrap();
    let period_ns = 1.0e9 / f64::from(board.link.hello().rate_hz);
    board.world.watch();
    board.link.stream(Channels::POSE, 1).unwrap();
    let mut numbers = vec![];
    for gap in [0, MISSED + 1, 0] {
        // From between two instants on.
        let gap_ns = (f64::from(gap) * period_ns) as u64;
        board.world.clock.advance_ns(gap_ns);
        board.link.pass(Duration::from_millis(2)).unwrap();
        let seen = board.link.listen(|sample| {
            numbers.push(sample.sequence);
            Ok(())
        });
        seen.unwrap();
    }
    let (_, witnesses) = board.world.unwatch();
    let seen: Vec<u32> = witnesses
        .iter()
        .map(|it| board.number_at(it.time_ns))
        .collect();
    assert_eq!(seen.last(), Some(&board.sequence()));
    let from = seen
        .iter()
        .position(|number| *number == numbers[0])
        .unwrap();
    assert_eq!(seen[from..][..numbers.len()], numbers);
    let steps: Vec<u32> = numbers.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let gaps: Vec<u32> = steps.into_iter().filter(|step| *step != 1).collect();
    assert_eq!(gaps, [MISSED + 1], "one gap, as wide as what was missed");
}
