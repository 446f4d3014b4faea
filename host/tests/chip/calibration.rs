//! A calibration and the demonstration on the image as it ships: half a minute of processor time each.

use crate::common::{asked, json};

/// The fewest poses that a platen calibration takes.
const POSES: u32 = 49;

#[test]
fn calibrate_is_accepted_and_stored() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let words = format!(
        "--chip --sim-preset ideal --sim-flash a.bin calibrate --plan optimal --poses {POSES} --held-out 10 --json"
    );
    let told = asked(folder, &words).json();
    assert_eq!(
        told["ending"]["Accepted"]["stored"]["sequence"], 1,
        "{told}"
    );
    let words = "--chip --sim-preset ideal --sim-flash a.bin status --json";
    let told = asked(folder, words).json();
    assert_eq!(
        told["status"]["in_force"]["Stored"]["sequence"], 1,
        "{told}"
    );
}

#[test]
fn the_demonstration_ends_accepted() {
    let folder = tempfile::tempdir().unwrap();
    let words = format!("demo --on chip --preset ideal --plan optimal --poses {POSES} --json");
    let ran = asked(folder.path(), &words);
    assert_eq!(ran.code, 0, "{} {}", ran.out, ran.err);
    let told = json(&ran.out);
    assert_eq!(told["accepted"], true, "{told}");
}
