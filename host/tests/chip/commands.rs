//! The commands that talk to a board, on the image as it ships.

use crate::common::{CALIBRATE, asked, json};

/// Runs it on a chip of the `ideal` courier.
fn on_chip(folder: &std::path::Path, words: &str) -> crate::common::Ran {
    asked(folder, &format!("--chip --sim-preset ideal {words}"))
}

#[test]
fn status_tells_of_the_shipped_image_and_its_self_tests() {
    let folder = tempfile::tempdir().unwrap();
    let told = on_chip(folder.path(), "status --json").json();
    assert_eq!(told["board"]["board"], "g474", "{told}");
    assert_eq!(told["status"]["missed"], 0);
    assert_eq!(told["status"]["reset"], "PowerOn");
    assert!(
        told["status"]["isr_cycles_worst"]
            .as_u64()
            .is_some_and(|cycles| cycles > 0)
    );
    let text = on_chip(folder.path(), "status").quiet();
    for wanted in [
        "converters passed, memory passed",
        "as wanted, slow clock",
        "none in force",
    ] {
        assert!(text.contains(wanted), "{wanted}: {text}");
    }
}

#[test]
fn monitor_shows_poses_and_log_the_start() {
    let folder = tempfile::tempdir().unwrap();
    let told = on_chip(folder.path(), "monitor --seconds 0.1 --json").quiet();
    let lines: Vec<_> = told.lines().map(json).collect();
    assert!(lines.len() > 1, "{told}");
    let told = on_chip(folder.path(), "log --seconds 0.05 --json").quiet();
    let lines: Vec<_> = told.lines().map(json).collect();
    for wanted in ["start, cause PowerOn", "converters ready"] {
        assert!(lines.iter().any(|line| line["message"] == wanted), "{told}");
    }
}

#[test]
fn record_writes_every_sample() {
    let folder = tempfile::tempdir().unwrap();
    let told = on_chip(folder.path(), "record taken --seconds 0.05 --json").json();
    let samples = told["samples"].as_u64().expect("their number");
    assert!(samples >= 1000, "{told}");
    let table = std::fs::read_to_string(folder.path().join("taken/samples.csv")).unwrap();
    assert_eq!(table.lines().count() as u64, samples + 1, "{told}");
}

/// What the simulated board has stored is in force on the chip, and the other way round.
#[test]
fn a_calibration_is_committed_to_the_chips_flash_and_outlives_it() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    asked(folder, CALIBRATE).quiet();
    asked(
        folder,
        "--sim-preset ideal --sim-flash a.bin export first.json",
    )
    .quiet();
    on_chip(folder, "--sim-flash a.bin commit").refused(&["already stored in slot 0, number 1"]);
    on_chip(folder, "--sim-flash b.bin commit").refused(&["no calibration is in force"]);
    let stored = on_chip(folder, "--sim-flash b.bin import first.json --json").json();
    assert_eq!(stored["stored"]["sequence"], 1, "{stored}");
    let stored = on_chip(folder, "--sim-flash b.bin import first.json --json").json();
    assert_eq!(stored["stored"]["sequence"], 2, "{stored}");
    for board in ["--chip", "--sim"] {
        let words = format!("{board} --sim-preset ideal --sim-flash b.bin status --json");
        let told = asked(folder, &words).json();
        assert_eq!(
            told["status"]["in_force"]["Stored"]["sequence"], 2,
            "{told}"
        );
    }
    on_chip(folder, "--sim-flash b.bin export second.json").quiet();
    let read = |name: &str| std::fs::read(folder.join(name)).unwrap();
    assert_eq!(read("first.json"), read("second.json"));
    // A restart, commits while the board samples, and its own count of cycles.
    let words = "--sim-flash b.bin acceptance --seconds 0.1 --commits 1 --restarts 1";
    let told = on_chip(folder, words).quiet();
    assert!(
        told.contains("commits      passed: 1 of 1 stored"),
        "{told}"
    );
    assert!(told.contains("interrupt    passed: "), "{told}");
}

#[test]
fn an_image_that_is_not_there_is_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let ran = std::process::Command::new(env!("CARGO_BIN_EXE_courier"))
        .args(["--chip", "status"])
        .current_dir(folder.path())
        .env("COURIER_CHIP_IMAGE", "nothing.elf")
        .output()
        .unwrap();
    let told = String::from_utf8_lossy(&ran.stderr);
    assert_eq!(
        (ran.status.code(), told.trim_end().lines().count()),
        (Some(2), 1),
        "{told}"
    );
    assert!(told.contains("--chip: found no nothing.elf"), "{told}");
}
