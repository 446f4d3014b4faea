//! Which image starts, without any cut.

use super::rig::{Board, image};
use courier_sensor::update::choice::{Candidate, TRIALS, candidates};
use courier_sensor::update::header::Header;
use courier_sensor::update::journal::Journal;
use courier_sensor::update::layout::{BODY_START, IMAGE_START};
use courier_sensor::update::standing::Bank;
use courier_sensor::update::trial;
use embedded_storage::nor_flash::NorFlash;
use hal_sim::wire::flash::PAGE_BYTES;

#[test]
fn an_accepted_image_stays_and_the_calibration_moves_with_it() {
    let mut board = Board::factory(1, true);
    for minor in 2..7 {
        let running = board.start().unwrap();
        assert_eq!((running.minor, running.standing.trial), (minor - 1, None));
        assert!(board.commit(&running, u32::from(minor)));
        board.update(&running, &image(minor)).unwrap();
        let running = board.start().unwrap();
        assert_eq!(running.minor, minor);
        assert_eq!(board.calibration(&running), Some(u32::from(minor)));
        assert!(board.accept(&running));
    }
    let running = board.start().unwrap();
    assert_eq!((running.minor, running.standing.trial), (6, None));
}

#[test]
fn an_image_that_nobody_accepts_is_tried_and_goes_back() {
    let mut board = Board::factory(1, true);
    let running = board.start().unwrap();
    board.commit(&running, 5);
    board.update(&running, &image(2)).unwrap();
    for _ in 0..TRIALS {
        let running = board.start().unwrap();
        assert!(running.minor == 2 && running.standing.trial.is_some());
    }
    for _ in 0..3 {
        let running = board.start().unwrap();
        assert_eq!((running.minor, running.standing.trial), (1, None));
        assert_eq!(board.calibration(&running), Some(5));
    }
    // And the board takes the next.
    let running = board.start().unwrap();
    board.update(&running, &image(3)).unwrap();
    assert_eq!(board.start().unwrap().minor, 3);
}

#[test]
fn a_refused_image_goes_back_at_once() {
    let mut board = Board::factory(1, true);
    let running = board.start().unwrap();
    board.update(&running, &image(2)).unwrap();
    let running = board.start().unwrap();
    trial::refuse(board.far(&running), running.standing.trial.unwrap()).unwrap();
    assert_eq!(board.start().unwrap().minor, 1);
}

/// What is done to the slots while an image is refused is not undone by the copy that it made.
#[test]
fn the_old_image_finds_what_it_had_and_the_next_one_finds_what_was_changed_since() {
    let mut board = Board::factory(1, true);
    let running = board.start().unwrap();
    board.commit(&running, 5);
    board.commit(&running, 6);
    board.update(&running, &image(2)).unwrap();
    let running = board.start().unwrap();
    assert_eq!(board.calibration(&running), Some(6));
    trial::refuse(board.far(&running), running.standing.trial.unwrap()).unwrap();
    let running = board.start().unwrap();
    board.roll_back(&running);
    assert_eq!(board.calibration(&running), Some(5));
    board.update(&running, &image(3)).unwrap();
    let running = board.start().unwrap();
    assert_eq!((running.minor, board.calibration(&running)), (3, Some(5)));
}

/// A debug probe writes bank 1 and erases the other image's header; the calibration lay beside where the image now is.
#[test]
fn the_calibration_is_found_after_a_probe_has_written_the_board() {
    let mut board = Board::factory(1, true);
    let running = board.start().unwrap();
    board.update(&running, &image(2)).unwrap();
    let running = board.start().unwrap();
    assert!(board.accept(&running));
    let running = board.start().unwrap();
    board.commit(&running, 8);
    board.written_by_probe();
    let running = board.start().unwrap();
    assert_eq!((running.minor, board.calibration(&running)), (1, Some(8)));
    board.commit(&running, 9);
    let running = board.start().unwrap();
    assert_eq!(
        board.calibration(&running),
        Some(9),
        "it is not copied anew"
    );
}

/// A probe that leaves the journal in bank 1 alone: what it says of the image before is not said of the next one.
#[test]
fn an_image_is_on_trial_whatever_is_known_of_the_one_before() {
    let mut board = Board::factory(1, true);
    let running = board.start().unwrap();
    board.update(&running, &image(2)).unwrap();
    let running = board.start().unwrap();
    assert!(board.accept(&running));
    let header = IMAGE_START as usize..IMAGE_START as usize + PAGE_BYTES;
    board.banks[1]
        .erase(header.start as u32, header.end as u32)
        .unwrap();
    let running = board.start().unwrap();
    assert_eq!((running.bank, running.standing.trial), (0, None));
    board.update(&running, &image(3)).unwrap();
    let running = board.start().unwrap();
    assert_eq!((running.minor, running.standing.trial.is_some()), (3, true));
    assert!(board.accept(&running));
    let running = board.start().unwrap();
    assert_eq!((running.minor, running.standing.trial), (3, None));
}

/// Code that decays is found before it is started.
#[test]
fn a_decayed_image_is_not_started_while_there_is_another() {
    let mut board = Board::factory(1, true);
    let running = board.start().unwrap();
    board.update(&running, &image(2)).unwrap();
    let running = board.start().unwrap();
    assert!(board.accept(&running));
    board.banks[1].force(BODY_START as usize + 77, &[0x55]);
    let running = board.start().unwrap();
    assert_eq!((running.minor, running.standing.trial), (1, None));
    board.banks[0].force(BODY_START as usize + 77, &[0x55]);
    assert_eq!(board.start(), None);
}

/// The rule against its words, over every state that two banks can be in.
#[test]
fn every_state_starts_an_image_if_there_is_one() {
    let header = Header::parse(&image(1).header).unwrap();
    let numbers = [None, Some(1), Some(2)];
    let journals: Vec<Journal> = [
        (0, 0, 0, false),
        (1, 1, 0, false),
        (2, 1, 0, false),
        (2, TRIALS, 0, false),
        (2, 1, 0, true),
        (2, 1, 1, false),
        (1, 1, 2, false),
    ]
    .map(|(number, trials, accepted, refused)| Journal {
        number,
        trials,
        accepted,
        refused,
        free: None,
    })
    .to_vec();
    let banks: Vec<Bank> = [None, Some(header)]
        .into_iter()
        .flat_map(|header| numbers.map(|number| (header, number)))
        .flat_map(|(header, number)| {
            journals.iter().map(move |journal| Bank {
                header,
                number,
                journal: *journal,
            })
        })
        .collect();
    for first in &banks {
        for second in &banks {
            let both = [*first, *second];
            let found = candidates(&both);
            let there = both.map(|bank| bank.header.is_some());
            for bank in 0..2 {
                let settled = Candidate { bank, trial: None };
                assert_eq!(found.contains(&settled), there[bank], "{both:?}: {found:?}");
            }
            assert!(found.iter().all(|found| there[found.bank]));
            let Some(Candidate {
                bank,
                trial: Some(number),
            }) = found.first()
            else {
                continue;
            };
            let (own, other) = (both[*bank], both[1 - bank]);
            assert!(there == [true; 2] && own.number == Some(*number) && own.number > other.number);
            assert!(
                other.journal.number != *number
                    || other.journal.trials < TRIALS && !other.journal.refused
            );
        }
    }
}
