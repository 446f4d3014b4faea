//! Files that lack what is needed, and files that are cut or spoilt.

use super::{beside, beside_of, file, order};
use convert::{Beside, convert, read_with};
use std::path::Path;

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
    assert!(told("bus.log", &bus, &other).ends_with("wanted frames that o.dbc describes: M; to record the sensor's output where it is missing: candump -L CHANNEL while the device sends the frame of its position, and a line SG_ for it in the DBC file"));
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
    assert_eq!(
        told(
            "cal.raw",
            b"[\n  [\n    256,\n    5\n  ],\n  [\n    512,\n    1\n  ]\n]",
            &bare
        ),
        "cal.raw: found states of Hall sensors, six in a turn of the field, wanted readings of an encoder: without --cal-hall `--cal-write-raw FILE` writes them"
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
        told("a.log", b"MOT: Ready.\nTarget: 2.0\n", &bare).contains(
            "found a log of SimpleFOC without values, wanted lines of motor.monitor(); to record"
        )
    );

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

/// A NumPy file with this head.
fn npy(head: &str, data: &[u8]) -> Vec<u8> {
    [
        b"\x93NUMPY\x01\0",
        (head.len() as u16).to_le_bytes().as_slice(),
        head.as_bytes(),
        data,
    ]
    .concat()
}

/// A log as it is read and converted with these columns, refused.
fn refusal(name: &str, bytes: &[u8], columns: &[&str]) -> String {
    let log = read_with(Path::new(name), bytes, &beside_of(name)).unwrap();
    let error = convert(Path::new(name), &log, &order(columns, Some(100.0)));
    error.unwrap_err().to_string()
}

#[test]
fn a_log_without_the_sensors_output_says_how_its_program_records_one() {
    let odrive = "; to record the sensor's output where it is missing: capture the property axis0.pos_estimate of the ODrive (axis0.encoder.pos_estimate before its firmware 0.6): HighRateCapturer.from_properties(odrv, ['axis0.pos_estimate']), or a Recorder of it";
    let moteus = "; to record the sensor's output where it is missing: the channel servo_stats of tview, which has position and abs_position, or the register POSITION, which moteus.Controller queries unless its QueryResolution leaves it out";
    let numpy = "; to record the sensor's output where it is missing: numpy.savez(FILE, t=…, sin=…, cos=…), or numpy.savez(FILE, t=…, position=…)";
    let simplefoc = "; to record the sensor's output where it is missing: motor.monitor_variables = _MON_TARGET | _MON_VEL | _MON_ANGLE, motor.useMonitoring(Serial) in setup(), and motor.monitor() in loop()";
    let nothing = "wanted --column q1s=COLUMN --column q1c=COLUMN, or --column p1_m=COLUMN:UNIT; the log has ";
    let capture = npy(
        "{'descr': [('timestamps', '<f8'), ('axis0.vel_estimate', '<f8')], 'fortran_order': False, 'shape': (2,), }",
        &[0; 32],
    );
    let plain = npy(
        "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 1), }",
        &[0; 16],
    );
    let tview = "{\"controller\": \"1\", \"timestamp\": 1.5, \"channel\": \"servo_control\", \"data\": {\"mode\": 10}}\n";
    for (name, bytes, has, how) in [
        (
            "o.npy",
            capture.as_slice(),
            "\"timestamps\", \"axis0.vel_estimate\"",
            odrive,
        ),
        (
            "o.csv",
            b"t,axis0.vel_estimate\n0,1\n1,2\n",
            "\"t\", \"axis0.vel_estimate\"",
            odrive,
        ),
        (
            "m.csv",
            b"t,MODE,VELOCITY,TORQUE\n0,1,2,3\n1,1,2,3\n",
            "\"t\", \"MODE\", \"VELOCITY\", \"TORQUE\"",
            moteus,
        ),
        (
            "t.jsonl",
            tview.repeat(2).as_bytes(),
            "\"time\", \"1.servo_control.mode\"",
            moteus,
        ),
        ("n.npy", &plain, "\"#1\"", numpy),
        (
            "s.log",
            b"MOT:Ready.\n1.00\t2.00\n1.00\t2.50\n",
            "\"#1\", \"#2\"",
            simplefoc,
        ),
        (
            "can-utils.log",
            &std::fs::read(file("can-utils.log")).unwrap(),
            "\"time\", \"Raw.Page\", \"Raw.Sine\", \"Raw.Cosine\", \"Raw.Temp\", \"Encoder_Estimates.Pos_Estimate\", \"Encoder_Estimates.Vel_Estimate\", \"Place.Place\"",
            "; to record the sensor's output where it is missing: candump -L CHANNEL while the device sends the frame of its position, and a line SG_ for it in the DBC file",
        ),
        // Which program wrote it is not known.
        ("a.csv", b"t,place\n0,1\n1,2\n", "\"t\", \"place\"", ""),
    ] {
        assert_eq!(
            refusal(name, bytes, &[]),
            format!("{name}: found nothing for any segment, {nothing}{has}{how}")
        );
        let asked = refusal(name, bytes, &["p1_m=elsewhere:turn"]);
        assert!(
            asked.contains("found no column \"elsewhere\", wanted one of \"")
                && asked.ends_with(&format!(", for --column p1_m=elsewhere:turn{how}")),
            "{asked}"
        );
        let other = refusal(name, bytes, &["ref_x_m=elsewhere:turn"]);
        assert!(
            other.ends_with(", for --column ref_x_m=elsewhere:turn"),
            "{other}"
        );
    }
    let listed = |bytes| {
        let log = read_with(Path::new("o.npy"), bytes, &Beside::default()).unwrap();
        convert::listing::lacks(&log)
    };
    assert_eq!(
        listed(&capture).unwrap(),
        format!("no column is the sensor's output by its name{odrive}")
    );
    assert_eq!(
        listed(&std::fs::read(file("odrive-cycles.npy")).unwrap()),
        None
    );
}

#[test]
fn a_log_without_rows_says_how_its_program_records_some() {
    let empty = |descr: &str| {
        npy(
            &format!("{{'descr': {descr}, 'fortran_order': False, 'shape': (0,), }}"),
            &[],
        )
    };
    for (name, bytes, wanted) in [
        (
            "o.npy",
            empty("[('timestamp', '<u8'), ('axis0.pos_estimate', '<f4')]"),
            "capture the property axis0.pos_estimate",
        ),
        ("n.npy", empty("'<f8'"), "numpy.savez(FILE"),
        (
            "c.raw",
            b"CAL start\nCAL done\n".to_vec(),
            "moteus_tool --calibrate --cal-write-raw FILE",
        ),
    ] {
        let error = read_with(Path::new(name), &bytes, &Beside::default()).unwrap_err();
        let begin = format!(
            "{name}: found no rows of numbers or words, wanted a log with rows; to record the sensor's output where it is missing: {wanted}"
        );
        assert!(error.to_string().starts_with(&begin), "{error}");
    }
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
