//! Files of other programs, made by these programs (`tests/files/README.md`): one motion, a shaft that swings over three turns.

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
fn numpy_tables_and_archives() {
    let named = ["t_s=t:s", "q1s=sin", "q1c=cos", "ref_x_m=stage:turn"];
    let numbered = ["t_s=#1:s", "q1s=#2", "q1c=#3", "ref_x_m=#4:turn"];
    // Resolution of `stage`, kept as a number of 32 bits, at 1.5 turns.
    let single = 1.5 * f64::from(f32::EPSILON) * MM;
    for (name, columns, off) in [
        ("structured.npy", &named, single),
        ("columns.npz", &named, 1e-15),
        ("compressed.npz", &named, 1e-15),
        ("plain.npy", &numbered, 1e-15),
    ] {
        let made = converted(name, columns, None);
        assert_eq!(made.recording.samples.len(), 240, "{name}");
        close(
            &made,
            Column::Reference(0),
            |t_s| shaft_turns(t_s) * MM,
            off,
        );
        close(
            &made,
            Column::Sine(0),
            |t_s| (8000.0 * (TAU * read_turns(t_s)).sin()).round(),
            0.0,
        );
        close(
            &made,
            Column::Cosine(0),
            |t_s| (8000.0 * (TAU * read_turns(t_s)).cos()).round(),
            0.0,
        );
    }
    // Its times are of 32 bits as well, so that the shaft is elsewhere by its speed, 3 turns/s, times their resolution.
    let made = converted("fortran.npy", &numbered, None);
    close(
        &made,
        Column::Reference(0),
        |t_s| shaft_turns(t_s) * MM,
        single + 3.0 * 1.2 * f64::from(f32::EPSILON) * MM,
    );
}

#[test]
fn odrive_captures_in_either_count_of_time() {
    for (name, rate_hz, told) in [
        ("odrive-cycles.npy", 8000.0, "control cycles"),
        ("odrive-nanoseconds.npy", 8000.0, "nanoseconds"),
    ] {
        let made = converted(
            name,
            &[
                "p1_m=axis0.pos_estimate",
                "cmd_x_m=axis0.controller.pos_setpoint",
            ],
            None,
        );
        assert!(
            (made.told.rate_hz - rate_hz).abs() < 1e-6,
            "{name}: {}",
            made.told.rate_hz
        );
        assert!(
            made.told.done.iter().any(|done| done.contains(told)),
            "{:?}",
            made.told.done
        );
        // The values were taken 200 a second; the capture's clock says 8000.
        close(
            &made,
            Column::Position(0),
            |t_s| read_turns(40.0 * t_s) * MM,
            1.5 * f64::from(f32::EPSILON) * MM,
        );
    }
}

