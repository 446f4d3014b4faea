//! `courier record` and `courier monitor`, against the simulated board.

use crate::common::{asked, json};
use recording::Recording;

/// A recording of a flight: every sample is there, its noise is what the simulated board has, and the reader takes it.
#[test]
fn a_flight_is_recorded() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let flight = "record flight --seconds 0.5 --go-to 5,5,0 --speed-mm-s 20";
    let recorded = asked(folder, &format!("--sim-preset ideal {flight} --json")).json();
    assert_eq!(recorded, serde_json::json!({"samples": 10_000, "lost": 0}));
    let recording = Recording::read(folder.join("flight")).unwrap();
    let samples = &recording.samples;
    assert_eq!((samples.len(), recording.warnings.len()), (10_000, 0));
    // 20 counts and 20 000 counts are what `hal-sim` says of its board.
    let electronics = recording.meta.electronics;
    let noise = electronics.quadrature_noise_counts.unwrap() / 20.0;
    assert!((noise - 1.0).abs() < 0.02, "{electronics:?}");
    let amplitude = electronics.amplitude_counts.unwrap() / 20_000.0;
    assert!((amplitude - 1.0).abs() < 0.02, "{electronics:?}");
    let pitch_m = recording.meta.geometry.pitch_m;
    let output_m = |index: usize| samples.unmodified_m(1, index, pitch_m).unwrap();
    let (first, last) = (output_m(0), output_m(9_999));
    assert!((last - first - 5.0e-3).abs() < 1.5e-3, "{first} -> {last}");
    let steps = (1..10_000).map(|index| (output_m(index) - output_m(index - 1)).abs());
    assert!(steps.fold(0.0, f64::max) < 5.0e-6, "a tooth was lost");
}

/// What a simulated machine logs stands beside the readings, and only where an effect follows it.
#[test]
fn the_current_of_a_simulated_drive_is_recorded() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let flight = "record flight --seconds 0.3 --go-to 5,0,0 --decimation 20 --force";
    asked(
        folder,
        &format!("--sim-effect stray_field:logged=2 {flight}"),
    )
    .quiet();
    let read = Recording::read(folder.join("flight")).unwrap();
    let [logged] = read.samples.logged() else {
        panic!("one column");
    };
    assert_eq!(logged.name, "aux_motor_a");
    let most = logged
        .values
        .iter()
        .copied()
        .fold(f64::NEG_INFINITY, f64::max);
    let least = logged.values.iter().copied().fold(f64::INFINITY, f64::min);
    assert!(least < 0.6 && most > 1.1 && most < 3.0, "{least} to {most}");
    asked(folder, &format!("--sim-effect stray_field=2 {flight}")).quiet();
    let read = Recording::read(folder.join("flight")).unwrap();
    assert!(read.samples.logged().is_empty());
}

/// The noise of a recording does not depend on how fast the courier goes in it and how few samples are kept. It can be stated instead.
#[test]
fn the_noise_is_the_boards_whatever_is_recorded() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let noise = |options: &str| {
        let motion = "record r --force --seconds 0.3 --go-to 40,5,0";
        asked(folder, &format!("{motion} {options}")).quiet();
        let electronics = Recording::read(folder.join("r")).unwrap().meta.electronics;
        electronics.quadrature_noise_counts.unwrap()
    };
    for seed in 1..=2 {
        let fast = format!("--sim-seed {seed} --speed-mm-s 200 --decimation 20");
        let found = noise(&fast) / 20.0;
        assert!((found - 1.0).abs() < 0.02, "seed {seed}: {found}");
    }
    assert_eq!(noise("--noise-counts 12.5,3"), 12.5);
}

/// What was recorded once is replaced when that is asked for; what is no recording never is.
#[test]
fn a_recording_is_not_replaced_unasked() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let read = || Recording::read(folder.join("still")).unwrap();
    asked(folder, "record still --seconds 0.1").quiet();
    let first = read();
    asked(folder, "record still --seconds 0.2").refused(&["still", "--force replaces"]);
    assert_eq!(read(), first);
    asked(folder, "record still --seconds 0.2 --force").quiet();
    assert_eq!(read().samples.len(), 4_000);
    std::fs::write(folder.join("still/thesis.txt"), "precious").unwrap();
    asked(folder, "record still --force").refused(&["thesis.txt"]);
}

#[test]
fn wrong_orders_leave_no_folder() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let cases = [
        ("--seconds 0", "--seconds: found 0"),
        ("--seconds -1", "--seconds: found -1"),
        ("--go-to 1,2", "three numbers"),
        ("--go-to 9000,0,0", "x in metres is 9, wanted -1 to 1"),
        (
            "--go-to 1,1,0 --speed-mm-s -4",
            "speed in m/s is -0.004, wanted 0.001 to 1.5",
        ),
        ("--speed-mm-s 10", "--go-to"),
        ("--noise-counts 20", "two numbers of counts"),
        ("--noise-counts -1,2", "two numbers of counts"),
        ("--decimation 0", "1..=65535"),
    ];
    for (options, wanted) in cases {
        asked(folder, &format!("record x {options}")).refused(&[wanted]);
    }
    assert_eq!(std::fs::read_dir(folder).unwrap().count(), 0);
}

#[test]
fn a_board_is_watched() {
    let temporary = tempfile::tempdir().unwrap();
    let words = "--sim-preset ideal monitor --rate-hz 100 --seconds 0.2 --json";
    let lines = asked(temporary.path(), words).quiet();
    assert!((18..=22).contains(&lines.lines().count()), "{lines}");
    let first = json(lines.lines().next().unwrap());
    let bits = first["status"].as_array().unwrap();
    assert!(bits.contains(&"UNCALIBRATED".into()), "{first}");
}
