//! The commands that talk to a board, against the simulated one.

mod common;

use common::{CALIBRATE, asked, json_in};
use serde_json::Value;
use std::path::Path;

fn status(folder: &Path, flash: &str) -> Value {
    asked(folder, &format!("--sim-flash {flash} status --json")).json()
}

/// Calibrates the board in `a.bin` and exports what it found to `first.json`.
fn calibrated(folder: &Path) {
    let first = asked(folder, &format!("{CALIBRATE} --json")).json();
    let stored = &first["ending"]["Accepted"]["stored"];
    assert_eq!(stored["sequence"], 1, "{first}");
    asked(folder, "--sim-flash a.bin export first.json").quiet();
}

/// A calibration outlives the command that made it, goes into a file and onto another board, and back again.
#[test]
fn a_calibration_is_stored_exported_imported_and_rolled_back() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    calibrated(folder);
    let in_force = |flash: &str| status(folder, flash)["status"]["in_force"]["Stored"].clone();
    assert_eq!(in_force("a.bin")["sequence"], 1);
    asked(folder, "--sim-flash a.bin export first.json").refused(&["first.json", "--force"]);
    asked(folder, "--sim-flash a.bin export first.json --force").quiet();
    asked(folder, "--sim-flash a.bin rollback").refused(&["no older valid calibration"]);
    asked(folder, "--sim-flash a.bin commit").refused(&["already stored in slot 0, number 1"]);

    asked(folder, "--sim-flash b.bin import first.json").quiet();
    assert_eq!(in_force("b.bin")["sequence"], 1);
    let exported = asked(folder, "--sim-flash b.bin export second.json --json").json();
    assert_eq!(exported["written"], "second.json");
    let read = |name: &str| std::fs::read(folder.join(name)).unwrap();
    assert_eq!(read("first.json"), read("second.json"));

    let imported = asked(folder, "--sim-flash b.bin import first.json --json").json();
    assert_eq!(imported["stored"]["sequence"], 2);
    let slots = asked(folder, "--sim-flash b.bin slots --json").json();
    let states = (&slots[0]["state"], &slots[1]["state"]);
    assert_eq!(states, (&"Older".into(), &"InForce".into()));
    let rolled_back = asked(folder, "--sim-flash b.bin rollback").quiet();
    assert!(rolled_back.contains("slot 0, number 1"), "{rolled_back}");
    assert_eq!(in_force("b.bin")["slot"], 0);
}

/// The board's number is text in all that people read; files of earlier versions have its bytes.
#[test]
fn a_boards_number_is_text() {
    const NUMBER: &str = "73696d756c617465642d3031";
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    calibrated(folder);
    assert_eq!(status(folder, "a.bin")["board"]["device"], NUMBER);
    let mut file = json_in(folder.join("first.json"));
    assert_eq!(file["calibration"]["device"], NUMBER);
    let mut import = |name: &str, device: Value| {
        file["calibration"]["device"] = device;
        std::fs::write(folder.join(name), file.to_string()).unwrap();
        asked(folder, &format!("--sim-flash b.bin import {name}"))
    };
    import("earlier.json", b"simulated-01"[..].into()).quiet();
    let wanted = ["wrong.json", "24 hexadecimal digits"];
    import("wrong.json", "board 1".into()).refused(&wanted);
    import("wrong.json", Value::Array(vec![1.into(); 11])).refused(&wanted);
    import("other.json", "00".repeat(12).into()).refused(&["other.json", "--other-device"]);
}

#[test]
fn an_uncalibrated_board_says_so() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let text = asked(folder, "status").quiet();
    for word in ["simulated", "UNCALIBRATED", "none in force"] {
        assert!(text.contains(word), "{text}");
    }
    assert!(asked(folder, "slots").quiet().contains("refused: empty"));
    assert!(asked(folder, "reset").quiet().contains("restarting"));
    let reset = asked(folder, "reset --json").json();
    assert_eq!(reset["restarting"], true);
    asked(folder, "export none.json").refused(&["no calibration is in force"]);
    asked(folder, "commit").refused(&["no calibration is in force"]);
    asked(folder, "abort").refused(&["nothing is under way"]);
    assert_eq!(std::fs::read_dir(folder).unwrap().count(), 0);
}

/// Each wrong command, and what its one line must hold.
const WRONG: [(&str, &str); 20] = [
    ("--sim --emulated status", "cannot be used with"),
    ("--sim replay x", "needs no board"),
    (
        "--probe any --sim-seed 3 status",
        "wanted a simulated board",
    ),
    ("--probe any status", "--probe"),
    ("--sim-seed -1 status", "'-1' for '--sim-seed"),
    (
        "--sim-effect lag=1 status",
        "lag: no effect, wanted one of lateral_dependence",
    ),
    (
        "--sim-effect velocity_lag=-1 status",
        "-1: wanted a size above 0",
    ),
    ("--sim-flash short.bin status", "found 1 bytes, wanted"),
    (
        "--sim-flash no/such.bin record x",
        "--sim-flash: no/such.bin: found no folder for it",
    ),
    (
        "--sim-flash no/such.bin import text.json",
        "text.json: wanted JSON",
    ),
    ("import none.json", "none.json"),
    ("import .", ".: a readable calibration was wanted"),
    ("import other.json", "found 99, wanted 2"),
    ("import half.json", "half.json: wanted a calibration"),
    (
        "calibrate --poses 3",
        "number of poses is 3, wanted 40 to 20000",
    ),
    ("calibrate --travel-mm nan", "travel in metres is NaN"),
    ("calibrate --turn-deg 90", "angle in radians is 1.57"),
    (
        "calibrate --target-um -1",
        "deviation to reach in metres is -0.000001",
    ),
    ("monitor --rate-hz nan", "--rate-hz: found NaN"),
    (
        "monitor --seconds -1",
        "--seconds: found -1, wanted above 0",
    ),
];

#[test]
fn wrong_boards_orders_and_files() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let other = "{\"courier_calibration\": 99, \"calibration\": {}}";
    let half = "{\"courier_calibration\": 2, \"calibration\": {\"device\": 3}}";
    let files = [
        ("short.bin", "x"),
        ("text.json", "hello"),
        ("other.json", other),
        ("half.json", half),
    ];
    for (name, text) in files {
        std::fs::write(folder.join(name), text).unwrap();
    }
    for (words, wanted) in WRONG {
        asked(folder, words).refused(&[wanted]);
    }
    assert_eq!(std::fs::read_dir(folder).unwrap().count(), files.len());
}

/// Both sensors under the simulated beacon; every step says what it did by itself.
#[test]
fn both_sensors_calibrate_together() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let words = "--sim-preset ideal calibrate --joint --poses 200 --held-out 40 --json";
    let progress = asked(folder, words).json();
    let stored = &progress["ending"]["Accepted"]["stored"];
    assert_eq!(stored["sequence"], 1, "{progress}");
    assert_eq!(progress["method"], "Joint");
    for step in 0..2 {
        assert_eq!(progress["steps"][step]["accepted"], true, "{progress}");
    }
    asked(folder, "calibrate --joint --from 1,2").refused(&["three numbers"]);
    asked(folder, "calibrate --joint --poses 5000")
        .refused(&["number of poses is 5000, wanted 50 to 1000"]);
}
