//! Lines of text: tview and the calibration of moteus, monitors of SimpleFOC.

use super::{MM, close, converted, log_of, order, read_turns, shaft_turns};
use convert::{Beside, convert, read_with};
use recording::Column;
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

#[test]
fn tview_of_moteus_as_lines_and_as_a_table() {
    for name in ["tview.jsonl", "tview_1_servo_stats.csv"] {
        let columns: &[&str] = match name.ends_with("csv") {
            true => &["p1_m=position", "ref_x_m=abs_position"],
            false => &["p1_m=1.servo_stats.position", "ref_x_m=abs_position"],
        };
        let made = converted(name, columns, None);
        let first_s = made.recording.samples.t_s()[0];
        // Times of today in seconds have a resolution of 0.24 µs.
        let off = 3.0 * 2.4e-7 * MM;
        close(
            &made,
            Column::Position(0),
            |t_s| read_turns(t_s - first_s) * MM,
            off,
        );
        close(
            &made,
            Column::Reference(0),
            |t_s| shaft_turns(t_s - first_s) * MM,
            off,
        );
    }
    let log = log_of("tview.jsonl", &Beside::default()).unwrap();
    let names: Vec<&str> = log
        .columns
        .iter()
        .map(|column| column.name.as_str())
        .collect();
    assert!(
        [
            "time",
            "1.servo_stats.abs_position",
            "1.motor_position.sources[0].raw",
            "1.motor_position.position"
        ]
        .iter()
        .all(|name| names.contains(name)),
        "{names:?}"
    );
}

#[test]
fn monitors_of_simplefoc() {
    // Its angles have four digits, radians.
    let off = 0.5e-4 / TAU * MM * 1.001;
    for (name, rate_hz) in [
        ("simplefoc.log", Some(200.0)),
        ("simplefoc-all.log", Some(200.0)),
        ("simplefoc-arduino.log", None),
    ] {
        let made = converted(name, &["p1_m=angle", "cmd_x_m=target:rad"], rate_hz);
        assert!((made.told.rate_hz - 200.0).abs() < 1e-6, "{name}");
        close(&made, Column::Position(0), |t_s| read_turns(t_s) * MM, off);
        close(
            &made,
            Column::Commanded(0),
            |t_s| shaft_turns(t_s) * MM,
            off,
        );
    }
    let log = log_of("simplefoc.log", &Beside::default()).unwrap();
    let error = convert(
        Path::new("simplefoc.log"),
        &log,
        &order(&["p1_m=angle"], None),
    )
    .unwrap_err()
    .to_string();
    assert!(
        error.contains("no column of time, wanted --rate-hz HZ, calls of monitor() a second"),
        "{error}"
    );
}

/// What the library prints beside the monitor's lines is none of them, whatever its form: here the commander's answer is one number, as is
/// each line of the monitor.
#[test]
fn answers_of_simplefocs_commander_are_no_values() {
    let log = log_of("simplefoc-angle.log", &Beside::default()).unwrap();
    let angle = &log.columns[0].numbers;
    assert_eq!((log.rows(), log.columns.len(), angle[0]), (60, 1, -5.3927));
    // The shaft goes one way, at 50 lines a second, no faster than 0.4 V drive a motor of 0.04 V s/rad.
    let steps = || angle.windows(2).map(|pair| pair[1] - pair[0]);
    assert!(steps().all(|step| step > 0.0 && step < 0.2), "{angle:?}");
    let told = |wanted: &str| log.notes.iter().any(|note| note.contains(wanted));
    assert!(
        told("1 lines among the values were left aside, as line 44, `0.400`"),
        "{:?}",
        log.notes
    );
    assert!(
        told("(CCW): the angle is minus the sensor's"),
        "{:?}",
        log.notes
    );
}

/// A monitor with letters, semicolons, six digits and currents; and an open loop, which reads no sensor.
#[test]
fn simplefocs_monitor_as_it_can_be_set() {
    let log = log_of("simplefoc-currents.log", &Beside::default()).unwrap();
    let first = |log: &convert::Log| {
        log.columns
            .iter()
            .map(|column| column.numbers[0])
            .collect::<Vec<_>>()
    };
    assert_eq!(
        first(&log),
        [0.25, 53.294_682, -0.799_517, 0.041_343, 0.890_092]
    );
    assert_eq!(log.rows(), 60);
    assert_eq!(log.columns[4].hint.as_deref(), Some("p1_m=#5:rad"));
    let open = |log: &convert::Log| {
        log.notes
            .iter()
            .any(|note| note.contains("the library's open loop"))
    };
    assert!(!open(&log), "{:?}", log.notes);
    let log = log_of("simplefoc-open.log", &Beside::default()).unwrap();
    assert!(open(&log), "{:?}", log.notes);
    assert_eq!((log.rows(), &first(&log)[..2]), (60, &[6.0, 6.0][..]));
}

#[test]
fn a_calibration_of_moteus() {
    let Some(shared) = recorded_calibration() else {
        return;
    };
    let (text, wanted) = shared;
    let log = read_with(Path::new("cal.log"), text.as_bytes(), &Beside::default()).unwrap();
    assert!(
        log.notes[0].contains("a turn of the encoder is 21 of the phase"),
        "{:?}",
        log.notes
    );
    let columns = [
        "p1_m=encoder:turn",
        "ref_x_m=phase:turn/21",
        "run=direction",
    ];
    let made = convert(Path::new("cal.log"), &log, &order(&columns, Some(100.0)))
        .unwrap()
        .recording
        .samples;
    let run = |row: usize| made.run(row);
    assert_eq!((run(0), run(made.len() - 1)), ("1", "2"));
    // The folder has twelve digits; in which turn its runs begin, of the encoder and of the phase, is the folder's choice.
    for (column, place, turn) in [
        (Column::Position(0), 0, MM),
        (Column::Reference(0), 1, MM / 21.0),
    ] {
        let values = made.column(column);
        for row in 0..values.len() {
            let (found, wanted) = (
                values[row] - values[0],
                wanted[row][place] - wanted[0][place],
            );
            let turns = (found - wanted) / turn;
            assert!(
                (turns - turns.round()).abs() * turn < 2e-12,
                "{column:?}, row {row}: {found} for {wanted}"
            );
        }
    }
}

/// The readings of a motor's calibration among the data outside the project, in moteus' own form, and the places that they stand for.
fn recorded_calibration() -> Option<(String, Vec<[f64; 2]>)> {
    let shared = std::env::var_os("COURIER_SHARED").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared"),
        PathBuf::from,
    );
    let Ok(samples) =
        std::fs::read_to_string(shared.join("data/moteus-calibration-log/samples.csv"))
    else {
        eprintln!(
            "SKIPPED: moteus-calibration-log is not there; COURIER_SHARED names the folder that has data/moteus-calibration-log"
        );
        return None;
    };
    let mut text = String::from("CAL start\n");
    let mut places = Vec::new();
    for line in samples.lines().skip(1) {
        let fields: Vec<&str> = line.split(',').collect();
        let place = |field: usize| fields[field].parse::<f64>().unwrap();
        let steps = |turns: f64| ((turns * 65_536.0).round() as i64).rem_euclid(65_536);
        let direction = if fields[1] == "up" { 1 } else { 2 };
        text += &format!(
            "{direction} {} {}\n",
            steps(place(3) / MM * 21.0),
            steps(place(2) / MM)
        );
        places.push([place(2), place(3)]);
    }
    Some((text + "CAL done\n", places))
}
