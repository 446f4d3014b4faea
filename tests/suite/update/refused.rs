//! Images that are not taken: each is named, and what ran still runs.

use super::rig::{Board, Image, Running, SEED, image, image_of, version};
use courier_sensor::update::install::{Install, Progress, UpdateRefusal};
use courier_sensor::update::layout::BODY_START;
use hal_sim::wire::flash::{Flash, PAGE_BYTES};

fn refused(image: &Image) -> UpdateRefusal {
    let mut board = Board::factory(1, true);
    let running = board.start().unwrap();
    board.commit(&running, 3);
    let refusal = board.update(&running, image).unwrap_err();
    let after = board.start().unwrap();
    assert_eq!((after.minor, board.calibration(&after)), (1, Some(3)));
    refusal
}

#[test]
fn other_boards_keys_and_older_versions_are_refused_by_their_header() {
    let other = image_of("h743", 2, SEED, 2048);
    assert_eq!(refused(&other), UpdateRefusal::OtherBoard);
    let other = image_of("g474", 2, [7; 32], 2048);
    assert_eq!(refused(&other), UpdateRefusal::OtherKey);
    let (found, running) = (version(0), version(1));
    assert_eq!(refused(&image(0)), UpdateRefusal::Older { found, running });
    let mut damaged = image(2);
    damaged.header[40] ^= 1;
    assert_eq!(refused(&damaged), UpdateRefusal::Header);
}

#[test]
fn a_body_or_a_header_that_was_changed_after_signing_is_refused() {
    let mut changed = image(2);
    changed.body[1000] ^= 1;
    assert_eq!(refused(&changed), UpdateRefusal::Damaged);
    // With a check value that is right again, the signature tells.
    let (mut made, other) = (image(2), image(3));
    made.body = other.body;
    let of_other = courier_sensor::update::header::Header::parse(&other.header).unwrap();
    let mut header = courier_sensor::update::header::Header::parse(&made.header).unwrap();
    header.body_crc = of_other.body_crc;
    made.header = header.encode();
    assert_eq!(refused(&made), UpdateRefusal::Signature);
    let mut header = courier_sensor::update::header::Header::parse(&image(2).header).unwrap();
    header.version = version(9);
    let raised = Image {
        header: header.encode(),
        ..image(2)
    };
    assert_eq!(refused(&raised), UpdateRefusal::Signature);
}

fn begun(board: &mut Board, running: &Running, image: &Image) -> Install {
    let rules = Board::rules(running);
    Install::begin(board.far(running), &image.header, &rules, 1).unwrap()
}

#[test]
fn pieces_in_the_wrong_place_are_refused_and_the_right_ones_still_taken() {
    let mut board = Board::factory(1, true);
    let running = board.start().unwrap();
    let image = image(2);
    let mut install = begun(&mut board, &running, &image);
    let far = board.far(&running);
    let mut data = |install: &mut Install, offset, piece: &[u8]| install.data(far, offset, piece);
    assert_eq!(data(&mut install, 0, &image.body[..80]), Ok(()));
    // As a host sends it again whose answer was lost.
    let (found, wanted) = (0, 80);
    assert_eq!(
        data(&mut install, 0, &image.body[..80]),
        Err(UpdateRefusal::Offset { found, wanted })
    );
    for found in [0, 7, 2048] {
        let piece = vec![0; found as usize];
        assert_eq!(
            data(&mut install, 80, &piece),
            Err(UpdateRefusal::Length { found })
        );
    }
    assert_eq!(
        install.finish(),
        Err(UpdateRefusal::Incomplete {
            found: 80,
            wanted: 2048
        })
    );
    assert_eq!(data(&mut install, 80, &image.body[80..]), Ok(()));
    assert_eq!(install.finish(), Ok(()));
    while install.work(board.far(&running)) {}
    assert_eq!(
        install.progress(),
        Progress::Installed {
            version: version(2)
        }
    );
    assert_eq!(install.finish(), Err(UpdateRefusal::NotBegun));
    assert_eq!(
        Install::default().data(board.far(&running), 0, &[0; 8]),
        Err(UpdateRefusal::NotBegun)
    );
}

#[test]
fn flash_that_fails_is_told_and_the_image_is_not_installed() {
    let mut board = Board::factory(1, true);
    let running = board.start().unwrap();
    let image = image(2);
    let mut install = begun(&mut board, &running, &image);
    board.far(&running).force(BODY_START as usize + 400, &[0]);
    let data = install.data(board.far(&running), 0, &image.body[..800]);
    assert_eq!(data, Err(UpdateRefusal::Flash));
    assert_eq!(install.progress(), Progress::Failed(UpdateRefusal::Flash));
    board.far(&running).wear_out();
    let rules = Board::rules(&running);
    let again = Install::begin(board.far(&running), &image.header, &rules, 1);
    assert!(matches!(again, Err(UpdateRefusal::Flash)));
    assert_eq!(board.start().unwrap().minor, 1);
}

#[test]
fn a_flash_of_slots_alone_takes_no_image() {
    let mut board = Board::factory(1, true);
    let running = board.start().unwrap();
    let rules = Board::rules(&running);
    let mut small = Flash::new(4, 1);
    let begun = Install::begin(&mut small, &image(2).header, &rules, 1);
    assert!(matches!(begun, Err(UpdateRefusal::NotOffered)));
    assert_eq!(small.bytes(), vec![0xFF; 4 * PAGE_BYTES]);
}
