//! The board's end of an update: time that runs out, and what it says of itself.

use super::rig::{Board, Running, image};
use courier_sensor::app::updates::{Updater, Updates};
use courier_sensor::update::install::{Progress, UpdateRefusal};
use courier_sensor::update::order::{PIECE_BYTES, UpdateOrder};
use courier_sensor::update::standing;
use courier_sensor::update::trial::TRIAL_S;
use hal_sim::wire::flash::Flash;

fn on_trial() -> (Board, Running, Updater) {
    let mut board = Board::factory(1, true);
    let running = board.start().unwrap();
    board.update(&running, &image(2)).unwrap();
    let running = board.start().unwrap();
    let near = standing::read(&mut board.banks[running.bank]);
    let updater = Updater::new(&near, Board::rules(&running), running.standing);
    (board, running, updater)
}

fn is_over(updater: &mut Updater, far: &mut Flash, uptime_s: u32) -> bool {
    Updates::is_over(updater, far, uptime_s)
}

#[test]
fn an_image_whose_time_is_over_is_refused_and_does_not_start_again() {
    let (mut board, running, mut updater) = on_trial();
    let far = board.far(&running);
    let status = updater.act(far, &UpdateOrder::Status, 20).unwrap();
    assert_eq!(status.trial_left_s, Some(TRIAL_S - 20));
    assert!(status.development_key);
    assert!(!is_over(&mut updater, far, TRIAL_S - 1));
    let before = far.steps();
    assert!(is_over(&mut updater, far, TRIAL_S));
    assert!(is_over(&mut updater, far, TRIAL_S + 1));
    assert_eq!(
        far.steps() - before,
        8,
        "one mark, however often it is asked"
    );
    assert_eq!(
        updater.act(far, &UpdateOrder::Accept, TRIAL_S + 1),
        Err(UpdateRefusal::NotOnTrial)
    );
    assert_eq!(board.start().unwrap().minor, 1);
}

#[test]
fn an_accepted_image_has_no_end() {
    let (mut board, running, mut updater) = on_trial();
    let far = board.far(&running);
    assert!(Updates::<Flash>::is_on_trial(&updater));
    let status = updater.act(far, &UpdateOrder::Accept, 5).unwrap();
    assert_eq!(status.trial_left_s, None);
    assert!(!is_over(&mut updater, far, 10 * TRIAL_S));
    assert!(!Updates::<Flash>::is_on_trial(&updater));
    assert_eq!(board.start().unwrap().minor, 2);
}

/// Flash that no longer erases cannot take the calibration over: the image is not accepted.
#[test]
fn an_image_that_could_not_move_the_calibration_is_not_accepted() {
    let mut board = Board::factory(1, true);
    let running = board.start().unwrap();
    board.commit(&running, 4);
    board.update(&running, &image(2)).unwrap();
    board.banks[0].wear_out();
    let running = board.start().unwrap();
    assert!(running.standing.moved.is_err());
    let near = standing::read(&mut board.banks[1]);
    let mut updater = Updater::new(&near, Board::rules(&running), running.standing);
    let accepted = updater.act(board.far(&running), &UpdateOrder::Accept, 5);
    assert_eq!(accepted, Err(UpdateRefusal::NotMoved));
}

/// From its first order until it is installed: no calibration begins meanwhile.
#[test]
fn an_update_is_under_way_until_its_image_is_checked() {
    let mut board = Board::factory(1, true);
    let running = board.start().unwrap();
    let near = standing::read(&mut board.banks[running.bank]);
    let mut updater = Updater::new(&near, Board::rules(&running), running.standing);
    let (image, far) = (image(2), board.far(&running));
    let header = heapless::Vec::from_slice(&image.header).unwrap();
    let begin = UpdateOrder::Begin {
        header,
        allow_older: false,
    };
    let pieces = image
        .body
        .chunks(PIECE_BYTES)
        .zip((0..).step_by(PIECE_BYTES));
    let pieces = pieces.map(|(piece, offset)| UpdateOrder::Piece {
        offset,
        bytes: heapless::Vec::from_slice(piece).unwrap(),
    });
    let is_under_way = |updater: &Updater| Updates::<Flash>::is_under_way(updater);
    assert!(!is_under_way(&updater));
    for order in [begin]
        .into_iter()
        .chain(pieces)
        .chain([UpdateOrder::Finish])
    {
        updater.act(far, &order, 1).unwrap();
        assert!(is_under_way(&updater), "{order:?}");
    }
    while updater.work(far) {
        let progress = updater.act(far, &UpdateOrder::Status, 1).unwrap().progress;
        let is_checking = matches!(progress, Progress::Checking { .. });
        assert_eq!(is_under_way(&updater), is_checking, "{progress:?}");
    }
    assert!(!is_under_way(&updater));
}
