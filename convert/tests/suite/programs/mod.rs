//! Files of other programs, made by these programs (`tests/files/README.md`): one motion, a shaft that swings over three turns.

mod bus;
mod lacking;
mod numpy;
mod text;

use convert::{Asked, Beside, Converted, Log, Order, Runs, convert, read_with};
use recording::Column;
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

/// The shaft at row `row` of 200 a second, turns; an encoder reads it by [`read_turns`].
fn shaft_turns(t_s: f64) -> f64 {
    1.5 * (2.0 * t_s).sin()
}

fn read_turns(t_s: f64) -> f64 {
    let turns = shaft_turns(t_s);
    turns + 0.002 * (TAU * turns).sin()
}

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/files")
        .join(name)
}

/// What a file of this folder needs beside itself.
fn beside_of(name: &str) -> Beside {
    if name == "can-utils.log" {
        beside()
    } else {
        Beside::default()
    }
}

fn beside() -> Beside {
    let dbc = file("bus.dbc");
    let text = std::fs::read_to_string(&dbc).unwrap();
    Beside {
        dbc: Some((PathBuf::from("bus.dbc"), text)),
        ..Beside::default()
    }
}

fn log_of(name: &str, beside: &Beside) -> Result<Log, String> {
    let bytes = std::fs::read(file(name)).unwrap();
    read_with(Path::new(name), &bytes, beside).map_err(|error| error.to_string())
}

fn order(columns: &[&str], rate_hz: Option<f64>) -> Order {
    Order {
        columns: columns
            .iter()
            .map(|column| Asked::parse(column).unwrap())
            .collect(),
        runs: Runs::One,
        rate_hz,
        ..Order::default()
    }
}

fn converted(name: &str, columns: &[&str], rate_hz: Option<f64>) -> Converted {
    let order = order(columns, rate_hz);
    let beside = Beside {
        sensor: Beside::sensor_of(&order.columns),
        ..beside_of(name)
    };
    let log = log_of(name, &beside).unwrap();
    convert(Path::new(name), &log, &order).unwrap()
}

/// Each value of a column against what it should be at the time of its row; a turn is written as a millimetre.
fn close(converted: &Converted, column: Column, wanted: impl Fn(f64) -> f64, off: f64) {
    let samples = &converted.recording.samples;
    let values = samples.column(column);
    assert!(
        values.iter().filter(|value| value.is_finite()).count() > samples.len() * 9 / 10,
        "{column:?}"
    );
    for (t_s, value) in samples
        .t_s()
        .iter()
        .zip(values)
        .filter(|(_, value)| value.is_finite())
    {
        let wanted = wanted(*t_s);
        assert!(
            (value - wanted).abs() <= off,
            "{column:?} at {t_s} s: {value} for {wanted}"
        );
    }
}

const MM: f64 = 1.0e-3;

#[test]
fn a_first_command_is_suggested_from_what_the_program_is_known_for() {
    for (name, wanted) in [
        (
            "odrive-cycles.npy",
            "courier convert odrive-cycles.npy OUT --column t_s=timestamps:s --column p1_m=axis0.pos_estimate:turn --column cmd_x_m=axis0.controller.pos_setpoint:turn",
        ),
        (
            "simplefoc.log",
            "courier convert simplefoc.log OUT --rate-hz HZ --column p1_m=angle:rad",
        ),
        ("tview_1_servo_stats.csv", "--column p1_m=abs_position:turn"),
    ] {
        let log = log_of(name, &beside_of(name)).unwrap();
        let found = convert::listing::suggestion(&log, name);
        assert!(found.contains(wanted), "{found}");
    }
}

/// Loggers of an ODrive give its values titles. A unit that they write is kept; without one a position is in turns.
#[test]
fn titles_of_an_odrive_are_known() {
    for (units, wanted) in [
        ("", "--column 'p1_m=ODrive 0 Position:turn'"),
        (
            "%[s],[rad],[rad/s]\n",
            "--column 'p1_m=ODrive 0 Position:rad'",
        ),
    ] {
        let rows = "0,1,0;\n1,2,1;\n2,3,1;\n";
        let text = format!("%Time,ODrive 0 Position,ODrive 0 Velocity\n{units}{rows}");
        let log = read_with(Path::new("a.csv"), text.as_bytes(), &Beside::default()).unwrap();
        let found = convert::listing::suggestion(&log, "a.csv");
        assert!(found.contains(wanted), "{found}");
        let note = |note: &String| note.contains("positions of an ODrive");
        assert!(log.notes.iter().any(note), "{:?}", log.notes);
    }
}

/// Of several drives in one log that one is suggested which goes farther than its own jitter.
#[test]
fn the_drive_that_moves_is_suggested() {
    let row = |k: usize| {
        let jitter = 0.25 * (k * k % 7) as f64;
        format!("{k},{jitter},{},{}\n", 0.1 * k as f64, 3.0 - 0.2 * k as f64)
    };
    let rows: String = (0..40).map(row).collect();
    let text = format!("%Time,ODrive 0 Position,ODrive 1 Position,ODrive 2 Position\n{rows}");
    let log = read_with(Path::new("a.csv"), text.as_bytes(), &Beside::default()).unwrap();
    let found = convert::listing::suggestion(&log, "a.csv");
    assert!(found.contains("ODrive 1 Position"), "{found}");
    let others = ["ODrive 0", "ODrive 2"];
    assert!(!others.iter().any(|other| found.contains(other)), "{found}");
}

/// A message of an encoder has a speed as well, often before the position.
#[test]
fn a_speed_is_not_suggested_as_a_position() {
    let signals = " SG_ Vel : 0|8@1+ (1,0) [0|0] \"\" X\n SG_ Pos : 8|8@1+ (1,0) [0|0] \"\" X\n";
    let beside = Beside {
        dbc: Some(("a.dbc".into(), format!("BO_ 1 Encoder: 8 X\n{signals}"))),
        ..Beside::default()
    };
    let frames = b"(1.0) can0 001#0102\n(1.1) can0 001#0103\n(1.2) can0 001#0105\n";
    let log = read_with(Path::new("a.log"), frames, &beside).unwrap();
    let found = convert::listing::suggestion(&log, "a.log");
    assert!(found.contains("--column p1_m=Encoder.Pos"), "{found}");
}