#[test]
fn signals_of_a_bus_by_its_dbc_file() {
    let columns = ["p1_m=Pos_Estimate", "ref_x_m=Place"];
    let made = converted("can-utils.log", &columns, None);
    let single = 1.5 * f64::from(f32::EPSILON) * MM;
    close(
        &made,
        Column::Position(0),
        |t_s| read_turns(t_s) * MM,
        single + 3.0 * 1e-6 * MM,
    );
    // Between messages 10 ms apart a swing of 1.5 turns at 2 rad/s bends by an eighth of 6 turns/s² times their square; a step of the
    // signal is 0.0001 degrees.
    let bend = 6.0 * 0.01_f64.powi(2) / 8.0;
    close(
        &made,
        Column::Reference(0),
        |t_s| shaft_turns(t_s) * MM,
        (bend + 1e-4 / 360.0) * MM,
    );
    let note = made
        .told
        .done
        .iter()
        .find(|done| done.starts_with("Place.Place was interpolated"))
        .unwrap();
    let told: f64 = note
        .rsplit_once("off by ")
        .unwrap()
        .1
        .strip_suffix(" deg rms")
        .unwrap()
        .parse()
        .unwrap();
    let swing: f64 = (0..240)
        .map(|row| (2.0 * f64::from(row) / 200.0).sin().powi(2))
        .sum::<f64>()
        / 240.0;
    let wanted = bend * 360.0 * swing.sqrt();
    assert!((told - wanted).abs() < 0.02 * wanted, "{note}: {wanted}");

    // Multiplexed, of 29 bits, most significant byte first; temperatures come once in fifty.
    let beside = Beside {
        rows_of: Some("raw".into()),
        ..beside()
    };
    let log = log_of("can-utils.log", &beside).unwrap();
    let made = convert(
        Path::new("can-utils.log"),
        &log,
        &order(
            &["q1s=Sine*2", "q1c=Cosine*2", "ref_x_m=Pos_Estimate"],
            None,
        ),
    )
    .unwrap();
    let sine = made.recording.samples.column(Column::Sine(0));
    let held: Vec<f64> = sine
        .iter()
        .copied()
        .filter(|value| value.is_finite())
        .collect();
    assert_eq!((sine.len(), held.len()), (245, 240));
    assert_eq!(held[30], (8000.0 * (TAU * read_turns(0.15)).sin()).round());
    let temperature = log
        .columns
        .iter()
        .find(|column| column.name == "Raw.Temp")
        .unwrap();
    assert_eq!(
        temperature
            .numbers
            .iter()
            .copied()
            .filter(|value| value.is_finite())
            .collect::<Vec<_>>(),
        [21.5; 5]
    );
}

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

