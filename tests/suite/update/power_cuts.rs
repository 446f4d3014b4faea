//! The power may go at any step of any phase of an update: a whole image starts, and no calibration is lost.

use super::rig::{Board, Running, image};
use courier_sensor::update::header::BYTES;
use courier_sensor::update::journal::{self, Kind};
use courier_sensor::update::layout::{IMAGE_START, JOURNAL_START};
use effects::random::{ChaCha8Rng, SeedableRng, uniform};

/// What a board is seen to be: the version that starts, whether on trial, and its calibration.
type Seen = (u16, bool, Option<u32>);

/// From one reset to the next: what the image that starts is asked for.
struct Phase {
    work: fn(&mut Board, &Running),
    /// What may start after it, cut or not.
    allowed: &'static [Seen],
    /// What starts after it if nothing was cut.
    ends: Seen,
}

fn accept(board: &mut Board, running: &Running) {
    if running.standing.trial.is_some() {
        board.accept(running);
    }
}

fn commit(board: &mut Board, running: &Running, mark: u32) {
    if running.standing.trial.is_none() && running.standing.moved.is_ok() {
        board.commit(running, mark);
    }
}

fn update(board: &mut Board, running: &Running, minor: u16) {
    if running.minor < minor && running.standing.trial.is_none() {
        let _ = board.update(running, &image(minor));
    }
}

/// Two updates, so that either bank is once the one that is written.
const PHASES: [Phase; 7] = [
    Phase {
        work: |board, running| commit(board, running, 10),
        allowed: &[(1, false, None), (1, false, Some(10))],
        ends: (1, false, Some(10)),
    },
    Phase {
        work: |board, running| update(board, running, 2),
        allowed: &[(1, false, Some(10)), (2, true, Some(10))],
        ends: (2, true, Some(10)),
    },
    Phase {
        work: accept,
        allowed: &[(2, true, Some(10)), (2, false, Some(10))],
        ends: (2, false, Some(10)),
    },
    Phase {
        work: |board, running| commit(board, running, 11),
        allowed: &[(2, false, Some(10)), (2, false, Some(11))],
        ends: (2, false, Some(11)),
    },
    Phase {
        work: |board, running| update(board, running, 3),
        allowed: &[(2, false, Some(11)), (3, true, Some(11))],
        ends: (3, true, Some(11)),
    },
    Phase {
        work: accept,
        allowed: &[(3, true, Some(11)), (3, false, Some(11))],
        ends: (3, false, Some(11)),
    },
    Phase {
        work: |board, running| commit(board, running, 12),
        allowed: &[(3, false, Some(11)), (3, false, Some(12))],
        ends: (3, false, Some(12)),
    },
];

fn seen(board: &mut Board) -> Seen {
    let running = board.start().expect("nothing starts");
    let trial = running.standing.trial.is_some();
    (running.minor, trial, board.calibration(&running))
}

fn run(board: &mut Board, phase: &Phase) {
    if let Some(running) = board.start() {
        (phase.work)(board, &running);
    }
}

/// Runs a phase with a cut after so many steps, and brings the power back.
fn cut(board: &mut Board, phase: &Phase, steps: u64) {
    board.cut_after(steps);
    run(board, phase);
    board.power_up();
}

/// Every step of what comes first and last, where erases and marks are. Between them are hundreds of bytes of an image or a record: there
/// every seventh, so that each erase of 8 steps is cut and each byte of a double word is.
fn is_tried(after: u64, steps: u64) -> bool {
    after < 40 || after + 24 > steps || after % 7 == 0
}

/// Brings a board to version 0.3.0, accepted, with calibration 12, from wherever it is, and counts the resets.
fn drive(board: &mut Board) -> usize {
    for resets in 0..12 {
        let running = board.start().expect("nothing starts");
        match running.standing.trial {
            Some(_) => accept(board, &running),
            None if running.minor < 3 => update(board, &running, 3),
            None if board.calibration(&running) != Some(12) => commit(board, &running, 12),
            None => return resets,
        }
    }
    panic!("the board cannot be brought where it is to be")
}

#[test]
fn from_any_cut_a_whole_image_starts_and_no_calibration_is_lost() {
    for (ecc, seed) in [(true, 1), (false, 2)] {
        let mut board = Board::factory(seed, ecc);
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        for (number, phase) in PHASES.iter().enumerate() {
            let before = board.clone();
            let begin = board.steps();
            run(&mut board, phase);
            let steps = board.steps() - begin;
            let (mut last, mut others) = (before.clone(), 0);
            for after in (0..steps).filter(|after| is_tried(*after, steps)) {
                last.clone_from(&before);
                cut(&mut last, phase, after);
                let found = seen(&mut last.clone());
                let place = format!("phase {number}, cut {after} of {steps}, ecc {ecc}");
                assert!(phase.allowed.contains(&found), "{place}: {found:?}");
                others += u32::from(found != phase.ends);
                // Now and then it is cut once more and then used as if nothing had been.
                if after % 41 == 0 {
                    let again = uniform(&mut rng, 0.0, steps as f64) as u64;
                    cut(&mut last, phase, again);
                    let found = seen(&mut last.clone());
                    assert!(
                        phase.allowed.contains(&found),
                        "{place}, {again}: {found:?}"
                    );
                    drive(&mut last);
                    assert_eq!(seen(&mut last), (3, false, Some(12)), "{place}");
                }
            }
            assert!(others > 0, "phase {number}: no cut took effect");
            assert_eq!(seen(&mut board.clone()), phase.ends, "phase {number}");
        }
    }
}

