//! The commands that talk to a board, against the simulated one.

mod common;

use common::{courier_in, json};
use serde_json::Value;
use std::path::Path;

fn ok(folder: &Path, arguments: &[&str]) -> String {
    courier_in(folder, arguments).quiet()
}

fn refused(folder: &Path, arguments: &[&str], wanted: &str) {
    courier_in(folder, arguments).refused(&[wanted]);
}

fn status(folder: &Path, flash: &str) -> Value {
    courier_in(folder, &["--sim-flash", flash, "status", "--json"]).json()
}

/// A calibration outlives the command that made it, goes into a file and onto another board, and back again.
#[test]
fn a_calibration_is_stored_exported_imported_and_rolled_back() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let calibrate = |seed: &str| {
        let options = [
            "--sim-preset",
            "ideal",
            "--sim-flash",
            "a.bin",
            "calibrate",
            "--plan",
            "optimal",
            "--poses",
            "100",
            "--held-out",
            "40",
        ];
        ok(
            folder,
            &[&options[..], &["--seed", seed, "--json"]].concat(),
        )
    };
    let first = json(&calibrate("1"));
    assert_eq!(
        first["ending"]["Accepted"]["stored"]["sequence"], 1,
        "{first}"
    );
    assert_eq!(
        status(folder, "a.bin")["status"]["in_force"]["Stored"]["sequence"],
        1
    );

    // A second session starts from the first and can only be accepted if its own test says that it is better.
    ok(folder, &["--sim-flash", "a.bin", "export", "first.json"]);
    refused(
        folder,
        &["--sim-flash", "a.bin", "export", "first.json"],
        "--force",
    );
    refused(
        folder,
        &["--sim-flash", "a.bin", "rollback"],
        "no older valid calibration",
    );
    refused(
        folder,
        &["--sim-flash", "a.bin", "commit"],
        "already stored in slot 0, number 1",
    );

    ok(folder, &["--sim-flash", "b.bin", "import", "first.json"]);
    assert_eq!(
        status(folder, "b.bin")["status"]["in_force"]["Stored"]["sequence"],
        1
    );
    let export = ["--sim-flash", "b.bin", "export", "second.json", "--json"];
    let exported = courier_in(folder, &export).json();
    assert_eq!(exported["written"], "second.json");
    let read = |name: &str| std::fs::read(folder.join(name)).unwrap();
    assert_eq!(read("first.json"), read("second.json"));

    // The board's number is text in every file that is written; earlier files had its bytes.
    let number = "73696d756c617465642d3031";
    assert_eq!(status(folder, "b.bin")["board"]["device"], number);
    let mut earlier = common::json_in(folder.join("first.json"));
    assert_eq!(earlier["calibration"]["device"], number);
    earlier["calibration"]["device"] = serde_json::json!(*b"simulated-01");
    std::fs::write(folder.join("earlier.json"), earlier.to_string()).unwrap();
    ok(folder, &["--sim-flash", "c.bin", "import", "earlier.json"]);
    earlier["calibration"]["device"] = "board 1".into();
    std::fs::write(folder.join("wrong.json"), earlier.to_string()).unwrap();
    refused(
        folder,
        &["--sim-flash", "c.bin", "import", "wrong.json"],
        "24 hexadecimal digits",
    );

    let import = ["--sim-flash", "b.bin", "import", "first.json", "--json"];
    let imported = courier_in(folder, &import).json();
    assert_eq!(imported["stored"]["sequence"], 2);
    let slots = courier_in(folder, &["--sim-flash", "b.bin", "slots", "--json"]).json();
    assert_eq!(
        (&slots[0]["state"], &slots[1]["state"]),
        (&"Older".into(), &"InForce".into())
    );
    assert!(ok(folder, &["--sim-flash", "b.bin", "rollback"]).contains("slot 0, number 1"));
    assert_eq!(
        status(folder, "b.bin")["status"]["in_force"]["Stored"]["slot"],
        0
    );
}

#[test]
fn an_uncalibrated_board_says_so() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let text = ok(folder, &["status"]);
    assert!(
        text.contains("simulated")
            && text.contains("UNCALIBRATED")
            && text.contains("none in force"),
        "{text}"
    );
    assert!(ok(folder, &["slots"]).contains("refused: empty"));
    assert!(ok(folder, &["reset"]).contains("restarting"));
    let reset = courier_in(folder, &["reset", "--json"]).json();
    assert_eq!(reset["restarting"], true);
    refused(
        folder,
        &["export", "none.json"],
        "no calibration is in force",
    );
    refused(folder, &["commit"], "no calibration is in force");
    refused(folder, &["abort"], "nothing is under way");
    assert_eq!(std::fs::read_dir(folder).unwrap().count(), 0);
}

