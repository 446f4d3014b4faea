//! The commands that talk to a board, against the simulated one.

use crate::common::{CALIBRATE, asked, json_in};
use serde_json::Value;
use std::path::Path;

fn status(folder: &Path, flash: &str) -> Value {
    asked(
        folder,
        &format!("--sim-preset ideal --sim-flash {flash} status --json"),
    )
    .json()
}

/// Calibrates the board in `a.bin` and exports what it found to `first.json`.
fn calibrated(folder: &Path) {
    let first = asked(folder, &format!("{CALIBRATE} --json")).json();
    let stored = &first["ending"]["Accepted"]["stored"];
    assert_eq!(stored["sequence"], 1, "{first}");
    asked(
        folder,
        "--sim-preset ideal --sim-flash a.bin export first.json",
    )
    .quiet();
}

/// A calibration outlives the command that made it, goes into a file and onto another board, and back again.
#[test]
fn a_calibration_is_stored_exported_imported_and_rolled_back() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    calibrated(folder);
    let in_force = |flash: &str| status(folder, flash)["status"]["in_force"]["Stored"].clone();
    assert_eq!(in_force("a.bin")["sequence"], 1);
    asked(
        folder,
        "--sim-preset ideal --sim-flash a.bin export first.json",
    )
    .refused(&["first.json", "--force"]);
    let ideal = |words: &str| asked(folder, &format!("--sim-preset ideal --sim-flash {words}"));
    ideal("a.bin export first.json --force").quiet();
    ideal("a.bin rollback").refused(&["no older valid calibration"]);
    ideal("a.bin commit").refused(&["already stored in slot 0, number 1"]);

    ideal("b.bin import first.json").quiet();
    assert_eq!(in_force("b.bin")["sequence"], 1);
    let exported = ideal("b.bin export second.json --json").json();
    assert_eq!(exported["written"], "second.json");
    let read = |name: &str| std::fs::read(folder.join(name)).unwrap();
    assert_eq!(read("first.json"), read("second.json"));

    let imported = ideal("b.bin import first.json --json").json();
    assert_eq!(imported["stored"]["sequence"], 2);
    let slots = ideal("b.bin slots --json").json();
    let states = (&slots[0]["state"], &slots[1]["state"]);
    assert_eq!(states, (&"Older".into(), &"InForce".into()));
    let rolled_back = ideal("b.bin rollback").quiet();
    assert!(rolled_back.contains("slot 0, number 1"), "{rolled_back}");
    assert_eq!(in_force("b.bin")["slot"], 0);
}

/// The board's number is text in all that people read; files of earlier versions have its bytes.
#[test]
fn a_boards_number_is_text() {
    const NUMBER: &str = "696465616c2d303030303031"; // ideal-000001
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    calibrated(folder);
    assert_eq!(status(folder, "a.bin")["board"]["device"], NUMBER);
    let mut file = json_in(folder.join("first.json"));
    assert_eq!(file["calibration"]["device"], NUMBER);
    let mut import = |name: &str, device: Value| {
        file["calibration"]["device"] = device;
        std::fs::write(folder.join(name), file.to_string()).unwrap();
        asked(
            folder,
            &format!("--sim-preset ideal --sim-flash b.bin import {name}"),
        )
    };
    import("earlier.json", b"ideal-000001"[..].into()).quiet();
    let wanted = ["wrong.json", "24 hexadecimal digits"];
    import("wrong.json", "board 1".into()).refused(&wanted);
    import("wrong.json", Value::Array(vec![1.into(); 11])).refused(&wanted);
    import("other.json", "00".repeat(12).into()).refused(&["other.json", "--other-device"]);
    // Where a number is text, people see that; another seed is another board.
    asked(
        folder,
        "--sim-preset ideal --sim-seed 2 import earlier.json",
    )
    .refused(&["found device ideal-000001, wanted ideal-000002"]);
    let text = asked(folder, "--sim-flash a.bin status").quiet();
    for word in [
        "paper-000001",
        "is of another board, ideal-000001",
        "--other-device",
    ] {
        assert!(text.contains(word), "{text}");
    }
}

