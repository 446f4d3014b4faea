//! Bags that other programs wrote (`tests/files/make.py`), as logs and as recordings.

use convert::{Asked, Beside, Log, Order, Runs, convert};
use recording::{Column, Samples};
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

fn shaft_turns(t_s: f64) -> f64 {
    1.5 * (2.0 * t_s).sin()
}

fn read_turns(t_s: f64) -> f64 {
    shaft_turns(t_s) + 0.002 * (TAU * shaft_turns(t_s)).sin()
}

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/files")
        .join(name)
}

fn converted(name: &str, columns: &[&str]) -> (Log, Samples, Vec<String>) {
    let columns: Vec<Asked> = columns
        .iter()
        .map(|column| Asked::parse(column).unwrap())
        .collect();
    let beside = Beside {
        sensor: Beside::sensor_of(&columns),
        ..Beside::default()
    };
    let log = bag::log(&file(name), &beside).unwrap();
    let made = convert(
        &file(name),
        &log,
        &Order {
            columns,
            runs: Runs::One,
            ..Order::default()
        },
    )
    .unwrap();
    (log, made.recording.samples, made.told.done)
}

/// A turn is written as a millimetre.
fn close(samples: &Samples, column: Column, wanted: impl Fn(f64) -> f64, off: f64) {
    let values = samples.column(column);
    assert!(values.iter().filter(|value| value.is_finite()).count() > samples.len() * 9 / 10);
    for (t_s, value) in samples
        .t_s()
        .iter()
        .zip(values)
        .filter(|(_, value)| value.is_finite())
    {
        assert!(
            (value - wanted(*t_s)).abs() <= off,
            "{column:?} at {t_s} s: {value} for {}",
            wanted(*t_s)
        );
    }
}

const MM: f64 = 1.0e-3;

#[test]
fn joints_by_their_names_at_the_times_of_their_stamps() {
    let (log, samples, done) = converted(
        "rosbags.mcap",
        &["p1_m=position[elbow]:rad", "ref_x_m=/stage.data:deg"],
    );
    // Rounding of the product by 2π and back.
    close(
        &samples,
        Column::Position(0),
        |t_s| read_turns(t_s) * MM,
        1e-15,
    );
    // The stage comes each 10 ms; between its values a straight line is off by an eighth of 6 turns/s² times their square.
    close(
        &samples,
        Column::Reference(0),
        |t_s| shaft_turns(t_s) * MM,
        6.0 * 0.01_f64.powi(2) / 8.0 * MM,
    );
    assert!(
        done.iter()
            .any(|line| line == "times of /joint_states are its header's stamps"),
        "{done:?}"
    );
    let names: Vec<&str> = log
        .columns
        .iter()
        .map(|column| column.name.as_str())
        .collect();
    assert!(
        [
            "/joint_states.position[wrist]",
            "/pair.data[1]",
            "/temperature.temperature"
        ]
        .iter()
        .all(|name| names.contains(name)),
        "{names:?}"
    );
}

#[test]
fn a_pair_in_a_list_makes_the_rows() {
    let (_, samples, done) = converted(
        "rosbags.mcap",
        &[
            "q1s=/pair.data[0]",
            "q1c=/pair.data[1]",
            "ref_x_m=/stage.data:deg",
        ],
    );
    close(
        &samples,
        Column::Sine(0),
        |t_s| (8000.0 * (TAU * read_turns(t_s)).sin()).round(),
        0.0,
    );
    assert!(
        done[0].starts_with("a row for each of 120 messages /pair;"),
        "{done:?}"
    );
}

#[test]
fn messages_of_other_writers_and_of_json() {
    let (log, samples, _) = converted(
        "mcap-ros2.mcap",
        &["p1_m=place:turn", "ref_x_m=place:turn", "run=phase"],
    );
    close(
        &samples,
        Column::Position(0),
        |t_s| read_turns(t_s) * MM,
        1e-15,
    );
    assert_eq!((samples.run(59), samples.run(60)), ("out", "on"));
    let numbers = |name: &str| {
        &log.columns
            .iter()
            .find(|column| column.name.ends_with(name))
            .unwrap()
            .numbers
    };
    assert_eq!(
        (
            numbers("pair[1]")[7],
            numbers("moving")[0],
            numbers("moving")[7]
        ),
        (-7.0, 0.0, 1.0)
    );
    let (_, samples, done) = converted("json.mcap", &["p1_m=read:turn", "ref_x_m=place.true:turn"]);
    close(
        &samples,
        Column::Position(0),
        |t_s| read_turns(t_s) * MM,
        1e-15,
    );
    close(
        &samples,
        Column::Reference(0),
        |t_s| shaft_turns(t_s) * MM,
        1e-15,
    );
    assert!(
        done.iter().any(|line| line
            == "/image was left aside: messages of protobuf with definitions of jsonschema"),
        "{done:?}"
    );
}