/// The copy that is made after a probe has written the board: the newest calibration is in force from any cut, and the one before it is
/// still there to go back to.
#[test]
fn a_cut_in_the_copy_after_a_probe_loses_neither_calibration() {
    let mut board = Board::factory(1, true);
    PHASES[..4].iter().for_each(|phase| run(&mut board, phase));
    board.written_by_probe();
    let begin = board.steps();
    assert_eq!(seen(&mut board.clone()), (1, false, Some(11)));
    let mut copied = board.clone();
    copied.start();
    let steps = copied.steps() - begin;
    assert!(
        steps > 2 * 8,
        "{steps} steps: nothing is copied behind the erases"
    );
    for after in 0..steps {
        let mut last = board.clone();
        last.cut_after(after);
        last.start();
        last.power_up();
        let running = last.start().unwrap();
        assert_eq!(last.calibration(&running), Some(11), "cut {after}");
        last.roll_back(&running);
        assert_eq!(last.calibration(&running), Some(10), "cut {after}");
    }
}

/// Cuts at every start on trial use the trials up, and the old image comes back.
#[test]
fn a_board_whose_supply_fails_at_every_trial_goes_back() {
    let mut board = Board::factory(1, true);
    run(&mut board, &PHASES[0]);
    run(&mut board, &PHASES[1]);
    let mut starts = 0;
    while board.start().unwrap().minor == 2 {
        starts += 1;
    }
    assert_eq!(starts, 3);
    assert_eq!(seen(&mut board), (1, false, Some(10)));
}

/// A mark that was torn may read as itself at one start and as damaged at the next. What was stored after the first is not lost.
#[test]
fn a_mark_of_acceptance_that_comes_and_goes_loses_nothing() {
    let mut board = Board::factory(1, true);
    PHASES[..2].iter().for_each(|phase| run(&mut board, phase));
    let running = board.start().unwrap();
    let number = running.standing.trial.unwrap();
    let place = journal::read(board.far(&running)).free.unwrap() as usize;
    // The supply goes in the first of the two marks, which reads as itself.
    let mark = journal::encode(number, Kind::Accepted);
    board.banks[0].force(place, &mark);
    let running = board.start().unwrap();
    assert_eq!((running.minor, running.standing.trial), (2, None));
    assert!(board.commit(&running, 11));
    // Now it reads as damaged.
    board.banks[0].force(place, &[mark[0], mark[1], mark[2], 0xA5]);
    assert_eq!(seen(&mut board), (2, false, Some(11)));
}

/// The same of the header, the last that is programmed of an image: whichever way it reads, what was stored last is found.
#[test]
fn a_header_that_comes_and_goes_loses_nothing() {
    let mut board = Board::factory(1, true);
    PHASES[..2].iter().for_each(|phase| run(&mut board, phase));
    let place = IMAGE_START as usize + BYTES - 8;
    let whole: Vec<u8> = board.banks[1].bytes()[place..place + 8].to_vec();
    let read_as = |board: &mut Board, whole: Option<&[u8]>| match whole {
        Some(bytes) => board.banks[1].force(place, bytes),
        None => board.banks[1].force(place, &[0xA5]),
    };
    read_as(&mut board, None);
    assert_eq!(seen(&mut board), (1, false, Some(10)));
    read_as(&mut board, Some(&whole));
    assert_eq!(seen(&mut board), (2, true, Some(10)));
    let running = board.start().unwrap();
    assert!(board.accept(&running));
    for (reads, minor, mark) in [(true, 2, 11), (false, 1, 12), (true, 2, 13), (false, 1, 14)] {
        read_as(&mut board, reads.then_some(&whole));
        let running = board.start().unwrap();
        assert_eq!((running.minor, running.standing.trial), (minor, None));
        assert_eq!(board.calibration(&running), Some(mark - 1));
        assert!(board.commit(&running, mark));
    }
}

/// A journal whose page is full takes no trial: the new image is not started at all.
#[test]
fn a_full_journal_starts_no_trial() {
    let mut board = Board::factory(1, true);
    PHASES[..2].iter().for_each(|phase| run(&mut board, phase));
    board.banks[0].force(JOURNAL_START as usize + 2040, &[0]);
    assert_eq!(seen(&mut board), (1, false, Some(10)));
}
