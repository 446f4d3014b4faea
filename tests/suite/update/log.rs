//! The log moves with the image, as the calibration does.

use super::rig::{Board, Running, image};
use courier_sensor::calibration::record::Instant;
use courier_sensor::event_log::entry::{Event, Head};
use courier_sensor::event_log::store::EventLog;
use courier_sensor::update::layout::{LOG_END, LOG_START};
use courier_sensor::update::trial;

/// Every so many steps of a start on trial are cut.
const STRIDE: usize = 9;

fn append(board: &mut Board, running: &Running, number: u32) {
    let head = Head {
        number,
        start: 1,
        time: Instant::default(),
    };
    let mut log = EventLog::new(board.far(running), LOG_START..LOG_END);
    log.append(&head, &Event::Status(number)).unwrap();
}

fn last(board: &mut Board, running: &Running) -> u32 {
    let mut log = EventLog::new(board.far(running), LOG_START..LOG_END);
    log.end().last.number
}

#[test]
fn the_story_goes_on_with_the_next_image_and_with_the_one_before() {
    let mut board = Board::factory(1, true);
    let running = board.start().unwrap();
    (1..=100).for_each(|number| append(&mut board, &running, number));
    board.update(&running, &image(2)).unwrap();
    let before = board.clone();
    let running = board.start().unwrap();
    let number = running.standing.trial.expect("it is on trial");
    assert_eq!((running.minor, last(&mut board, &running)), (2, 100));
    trial::refuse(board.far(&running), number).unwrap();
    let running = board.start().unwrap();
    assert_eq!((running.minor, last(&mut board, &running)), (1, 100));
    // Whatever the supply does meanwhile.
    let mut whole = before.clone();
    whole.start().unwrap();
    let steps = whole.steps() - before.steps();
    for cut in (0..steps).step_by(STRIDE) {
        let mut board = before.clone();
        board.cut_after(cut);
        let _ = board.start();
        board.power_up();
        let running = board.start().unwrap();
        assert_eq!(
            (running.minor, last(&mut board, &running)),
            (2, 100),
            "cut {cut} of {steps}"
        );
        assert!(board.accept(&running));
        append(&mut board, &running, 101);
        assert_eq!(last(&mut board, &running), 101);
    }
}