#[test]
fn files_that_are_cut_or_spoilt_end_in_a_log_or_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let spoilt = folder.path().join("b.mcap");
    for name in ["rosbags.mcap", "mcap-ros2.mcap", "json.mcap"] {
        let whole = std::fs::read(file(name)).unwrap();
        let mut state = 1_u64;
        for round in 0..150 {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            let place = (state >> 33) as usize % whole.len();
            let mut bytes = whole.clone();
            match round % 2 {
                0 => bytes.truncate(place),
                _ => bytes[place] ^= (state >> 20) as u8 | 1,
            }
            std::fs::write(&spoilt, &bytes).unwrap();
            if let Err(error) = bag::log(&spoilt, &Beside::default()) {
                assert!(
                    error.to_string().contains("b.mcap") && !error.to_string().contains('\n'),
                    "{error}"
                );
            }
        }
    }
}

/// A bag with one topic, each of whose messages is these bytes.
fn bag_of(path: &Path, message: Option<(&str, &str, &str, &[u8])>) {
    let file = std::io::BufWriter::new(std::fs::File::create(path).unwrap());
    let mut writer = mcap::Writer::new(file).unwrap();
    for sequence in 0..2 {
        let Some((topic, of, definition, data)) = message else {
            continue;
        };
        let (schema, encoding) = definition.split_once(':').unwrap();
        let schema = writer.add_schema(of, schema, encoding.as_bytes()).unwrap();
        let channel = writer
            .add_channel(schema, topic, "cdr", &Default::default())
            .unwrap();
        let header = mcap::records::MessageHeader {
            channel_id: channel,
            sequence,
            log_time: u64::from(sequence) * 1_000_000,
            publish_time: 0,
        };
        writer.write_to_known_channel(&header, data).unwrap();
    }
    writer.finish().unwrap();
}

/// What was found, what is wanted, and how it comes into a bag: in one line.
#[test]
fn a_bag_without_a_sensors_output_says_how_one_is_recorded() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("b.mcap");
    let how = "; to record the sensor's output where it is missing: ros2 bag record --storage mcap TOPIC, where TOPIC has numbers, as sensor_msgs/JointState has position and std_msgs/Float64MultiArray has data";
    let wanted = format!("messages of ROS 2 (ros2msg, CDR) or JSON with numbers{how}");
    let mut words = bag::Packer::default();
    words.string("hello");
    let mut many = bag::Packer::default();
    many.uint32(100);
    let many = [many.bytes(), [7; 100].as_slice()].concat();
    for (message, found) in [
        (None, "no messages"),
        (
            Some(("/image", "a.Image", "protobuf:", [1].as_slice())),
            "/image was left aside: messages of cdr with definitions of protobuf",
        ),
        (
            Some(("/go", "std_msgs/msg/Empty", "ros2msg:", &[0, 1, 0, 0, 0])),
            "/go was left aside: its messages hold no numbers",
        ),
        (
            Some(("/scan", "a/Scan", "ros2msg:uint8[] data", many.as_slice())),
            "/scan was left aside: data, lists of many values",
        ),
    ] {
        bag_of(&path, message);
        let error = bag::log(&path, &Beside::default()).unwrap_err().to_string();
        assert_eq!(
            error,
            format!("{}: found {found}, wanted {wanted}", path.display())
        );
    }
    bag_of(
        &path,
        Some((
            "/chat",
            "std_msgs/msg/String",
            "ros2msg:string data",
            words.bytes(),
        )),
    );
    let log = bag::log(&path, &Beside::default()).unwrap();
    let error = convert(&path, &log, &Order::default())
        .unwrap_err()
        .to_string();
    let has = format!("the log has \"time\", \"/chat.data\"{how}");
    assert!(
        error.contains("found nothing for any segment") && error.ends_with(&has),
        "{error}"
    );
}