#[test]
fn wrong_boards_orders_and_files() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    std::fs::write(folder.join("short.bin"), "x").unwrap();
    std::fs::write(folder.join("text.json"), "hello").unwrap();
    std::fs::write(
        folder.join("other.json"),
        "{\"courier_calibration\": 99, \"calibration\": {}}",
    )
    .unwrap();
    std::fs::write(
        folder.join("half.json"),
        "{\"courier_calibration\": 2, \"calibration\": {\"device\": 3}}",
    )
    .unwrap();
    let cases: [(&[&str], &str); 12] = [
        (&["--sim", "--emulated", "status"], "cannot be used with"),
        (&["--sim", "replay", "x"], "needs no board"),
        (
            &["--probe", "any", "--sim-seed", "3", "status"],
            "wanted a simulated board",
        ),
        (&["--probe", "any", "status"], "--probe"),
        (
            &["--sim-flash", "short.bin", "status"],
            "found 1 bytes, wanted",
        ),
        (
            &["--sim-flash", "no/such/folder.bin", "import", "text.json"],
            "text.json: wanted JSON",
        ),
        (&["import", "none.json"], "none.json"),
        (&["import", "other.json"], "found 99, wanted 2"),
        (&["import", "half.json"], "half.json: wanted a calibration"),
        (
            &["calibrate", "--poses", "3"],
            "Poses is 3, wanted 40 to 20000",
        ),
        (&["calibrate", "--travel-mm", "nan"], "TravelM is NaN"),
        (&["calibrate", "--turn-deg", "90"], "TurnRad"),
    ];
    let before = std::fs::read_dir(folder).unwrap().count();
    for (arguments, wanted) in cases {
        refused(folder, arguments, wanted);
    }
    assert_eq!(std::fs::read_dir(folder).unwrap().count(), before);
}

/// A recording of a flight: every sample is there, its noise is what the simulated board has, and the reader takes it.
#[test]
fn a_board_is_watched_and_recorded() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let recorded = ok(
        folder,
        &[
            "--sim-preset",
            "ideal",
            "record",
            "flight",
            "--seconds",
            "0.5",
            "--go-to",
            "5,5,0",
            "--speed-mm-s",
            "20",
            "--json",
        ],
    );
    assert_eq!(
        json(&recorded),
        serde_json::json!({"samples": 10_000, "lost": 0})
    );
    let recording = recording::Recording::read(folder.join("flight")).unwrap();
    assert_eq!(
        (recording.samples.len(), recording.warnings.len()),
        (10_000, 0)
    );
    // 20 counts and 20 000 counts are what `hal-sim` says of its board.
    let electronics = recording.meta.electronics;
    assert!(
        (electronics.quadrature_noise_counts.unwrap() / 20.0 - 1.0).abs() < 0.05,
        "{electronics:?}"
    );
    assert!(
        (electronics.amplitude_counts.unwrap() / 20_000.0 - 1.0).abs() < 0.02,
        "{electronics:?}"
    );
    let output_m = |index: usize| {
        recording
            .samples
            .unmodified_m(1, index, recording.meta.geometry.pitch_m)
            .unwrap()
    };
    assert!(
        (output_m(9_999) - output_m(0) - 5.0e-3).abs() < 1.5e-3,
        "{} -> {}",
        output_m(0),
        output_m(9_999)
    );
    let steps = (1..10_000).map(|index| (output_m(index) - output_m(index - 1)).abs());
    assert!(steps.fold(0.0, f64::max) < 5.0e-6, "a tooth was lost");

    let lines = ok(
        folder,
        &[
            "--sim-preset",
            "ideal",
            "monitor",
            "--rate-hz",
            "100",
            "--seconds",
            "0.2",
            "--json",
        ],
    );
    assert!((18..=22).contains(&lines.lines().count()), "{lines}");
    let first = json(lines.lines().next().unwrap());
    assert!(
        first["status"]
            .as_array()
            .unwrap()
            .contains(&"UNCALIBRATED".into()),
        "{first}"
    );

    refused(
        folder,
        &["monitor", "--rate-hz", "nan"],
        "--rate-hz: found NaN",
    );
    refused(folder, &["monitor", "--seconds", "0"], "--seconds");
    refused(
        folder,
        &["record", "x", "--seconds", "0"],
        "--seconds: found 0",
    );
    refused(folder, &["record", "x", "--go-to", "1,2"], "three numbers");
    refused(
        folder,
        &["record", "x", "--go-to", "9000,0,0"],
        "the board refuses",
    );
    let again = ["record", "flight", "--seconds", "0.1"];
    refused(folder, &again, "--force replaces a recording");
    assert_eq!(
        recording::Recording::read(folder.join("flight")).unwrap(),
        recording
    );
    ok(folder, &[&again[..], &["--force"]].concat());
    assert_eq!(
        recording::Recording::read(folder.join("flight"))
            .unwrap()
            .samples
            .len(),
        2_000
    );
    std::fs::write(folder.join("flight/thesis.txt"), "precious").unwrap();
    refused(folder, &[&again[..], &["--force"]].concat(), "thesis.txt");
    assert!(!folder.join("x").exists());
}

/// Both sensors under the simulated beacon; every step says what it did by itself.
#[test]
fn both_sensors_calibrate_together() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let options = [
        "--sim-preset",
        "ideal",
        "calibrate",
        "--joint",
        "--poses",
        "200",
        "--held-out",
        "40",
        "--json",
    ];
    let progress = courier_in(folder, &options).json();
    assert!(
        progress["ending"]["Accepted"]["stored"]["sequence"] == 1,
        "{progress}"
    );
    assert_eq!(progress["method"], "Joint");
    assert!(
        progress["steps"][0]["accepted"].as_bool().unwrap()
            && progress["steps"][1]["accepted"].as_bool().unwrap()
    );
    refused(
        folder,
        &["calibrate", "--joint", "--from", "1,2"],
        "three numbers",
    );
    refused(
        folder,
        &["calibrate", "--joint", "--poses", "5000"],
        "Poses is 5000, wanted 50 to 1000",
    );
}
