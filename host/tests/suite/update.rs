//! `courier update` on the simulated board: kept, given up, refused.

use crate::common::{CALIBRATE, asked};
use courier::board::{DEVELOPMENT_SEED, Image};
use courier_sensor::update::version::Version;
use std::path::Path;

fn image(board: &str, version: &str, seed: [u8; 32]) -> Image {
    let version = Version::parse(version).unwrap();
    Image::sign(seed, board, version, vec![0x5A; 10_000]).unwrap()
}

fn written(folder: &Path, name: &str, file: &[u8]) {
    std::fs::write(folder.join(name), file).unwrap();
}

#[test]
fn an_image_is_kept_and_the_calibration_is_still_in_force() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    written(
        folder,
        "new.img",
        &image("simulated", "9.0.0", DEVELOPMENT_SEED).file(),
    );
    asked(folder, CALIBRATE).quiet();
    let words = "--sim-preset ideal --sim-flash a.bin update new.img --json";
    let told = asked(folder, words).json();
    assert_eq!(told["running"], "9.0.0");
    assert_eq!(told["before"], env!("CARGO_PKG_VERSION"));
    assert_eq!(told["on_trial"], false);
    assert_eq!(told["development_key"], true);
    assert_eq!(told.get("given_up"), None);
    // The file holds what the new image has stored.
    let slots = asked(folder, "--sim-preset ideal --sim-flash a.bin slots --json").json();
    assert_eq!(slots[0]["sequence"], 1, "{slots}");
    let text = asked(folder, "update new.img").quiet();
    assert!(text.contains("9.0.0, kept"), "{text}");
    assert!(text.contains("development key"), "{text}");
}

#[test]
fn without_an_image_it_tells_how_the_firmware_stands() {
    let folder = tempfile::tempdir().unwrap();
    let text = asked(folder.path(), "update").quiet();
    let version = env!("CARGO_PKG_VERSION");
    assert!(text.contains(&format!("{version}, kept")), "{text}");
    for words in ["update --accept", "update --refuse"] {
        asked(folder.path(), words).refused(&["no image is on trial"]);
    }
}

#[test]
fn an_image_left_on_trial_says_how_long_it_has() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    written(
        folder,
        "new.img",
        &image("simulated", "9.0.0", DEVELOPMENT_SEED).file(),
    );
    let told = asked(folder, "update new.img --leave-on-trial --json").json();
    assert_eq!(
        (&told["running"], &told["on_trial"]),
        (&"9.0.0".into(), &true.into())
    );
}

#[test]
fn images_that_the_board_or_the_command_does_not_take_are_told_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let good = image("simulated", "9.0.0", DEVELOPMENT_SEED);
    let file = good.file();
    let mut forged = good.clone();
    forged.header.version = Version::parse("10.0.0").unwrap();
    let flipped = |place: usize| {
        let mut file = file.clone();
        file[place] ^= 1;
        file
    };
    let files: [(&str, Vec<u8>, &str); 9] = [
        ("empty.img", vec![], "found 0 bytes"),
        (
            "text.img",
            b"no image at all".repeat(100),
            "no image of this firmware",
        ),
        (
            "half.img",
            file[..file.len() / 2].to_vec(),
            "the file is not whole",
        ),
        ("header.img", flipped(20), "the header is damaged"),
        ("body.img", flipped(5000), "another check value"),
        ("forged.img", forged.file(), "wrong signature"),
        (
            "board.img",
            image("g474", "9.0.0", DEVELOPMENT_SEED).file(),
            "for another board",
        ),
        (
            "key.img",
            image("simulated", "9.0.0", [7; 32]).file(),
            "a key that the board's firmware does not trust",
        ),
        (
            "old.img",
            image("simulated", "0.0.1", DEVELOPMENT_SEED).file(),
            "version 0.0.1, older than",
        ),
    ];
    for (name, file, wanted) in files {
        written(folder, name, &file);
        asked(folder, &format!("update {name}")).refused(&[wanted]);
    }
    let told = asked(folder, "update old.img --older --json").json();
    assert_eq!(told["running"], "0.0.1");
    asked(folder, "update none.img").refused(&["none.img"]);
}
