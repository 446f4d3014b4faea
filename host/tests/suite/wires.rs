//! Wires, units and stated lengths that the readings contradict: every command that uses readings says what would be right.

use crate::common::asked;
use diagnosis::Model;
use hal_sim::coordination::origin_under;
use hal_sim::courier::Courier;
use hal_sim::presets;
use hal_sim::record::record;
use hal_sim::trajectory::{OpenLoop, Plan};
use recording::{Existing, Recording};
use std::path::Path;

const SWAPPED: &str = "segment 1 follows y, segment 2 follows x";
const LEVER: &str = "lever_x_m has the wrong sign: 90";

/// Still poses under the beacon of a courier without flaws.
fn right() -> Recording {
    let spec = presets::ideal(11);
    let (geometry, place) = (spec.nominal, spec.places.beacon);
    let origin_m = origin_under(&spec.geometry, place);
    let mut courier = Courier::new(spec, 11).unwrap();
    let plan = Plan::new(place, geometry, OpenLoop::COURIER, 11).beacon(400, origin_m, 0.02);
    record(&mut courier, &plan, false)
}

fn write(recording: &Recording, folder: &Path, name: &str) {
    recording
        .write(folder.join(name), Existing::Refuse)
        .unwrap();
}

#[test]
fn exchanged_segments_are_refused_wherever_a_recording_is_read() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let swapped = right().with_rows(|_, row| {
        row.quadrature_counts.swap(0, 1);
        row.teeth.swap(0, 1);
        true
    });
    write(&swapped, folder, "swapped");
    let model = Model {
        schema: 1,
        ..Model::default()
    };
    let text = serde_json::to_string(&model).unwrap();
    std::fs::write(folder.join("model.json"), text).unwrap();
    for words in [
        "replay swapped",
        "map swapped --out teeth.json",
        "check model.json swapped",
    ] {
        asked(folder, words).refused(&["swapped: found that", SWAPPED, "wanted"]);
    }
    assert!(!folder.join("teeth.json").exists());
    let answer = asked(folder, "diagnose swapped --json").json();
    assert_eq!(answer["verdict"], "insufficient_data");
    assert!(answer["notes"][0].as_str().unwrap().contains(SWAPPED));
}

/// A lever arm is nothing to a replay, which tells it and goes on; a map is made of it.
#[test]
fn what_a_command_does_not_use_is_only_told() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let mut recording = right();
    let coordination = recording.meta.coordination.as_mut().unwrap();
    coordination.lever_x_m *= -1.0;
    write(&recording, folder, "lever");
    let ran = asked(folder, "replay lever");
    assert!(ran.code == 0 && ran.err.contains(LEVER), "{}", ran.err);
    asked(folder, "map lever").refused(&["lever: found that", LEVER]);
}

fn nothing_is_stored(folder: &Path, board: &str) {
    let slots = asked(folder, &format!("{board} slots --json")).json();
    let empty = |slot: &serde_json::Value| slot["state"]["Refused"] == "Empty";
    assert!(slots.as_array().unwrap().iter().all(empty), "{slots}");
}

/// The board sees that its angles disagree, and the command why.
#[test]
fn a_refused_calibration_of_exchanged_segments_names_them() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let board = "--sim-preset ideal --sim-fault segments-exchanged --sim-flash b.bin";
    let ran = asked(
        folder,
        &format!("{board} calibrate --poses 150 --held-out 40"),
    );
    assert_eq!(ran.code, 1, "{}", ran.err);
    assert!(
        ran.out.contains("refused: ") && ran.err.contains(SWAPPED),
        "{}",
        ran.err
    );
    nothing_is_stored(folder, board);
}

/// Where x and y are exchanged the angles agree, and the board would take the result: its readings under the beacon end the session.
#[test]
fn a_calibration_of_exchanged_axes_is_ended() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let board = "--sim-preset ideal --sim-fault axes-exchanged --sim-flash b.bin";
    let wanted = [
        "the board's readings: found that",
        "segments 1 and 3 follow y, segments 2 and 4 follow x",
        "the session was ended, the calibration in force before stays",
    ];
    asked(
        folder,
        &format!("{board} calibrate --poses 300 --held-out 40"),
    )
    .refused(&wanted);
    nothing_is_stored(folder, board);
}

/// Readings are kept as they came, since a column is easily named anew; what is wrong with them is told.
#[test]
fn a_recording_of_exchanged_segments_is_kept_and_told() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let board = "--sim-preset ideal --sim-fault segments-exchanged";
    let motion = "record flight --seconds 0.5 --go-to 5,-3,1 --speed-mm-s 20 --decimation 10";
    let ran = asked(folder, &format!("{board} {motion}"));
    assert!(ran.code == 0 && ran.err.contains(SWAPPED), "{}", ran.err);
    assert!(Recording::read(folder.join("flight")).is_ok());
}
