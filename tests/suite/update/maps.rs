//! Tooth maps move with the image, as the calibration does.

use super::rig::{Board, Running, image};
use crate::maps::{current_at, store_at};
use courier_sensor::update::layout::MAPS_START;
use courier_sensor::update::trial;

/// Every so many steps of a start on trial are cut: the copy of two maps has 700 of them, and each part of an erase and of a word is met.
const STRIDE: usize = 5;

fn maps(board: &mut Board, running: &Running) -> Vec<(String, u32)> {
    current_at(board.far(running), MAPS_START)
}

fn store(board: &mut Board, running: &Running, name: &str, mark: u32) {
    store_at(board.far(running), MAPS_START, name, mark).unwrap();
}

fn both(first: u32, second: u32) -> Vec<(String, u32)> {
    vec![("a".to_owned(), first), ("b".to_owned(), second)]
}

/// A board with two maps, and a new image in its other bank.
fn updated(seed: u64, ecc: bool) -> Board {
    let mut board = Board::factory(seed, ecc);
    let running = board.start().unwrap();
    for (name, mark) in [("a", 1), ("b", 2), ("a", 3)] {
        store(&mut board, &running, name, mark);
    }
    board.update(&running, &image(2)).unwrap();
    board
}

#[test]
fn maps_follow_each_image_and_come_back_with_the_one_before() {
    let mut board = updated(1, true);
    let running = board.start().unwrap();
    assert!(running.minor == 2 && running.standing.trial.is_some());
    assert_eq!(maps(&mut board, &running), both(3, 2));
    trial::refuse(board.far(&running), running.standing.trial.unwrap()).unwrap();
    let running = board.start().unwrap();
    assert_eq!((running.minor, maps(&mut board, &running)), (1, both(3, 2)));
    // Changed since, then the next one, which is accepted.
    store(&mut board, &running, "b", 4);
    board.update(&running, &image(3)).unwrap();
    let running = board.start().unwrap();
    assert_eq!((running.minor, maps(&mut board, &running)), (3, both(3, 4)));
    assert!(board.accept(&running));
    store(&mut board, &running, "a", 5);
    board.update(&running, &image(4)).unwrap();
    let running = board.start().unwrap();
    assert_eq!((running.minor, maps(&mut board, &running)), (4, both(5, 4)));
}

#[test]
fn a_cut_in_the_copy_loses_no_map() {
    for (ecc, seed) in [(true, 1), (false, 2)] {
        let before = updated(seed, ecc);
        let mut whole = before.clone();
        whole.start().unwrap();
        let steps = whole.steps() - before.steps();
        for cut in (0..steps).step_by(STRIDE) {
            let mut board = before.clone();
            board.cut_after(cut);
            let _ = board.start();
            board.power_up();
            let running = board.start().unwrap();
            let found = (
                running.minor,
                running.standing.moved,
                maps(&mut board, &running),
            );
            assert_eq!(
                found,
                (2, Ok(()), both(3, 2)),
                "cut {cut} of {steps}, ecc {ecc}"
            );
        }
    }
}

/// A debug probe has written the bank that the maps are not in: they are found where they are, or moved.
#[test]
fn maps_are_found_after_a_probe_has_written_the_board() {
    let mut board = updated(3, true);
    let running = board.start().unwrap();
    assert!(board.accept(&running));
    store(&mut board, &running, "b", 7);
    board.written_by_probe();
    let running = board.start().unwrap();
    assert_eq!((running.minor, maps(&mut board, &running)), (1, both(3, 7)));
}