#[test]
fn what_a_file_lacks_is_told_with_the_way_to_get_it() {
    let bare = Beside::default();
    let told = |name: &str, bytes: &[u8], beside: &Beside| {
        read_with(Path::new(name), bytes, beside)
            .unwrap_err()
            .to_string()
    };
    let bus = std::fs::read(file("can-utils.log")).unwrap();
    assert_eq!(
        told("bus.log", &bus, &bare),
        "bus.log: found frames of CAN identifiers 009 (240), 010 (120), 18FEF1FE (245), and nothing that says which bits are which signal, wanted --dbc FILE, where a line BO_ names a frame and lines SG_ its signals (docs/other-logs.md)"
    );
    let other = Beside {
        dbc: Some((
            "o.dbc".into(),
            "BO_ 1 M: 8 X\n SG_ a : 0|8@1+ (1,0) [0|0] \"\" X\n".into(),
        )),
        ..Beside::default()
    };
    assert!(told("bus.log", &bus, &other).ends_with("wanted frames that o.dbc describes: M"));
    let elsewhere = Beside {
        rows_of: Some("Axis".into()),
        ..beside()
    };
    assert!(told("bus.log", &bus, &elsewhere).ends_with(
        "found no messages \"Axis\", wanted --rows-of one of Encoder_Estimates, Raw, Place"
    ));
    let table = b"t_s,p1_m\n0,1\n1,2\n";
    assert_eq!(
        told("t.csv", table, &beside()),
        "t.csv: found a log that --dbc says nothing of, wanted --dbc beside frames of candump alone"
    );
    let rows_of = Beside {
        rows_of: Some("Raw".into()),
        ..Beside::default()
    };
    assert!(told("t.csv", table, &rows_of).contains("found a log that --rows-of says nothing of"));
    let two = [
        bus.as_slice(),
        b"(1795785169.0) can1 009#0000000000000000\n",
    ]
    .concat();
    assert!(told("bus.log", &two, &beside()).contains("row 606, found Encoder_Estimates on can0 and on can1, wanted one bus: grep ' can0 ' bus.log"));
    let spoilt = [bus.as_slice(), b"oops\n", &bus].concat();
    assert!(
        told("bus.log", &spoilt, &beside())
            .contains("row 606, found \"oops\", wanted a frame with its time")
    );

    let report = b"{\n  \"timestamp\": \"x\",\n  \"device_info\": {},\n  \"calibration\": {\"poles\": 14}\n}\n";
    assert_eq!(
        told("cal.json", report, &bare),
        "cal.json: found moteus_tool's report of a calibration, without readings, wanted the readings, which `moteus_tool --calibrate --cal-write-raw FILE` writes as well"
    );
    assert!(
        told(
            "cal.log",
            b"CAL start\n1 2 3\n1 x 3\n1 2 3\nCAL done\n",
            &bare
        )
        .contains("row 3, found \"1 x 3\"")
    );
    assert!(
        told("a.jsonl", b"{\"a\": 1}\nx\n{\"a\": 2}\n", &bare)
            .contains("row 2, found \"x\", wanted an object of JSON in each line")
    );
    assert!(
        told("a.log", b"MOT: Ready.\nTarget: 2.0\n", &bare)
            .contains("found a log of SimpleFOC without values")
    );

    let npy = |head: &str, data: &[u8]| {
        [
            b"\x93NUMPY\x01\0",
            (head.len() as u16).to_le_bytes().as_slice(),
            head.as_bytes(),
            data,
        ]
        .concat()
    };
    for (head, wanted) in [
        (
            "{'descr': '|O', 'fortran_order': False, 'shape': (1,), }",
            "found a NumPy array of Python's objects",
        ),
        (
            "{'descr': '<f8', 'fortran_order': False, 'shape': (1,), }",
            "found a NumPy file that is cut short",
        ),
        (
            "{'descr': '<f8', 'fortran_order': False, 'shape': (), }",
            "found an array of shape ()",
        ),
        (
            "{'descr': '<U1', 'fortran_order': False, 'shape': (1,), }",
            "found an array without numbers",
        ),
        (
            "{'descr': '<f8', 'fortran_order': False, 'shape': (1, 1, 1), }",
            "found an array of shape (1, 1, 1)",
        ),
        ("{'descr': '<f8', 'shape': (1,), }", "whose head lacks"),
    ] {
        let data: &[u8] = if wanted.contains("cut short") {
            &[0; 7]
        } else {
            &[0; 8]
        };
        let error = told("a.npy", &npy(head, data), &bare);
        assert!(
            error.contains(wanted) && error.contains("numpy.save(FILE, TABLE)"),
            "{error}"
        );
    }
    for (bytes, wanted) in [
        (
            b"SQLite format 3\0".as_slice(),
            "a bag in MCAP: `ros2 bag convert`",
        ),
        (b"#ROSBAG V2.0\n", "a bag of ROS 2 in MCAP: rosbags-convert"),
        (b"\x89MCAP0\r\n", "a name that ends in .mcap"),
        (b"\x89HDF\r\n\x1a\n", "numpy.savez"),
    ] {
        assert!(told("a.bag", bytes, &bare).contains(wanted), "{wanted}");
    }
    assert!(told("a.npz", b"PK\x03\x04rest", &bare).contains("a ZIP archive that cannot be read"));
}

#[test]
fn files_that_are_cut_or_spoilt_end_in_a_log_or_in_one_line() {
    let names = [
        "structured.npy",
        "fortran.npy",
        "columns.npz",
        "compressed.npz",
        "can-utils.log",
        "tview.jsonl",
        "simplefoc-arduino.log",
    ];
    for name in names {
        let whole = std::fs::read(file(name)).unwrap();
        let mut state = 1_u64;
        for round in 0..60 {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            let place = (state >> 33) as usize % whole.len();
            let mut bytes = whole.clone();
            match round % 2 {
                0 => bytes.truncate(place),
                _ => bytes[place] ^= (state >> 20) as u8 | 1,
            }
            if let Err(error) = read_with(Path::new(name), &bytes, &beside_of(name)) {
                let error = error.to_string();
                assert!(error.starts_with(name) && !error.contains('\n'), "{error}");
            }
        }
    }
}

#[test]
fn the_last_line_of_a_log_that_was_cut_is_left_out() {
    for name in ["can-utils.log", "tview.jsonl"] {
        let whole = std::fs::read(file(name)).unwrap();
        let log = read_with(
            Path::new(name),
            &whole[..whole.len() - 20],
            &beside_of(name),
        )
        .unwrap();
        assert!(log.cut_short, "{name}");
    }
}

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
