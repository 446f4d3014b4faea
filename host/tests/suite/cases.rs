//! The collected inputs that once went wrong, in `cases` beside the real recordings: none ends in an error of the program, and those with
//! wrong units or wires are told as such. Each kind has a test that makes its own data elsewhere; this one only looks at the folder.

use crate::common::courier_in;
use std::path::{Path, PathBuf};

/// Cases whose units, reference or wires are wrong, so that what remains is no error of a sensor.
const OF_THE_PITCH: [&str; 5] = [
    "pitch-1pc-off-against-reference",
    "positions-in-mm",
    "reference-in-mm",
    "segments-1-2-swapped-slow",
    "segments-1-3-swapped",
];

/// The recordings of the folder; none, and said so, where it is absent.
fn recordings() -> Vec<PathBuf> {
    let Some(folder) = crate::common::shared_folder("cases") else {
        return Vec::new();
    };
    let entries = std::fs::read_dir(folder).unwrap();
    let paths = entries.map(|entry| entry.unwrap().path());
    let mut list: Vec<PathBuf> = paths
        .filter(|path| path.join("recording.toml").exists())
        .collect();
    list.sort();
    list
}

#[test]
fn every_recording_is_replayed_or_refused_in_one_line() {
    for case in recordings() {
        let name = case.file_name().unwrap().to_str().unwrap();
        let ran = courier_in(Path::new("."), &["replay", case.to_str().unwrap()]);
        let told = format!("{name}: {} {}", ran.out, ran.err);
        assert!((0..=2).contains(&ran.code), "{told}");
        if ran.code == 2 {
            ran.refused(&[]);
        }
        if OF_THE_PITCH.contains(&name) {
            assert!(ran.code == 1 && ran.err.contains("of the pitch"), "{told}");
        }
        if name == "reference-is-the-sensor" {
            assert!(ran.err.contains("the same readings"), "{told}");
        }
    }
}

#[test]
fn every_calibration_is_refused_and_nothing_is_stored() {
    let Some(folder) = crate::common::shared_folder("cases") else {
        return;
    };
    for file in std::fs::read_dir(folder.join("import")).unwrap() {
        let file = file.unwrap().path();
        let at = tempfile::tempdir().unwrap();
        let ran = courier_in(
            at.path(),
            &["--sim-flash", "f.bin", "import", file.to_str().unwrap()],
        );
        ran.refused(&[file.file_name().unwrap().to_str().unwrap(), "wanted"]);
        let slots = courier_in(at.path(), &["--sim-flash", "f.bin", "slots", "--json"]);
        let slots = slots.json();
        let empty = |slot: &serde_json::Value| slot["state"]["Refused"] == "Empty";
        assert!(slots.as_array().unwrap().iter().all(empty), "{slots}");
    }
}