/// What another board stored can be taken over by order, and is this board's from then on.
#[test]
fn a_calibration_of_another_board_is_taken_over_by_order() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    calibrated(folder);
    asked(folder, "--sim-flash a.bin export --slot 0 a.json").quiet();
    asked(folder, "--sim-flash a.bin import a.json").refused(&["ideal-000001", "--other-device"]);
    asked(folder, "--sim-flash a.bin import a.json --other-device").quiet();
    let told = asked(folder, "--sim-flash a.bin status --json").json();
    assert_eq!(
        told["status"]["in_force"]["Stored"]["sequence"], 2,
        "{told}"
    );
    assert_eq!(told["status"]["boot"], Value::Null, "{told}");
    let slots = asked(folder, "--sim-flash a.bin slots").quiet();
    assert!(slots.contains("of another board, ideal-000001"), "{slots}");
}

#[test]
fn an_uncalibrated_board_says_so() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let text = asked(folder, "status").quiet();
    for word in [
        "simulated",
        "UNCALIBRATED",
        "none in force",
        "courier calibrate",
    ] {
        assert!(text.contains(word), "{text}");
    }
    assert!(asked(folder, "slots").quiet().contains("empty"));
    assert!(asked(folder, "reset").quiet().contains("restarting"));
    let reset = asked(folder, "reset --json").json();
    assert_eq!(reset["restarting"], true);
    asked(folder, "export none.json").refused(&["no calibration is in force"]);
    asked(folder, "commit").refused(&["no calibration is in force"]);
    asked(folder, "abort").refused(&["nothing is under way"]);
    assert_eq!(std::fs::read_dir(folder).unwrap().count(), 0);
}

/// Each wrong command, and what its one line must hold.
const WRONG: [(&str, &str); 27] = [
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
    (
        "--sim-effect velocity_lag:logged=1 status",
        "follows nothing that is logged, wanted velocity_lag=1",
    ),
    (
        "--sim-effect stray_field:drive=1 status",
        "drive: wanted logged behind the colon",
    ),
    (
        "--sim-age wave:2=1@0 status",
        "wave:2=1@0: wanted wave:SEGMENT:ORDER=UM",
    ),
    (
        "--sim-age weak-magnets:5=10@0 status",
        "5: no segment, wanted 1 to 4",
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
        "number of poses is 3, wanted 49 to 20000",
    ),
    ("calibrate --travel-mm nan", "travel in metres is NaN"),
    (
        "calibrate --travel-mm 1",
        "travel in metres is 0.001, wanted 0.001016 to",
    ),
    (
        "calibrate --joint --travel-mm 200",
        "travel in metres is 0.2, wanted 0.001016 to 0.1",
    ),
    ("calibrate --poses 48", "number of poses is 48, wanted 49"),
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

/// Impossible numbers are refused before the board is asked; another geometry is taken only where that is said.
#[test]
fn a_calibration_of_another_sensor_is_refused() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    calibrated(folder);
    let file = json_in(folder.join("first.json"));
    let import = |place: &str, number: f64, options: &str| {
        let mut file = file.clone();
        *file.pointer_mut(place).unwrap() = number.into();
        std::fs::write(folder.join("bad.json"), file.to_string()).unwrap();
        asked(
            folder,
            &format!("--sim-preset ideal --sim-flash b.bin import bad.json {options}"),
        )
    };
    const PITCH: &str = "/calibration/geometry/pitch_m";
    import("/calibration/temperature_c", -400.0, "")
        .refused(&["bad.json: temperature_c is -400, wanted -65 to 150"]);
    let coefficient = import("/calibration/model/coefficients/2/1/0", 1.0, "");
    coefficient.refused(&["segment 2's coefficients add up to 1", "half a pitch"]);
    assert_eq!(
        coefficient.err.matches("add up").count(),
        1,
        "{}",
        coefficient.err
    );
    import(PITCH, 2.032e-3, "--other-geometry").refused(&["pitch_m is 0.002032, wanted 0.000909"]);
    import(PITCH, 1.02616e-3, "").refused(&["pitch_m", "0.00102616", "--other-geometry"]);
    assert!(!folder.join("b.bin").exists());
    import(PITCH, 1.02616e-3, "--other-geometry").quiet();
    assert_eq!(
        status(folder, "b.bin")["status"]["in_force"]["Stored"]["sequence"],
        1
    );
}

