//! Converters that fail in service and come back.

use super::converter::{Board, running};
use courier_sensor::drivers::converter::{ConverterError, Counts};
use hal_sim::wire::fault::{Level, SpiFault, When};

/// Samples until the first good one, at most a second's.
fn back_in_service(board: &mut Board) -> Option<usize> {
    (0..20_000).find(|_| board.pair.convert(&mut Counts::default()).is_ok())
}

#[test]
fn a_chip_that_forgot_its_settings_is_set_again_in_service() {
    for chip in 0..2 {
        let mut board = running();
        board.wire.with_chip(chip, |chip| chip.reset());
        let mut longest_ns = 0;
        let mut bad = 0;
        let mut counts = Counts::default();
        loop {
            let before_ns = board.clock.now_ns();
            let result = board.pair.convert(&mut counts);
            longest_ns = longest_ns.max(board.clock.now_ns() - before_ns);
            match result {
                Ok(()) => break,
                Err(ConverterError::Chip { index, .. }) => assert_eq!(usize::from(index), chip),
                Err(other) => panic!("{other}"),
            }
            bad += 1;
            assert!(bad < 200, "chip {chip}");
        }
        assert!(
            longest_ns < 20_000,
            "no instant may cost more than its share: {longest_ns} ns"
        );
        assert!((20..200).contains(&bad), "chip {chip}: {bad} samples lost");
        board.pair.convert(&mut counts).unwrap();
        assert_eq!(
            counts[1],
            [8000, 8000, 8000, 8000, 0, 0, 0, 64],
            "set as before"
        );
    }
}

#[test]
fn converters_that_stay_away_are_tried_again_and_again() {
    let mut board = running();
    board.spi[1].set(SpiFault::Stuck(0xFF), When::Always);
    board.busy.set(Level(true), When::Next(5000));
    assert_eq!(back_in_service(&mut board), None);
    board.spi[1].clear();
    let lost = back_in_service(&mut board).unwrap();
    assert!(lost < 1200, "{lost} samples after the line came back");
}

#[test]
fn a_silent_busy_line_is_a_failure_like_any_other() {
    let mut board = running();
    let mut last = None;
    for _ in 0..150 {
        last = Some(board.pair.silent());
    }
    assert_eq!(last, Some(ConverterError::BusyStuck { polls: 0 }));
    assert!(back_in_service(&mut board).unwrap() < 120);
}

#[test]
fn single_failures_never_reset_the_chips() {
    let mut board = running();
    board.spi[0].set(SpiFault::Stuck(0xFF), When::Sometimes(0.3));
    for _ in 0..20_000 {
        let _ = board.pair.convert(&mut Counts::default());
    }
    board.wire.with_chip(0, |chip| {
        assert_eq!(chip.resets, 2, "power-up and start-up")
    });
}
