//! The joint calibration's bad input at the command line: each refused or reported by name with both numbers, and what the
//! board had stored stays as it was, to the byte: all of its flash but the log, which tells of the refusal.

use crate::common::{CALIBRATE, asked, courier_in, json_in};
use courier_sensor::update::layout::{LOG_START, MAPS_END, MAPS_START, PAGE_BYTES, SLOTS_START};
use std::path::Path;

const JOINTLY: [&str; 6] = ["calibrate", "--joint", "--poses", "60", "--held-out", "24"];

/// A board with a platen calibration stored: its flash in `a.bin`, the calibration in `good.json`.
fn calibrated(folder: &Path) {
    asked(folder, CALIBRATE).quiet();
    asked(
        folder,
        "--sim-preset ideal --sim-flash a.bin export good.json",
    )
    .quiet();
}

/// Runs with these options before the command and after it; exit code, and what was said on either stream.
fn joint(folder: &Path, flash: &str, board: &[&str], session: &[&str]) -> (i32, String) {
    let options = ["--sim-preset", "ideal", "--sim-flash", flash];
    let ran = courier_in(folder, &[&options[..], board, &JOINTLY, session].concat());
    (ran.code, ran.out + &ran.err)
}

/// What a board has stored, without its log. A file has the slots, the journal and the log's first page, then the maps, then the rest of
/// the log.
fn without_log(folder: &Path, flash: &str) -> Vec<u8> {
    let bytes = std::fs::read(folder.join(flash)).unwrap();
    let (first_page, maps) = (LOG_START - SLOTS_START, MAPS_END - MAPS_START);
    let (slots, rest) = bytes.split_at(first_page as usize);
    let behind = &rest[PAGE_BYTES as usize..][..maps as usize];
    [slots, behind].concat()
}

/// Refused by the session with these words; the flash is as it was.
fn refused(folder: &Path, flash: &str, board: &[&str], session: &[&str], wanted: &[&str]) {
    let before = without_log(folder, flash);
    let (code, said) = joint(folder, flash, board, session);
    println!("{board:?} {session:?}: {said}");
    assert_eq!(code, 1, "{said}");
    for word in [
        &["refused: ", "the calibration in force before stays"],
        wanted,
    ]
    .concat()
    {
        assert!(said.contains(word), "{board:?}: wanted {word:?} in {said}");
    }
    assert!(
        before == without_log(folder, flash),
        "{board:?}: the flash was changed"
    );
}

/// The exported calibration with another lever arm l_x.
fn with_lever(folder: &Path, name: &str, lever_m: f64) {
    let mut file = json_in(folder.join("good.json"));
    file["calibration"]["geometry"]["lever_m"][0] = lever_m.into();
    std::fs::write(folder.join(name), file.to_string()).unwrap();
}

#[test]
fn light_that_is_not_the_one_beacons() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    calibrated(folder);
    let cases: [(&str, &[&str]); 3] = [
        (
            "beacon-blinks",
            &["no beacon seen", "unusable frames, limit "],
        ),
        (
            "second-beacon",
            &[
                "light on the coordination sensor changed",
                " counts at ",
                " at the first, limit 0.30",
            ],
        ),
        (
            "stray-light",
            &["at the converter's end", "unusable frames, limit "],
        ),
    ];
    for (fault, wanted) in cases {
        refused(folder, "a.bin", &["--sim-fault", fault], &[], wanted);
    }
    // Nothing wrong: the same session is accepted, so it was the light.
    let (code, said) = joint(folder, "a.bin", &[], &[]);
    assert_eq!(code, 0, "{said}");
}

#[test]
fn a_motion_without_rotation() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    calibrated(folder);
    let wanted = [
        "turned by",
        "rad rms, wanted 1.75e-3 rad or more",
        "lever arm",
    ];
    refused(folder, "a.bin", &[], &["--turn-deg", "0"], &wanted);
}

#[test]
fn a_lever_arm_of_the_wrong_sign_or_in_millimetres() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    calibrated(folder);
    with_lever(folder, "sign.json", -0.09);
    let import = |file: &str| {
        let words = format!("--sim-preset ideal --sim-flash b.bin import {file} --other-geometry");
        asked(folder, &words)
    };
    import("sign.json").quiet();
    let wanted = [
        "lever arm l_x is",
        "m by the data, entered -9e-2 m",
        "limit of the difference",
    ];
    refused(folder, "b.bin", &[], &[], &wanted);

    with_lever(folder, "millimetres.json", 90.0);
    let before = std::fs::read(folder.join("b.bin")).unwrap();
    import("millimetres.json").refused(&["millimetres.json", "lever_m is 90, wanted -1", "metres"]);
    assert!(before == std::fs::read(folder.join("b.bin")).unwrap());
}
