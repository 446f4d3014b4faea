//! A recording in a file: nothing is lost, and what is wrong is told.

use bag::{is_recording, read, write};
use recording::{Existing, Recording, Row, Samples, Table};
use std::path::Path;

const META: &str = "schema = 1\ndevice = \"a board\"\nplaten_id = \"west\"\n[geometry]\npitch_m = 1.016e-3\nspan_m = 9.7e-3\nlateral_m = 3e-3\n\
                    [electronics]\nadc_bits = 16\namplitude_counts = 20000\nquadrature_noise_counts = 20\nposition_noise_m = 1e-9\n";

/// Counts of one segment, positions of another, a temperature now and then, two runs, a column beside.
pub fn recording() -> Recording {
    let columns = vec![
        ("t_s".to_owned(), vec![0.0]),
        ("p1_m".to_owned(), vec![0.0]),
    ];
    let table = Table {
        meta: META.into(),
        columns,
        ..Table::default()
    };
    let meta = Recording::of_table(Path::new("a"), table).unwrap().meta;
    let mut samples = Samples::default();
    for row in 0..500_i32 {
        let t_s = -0.01 + f64::from(row) * 1.0e-3 / 3.0;
        let mut sample = Row {
            t_s,
            run: if row < 300 { "there" } else { "back" },
            ..Row::default()
        };
        if row % 7 != 3 {
            sample.quadrature_counts[0] = Some([f64::from(row * 31 % 20_000), f64::from(-row)]);
            sample.teeth[0] = Some(row / 10 - 20);
        }
        sample.position_m[1] = Some(1.0e-3 / 7.0 * f64::from(row));
        sample.temperature_c = (row % 100 == 0).then_some(22.1);
        samples.push(&sample);
    }
    samples.log(recording::Logged {
        name: "aux_Drive_a".into(),
        values: (0..500)
            .map(|row| {
                if row == 5 {
                    f64::NAN
                } else {
                    f64::from(row) / 3.0
                }
            })
            .collect(),
    });
    Recording {
        meta,
        samples,
        warnings: Vec::new(),
    }
}

fn bits(recording: &Recording) -> Vec<(String, Vec<u64>)> {
    let samples = &recording.samples;
    let of = |values: &[f64]| {
        values
            .iter()
            .map(|value| {
                if value.is_nan() {
                    u64::MAX
                } else {
                    value.to_bits()
                }
            })
            .collect()
    };
    let layout = recording::COLUMNS
        .into_iter()
        .filter(|(column, _)| samples.has(*column));
    let layout = layout.map(|(column, name)| (name.to_owned(), of(samples.column(column))));
    layout
        .chain(
            samples
                .logged()
                .iter()
                .map(|logged| (logged.name.clone(), of(&logged.values))),
        )
        .collect()
}

#[test]
fn every_bit_comes_back() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.mcap");
    let made = recording();
    write(&made.meta, &made.samples, &file, Existing::Refuse).unwrap();
    assert!(is_recording(&file));
    let back = read(&file).unwrap();
    assert_eq!(bits(&back), bits(&made));
    assert_eq!(back.meta.to_toml(), made.meta.to_toml());
    assert!((0..500).all(|row| back.samples.run(row) == made.samples.run(row)));
    assert_eq!(back.warnings, [""; 0]);
}

#[test]
fn a_file_that_is_there_is_replaced_only_if_it_is_a_recording_and_that_is_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.mcap");
    let made = recording();
    let again =
        |existing| write(&made.meta, &made.samples, &file, existing).map_err(|error| error.found);
    std::fs::write(&file, "mine").unwrap();
    assert_eq!(again(Existing::Refuse), Err("a file".into()));
    assert_eq!(
        again(Existing::ReplaceRecording),
        Err("no recording".into())
    );
    std::fs::remove_file(&file).unwrap();
    again(Existing::Refuse).unwrap();
    assert_eq!(again(Existing::Refuse), Err("a file".into()));
    again(Existing::ReplaceRecording).unwrap();
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn files_that_are_cut_or_spoilt_are_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.mcap");
    let made = recording();
    write(&made.meta, &made.samples, &file, Existing::Refuse).unwrap();
    let whole = std::fs::read(&file).unwrap();
    let mut state = 1_u64;
    for round in 0..400 {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let place = (state >> 33) as usize % whole.len();
        let mut bytes = whole.clone();
        match round % 2 {
            0 => bytes.truncate(place),
            _ => bytes[place] ^= (state >> 20) as u8 | 1,
        }
        std::fs::write(&file, &bytes).unwrap();
        // A byte of the index, which is not read, may be any.
        match read(&file) {
            Ok(back) => assert!(
                round % 2 == 1 || place > whole.len() / 2,
                "cut at {place} of {}: {}",
                whole.len(),
                back.samples.len()
            ),
            Err(error) => assert!(
                error.to_string().contains("a.mcap") && !error.to_string().contains('\n'),
                "{error}"
            ),
        }
    }
    std::fs::write(&file, "t_s,p1_m\n0,1\n").unwrap();
    assert_eq!(read(&file).unwrap_err().found, "\"t_s,p1_m\"");
}

#[test]
fn a_bag_of_another_program_is_no_recording() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/files/rosbags.mcap");
    assert!(!is_recording(&file));
    let error = read(&file).unwrap_err();
    assert_eq!(
        (
            error.found.as_str(),
            error.wanted.starts_with("a recording; `courier convert`")
        ),
        ("no attachment recording.toml", true)
    );
}