/// A host that does not check gets no further: the board refuses the same.
#[test]
fn the_board_refuses_what_the_host_would() {
    use courier::board::{Link, SimWire};
    use courier_sensor::calibration::record::Calibration;
    use courier_sensor::geometry::Geometry;
    use courier_sensor::link::message::Action;
    use hal_sim::board::SharedFlash;

    let wire = SimWire::start(hal_sim::presets::ideal(1), 1, SharedFlash::erased(1)).unwrap();
    let mut link = Link::connect(Box::new(wire)).unwrap();
    let sound = Calibration::identity(Geometry::PAPER);
    type Change = fn(&mut Calibration);
    let changes: [(&str, Change); 7] = [
        ("pitch", |c| c.geometry.pitch_m *= 2.0),
        ("span", |c| c.geometry.span_m *= 10.0),
        ("amplitude", |c| c.amplitude_counts[1] = -1.0),
        ("temperature", |c| c.temperature_c = -400.0),
        ("residual", |c| c.quality.residual_after_m = f32::NAN),
        ("gain", |c| c.pairs[3].gain = -1.0),
        ("constant", |c| c.model.constants_m[0] = 1.0),
    ];
    for (name, change) in changes {
        let mut bad = sound.clone();
        change(&mut bad);
        let error = link.ask(Action::take_over(bad)).unwrap_err().to_string();
        assert!(error.contains("cannot be used"), "{name}: {error}");
    }
    link.ask(Action::take_over(sound)).unwrap();
}

/// A channel that is cut off below the converter's end is told as that, in words.
#[test]
fn a_clipped_channel_is_told_as_clipped() {
    let temporary = tempfile::tempdir().unwrap();
    let words = "--sim-effect adc_clipping=20 calibrate --poses 60 --held-out 20";
    let ran = asked(temporary.path(), words);
    assert_eq!(ran.code, 1, "{}", ran.err);
    assert!(
        ran.out.contains("clipped or stuck") && !ran.out.contains("Status("),
        "{}",
        ran.out
    );
    assert!(
        !ran.out.contains("inf") && !ran.out.contains("held-out"),
        "{}",
        ran.out
    );
}

/// Magnets that have lost half of their strength give half of the signal, beside the offset that stays.
#[test]
fn a_simulated_courier_ages_as_it_is_told() {
    let temporary = tempfile::tempdir().unwrap();
    let ran = asked(
        temporary.path(),
        "--sim-preset ideal --sim-age weak-magnets:2=50@0 status --json",
    );
    let answer: serde_json::Value = serde_json::from_str(&ran.out).unwrap();
    let counts = |segment: usize| {
        answer["status"]["amplitude_counts"][segment]
            .as_f64()
            .unwrap()
    };
    let share = counts(1) / counts(0);
    // Half, and at most the offset's 6 % either way.
    assert!((share - 0.5).abs() < 0.07, "{share}");
}

/// However long the way between two poses is, there is time for it.
#[test]
fn a_long_way_has_time_to_settle() {
    let temporary = tempfile::tempdir().unwrap();
    let words =
        "--sim-preset ideal calibrate --travel-mm 400 --poses 49 --held-out 8 --plan optimal";
    let ran = asked(temporary.path(), words);
    assert!(!ran.out.contains("not settled"), "{}{}", ran.out, ran.err);
}

/// What the emulated board lacks is told in one line, and nothing is installed.
#[cfg(unix)]
#[test]
fn an_emulated_board_that_is_not_set_up_is_told_in_one_line() {
    use std::os::unix::fs::PermissionsExt;
    let temporary = tempfile::tempdir().unwrap();
    let cargo = temporary.path().join("cargo");
    // What `cargo xtask images` does where something is missing.
    let script = "#!/bin/sh\necho 'xtask images: found no qemu-system-arm, wanted it: `cargo xtask setup` installs it' >&2\nexit 2\n";
    std::fs::write(&cargo, script).unwrap();
    std::fs::set_permissions(&cargo, PermissionsExt::from_mode(0o755)).unwrap();
    let ran = std::process::Command::new(env!("CARGO_BIN_EXE_courier"))
        .args(["--emulated", "status"])
        .env("CARGO", &cargo)
        .env_remove("COURIER_EMULATED_FIRMWARE")
        .output()
        .unwrap();
    let told = String::from_utf8(ran.stderr).unwrap();
    assert_eq!(ran.status.code(), Some(2), "{told}");
    assert_eq!(
        told,
        "courier: --emulated: found no qemu-system-arm, wanted it: `cargo xtask setup` installs it\n"
    );
}
