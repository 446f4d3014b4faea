//! The collected inputs that once went wrong, in `cases` beside the real recordings: none ends in an error of the program, and those with
//! wrong units or wires are told as such. Each kind has a test that makes its own data elsewhere; this one only looks at the folder.

use crate::common::courier_in;
use std::path::{Path, PathBuf};

/// Cases whose units, reference, geometry or wires are wrong, and what is told of each.
const WRONG: [(&str, &str); 9] = [
    ("full-scale-in-degrees", "tan_full_scale in degrees?"),
    (
        "lever-sign",
        "lever_x_m has the wrong sign: 90.00 mm by the data",
    ),
    (
        "pitch-1pc-off-against-reference",
        "pitch 1.026 mm by the data, 1.016 mm stated",
    ),
    (
        "pitch-doubled",
        "pitch 1.016 mm by the data, 2.032 mm stated",
    ),
    ("positions-in-mm", "a thousand times too large: mm?"),
    ("reference-in-mm", "a thousand times too large: mm?"),
    ("reference-is-the-sensor", "holds the readings of segment 1"),
    (
        "segments-1-2-swapped-slow",
        "segment 1 follows y, segment 2 follows x",
    ),
    ("segments-1-3-swapped", "segments 1 and 3 are exchanged"),
];

/// What is told of a case; `None` where wires, units and geometry are right.
fn told_of(case: &Path) -> Option<&'static str> {
    let name = case.file_name()?.to_str()?;
    WRONG
        .iter()
        .find(|(known, _)| *known == name)
        .map(|(_, told)| *told)
}

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
        match told_of(&case) {
            // A replay has no use for the coordination sensor.
            Some(wanted) if name == "full-scale-in-degrees" || name == "lever-sign" => {
                assert!(ran.code < 2 && ran.err.contains(wanted), "{told}");
            }
            Some(wanted) => assert!(ran.code == 2 && ran.err.contains(wanted), "{told}"),
            None => assert!(!ran.err.contains("by the data"), "{told}"),
        }
    }
}

#[test]
fn what_cannot_be_right_is_not_diagnosed() {
    for case in recordings() {
        let Some(wanted) = told_of(&case) else {
            continue;
        };
        let ran = courier_in(
            Path::new("."),
            &["diagnose", case.to_str().unwrap(), "--json", "-"],
        );
        let answer = ran.json();
        assert_eq!(answer["verdict"], "insufficient_data", "{}", case.display());
        let notes = answer["notes"].to_string();
        assert!(notes.contains(wanted), "{}: {notes}", case.display());
        assert!(answer["findings"][0]["kind"].is_string(), "{answer}");
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
