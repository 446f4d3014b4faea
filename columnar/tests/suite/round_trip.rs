//! What is written comes back bit for bit, and small.

use crate::made::{meta, motion, next};
use proptest::prelude::*;
use recording::{COLUMNS, Column, Existing, Recording, Row, Samples};
use std::path::Path;

fn written(recording: &Recording, file: &Path) -> Recording {
    recording.check(Path::new("samples")).unwrap();
    columnar::write(&recording.meta, &recording.samples, file, Existing::Refuse).unwrap();
    let read = columnar::read(file).unwrap();
    let compact = file.with_extension("compact.parquet");
    compactly(recording, &compact);
    let again = columnar::read(&compact).unwrap();
    assert!(again.samples == read.samples && again.meta == read.meta);
    read
}

fn compactly(recording: &Recording, file: &Path) {
    columnar::write_compact(&recording.meta, &recording.samples, file, Existing::Refuse).unwrap();
}

/// A log of positions as encoders and their references are logged, to a tenth of a nanometre, with noise of a micrometre and of ten
/// nanometres: DOUBLE takes a quarter of the table.
#[test]
fn positions_of_few_digits_take_a_tenth_of_the_table_compactly() {
    let folder = tempfile::tempdir().unwrap();
    let (mut samples, mut state) = (Samples::default(), 1);
    for index in 0..20_000 {
        let mut noisy = |place_m: f64, noise_m: f64| {
            let noise = (0..12).map(|_| next(&mut state)).sum::<f64>() - 6.0;
            ((place_m + noise_m * noise) * 1e10).round() / 1e10
        };
        let place_m = 0.05 * (f64::from(index) * 1e-3).sin();
        let position_m = noisy(place_m, 1e-6);
        samples.push(&Row {
            t_s: f64::from(index) / 1000.0,
            position_m: [Some(position_m), None, None, None],
            reference: [Some(noisy(place_m, 1e-8)), None, None],
            ..Row::default()
        });
    }
    let recording = Recording {
        meta: meta(),
        samples,
        warnings: Vec::new(),
    };
    let [plain, compact] = ["a", "b"].map(|name| folder.path().join(name));
    assert!(written(&recording, &plain) == recording);
    compactly(&recording, &compact);
    recording
        .write(folder.path().join("c"), Existing::Refuse)
        .unwrap();
    let bytes = |path: &Path| std::fs::metadata(path).unwrap().len();
    let table = bytes(&folder.path().join("c/samples.csv"));
    println!("{} and {} of {table}", bytes(&plain), bytes(&compact));
    assert!(10 * bytes(&compact) <= table && 5 * bytes(&plain) > table);
}

#[test]
fn a_recording_of_several_groups_is_the_same_from_either_form() {
    let folder = tempfile::tempdir().unwrap();
    // More than the samples of a group, and no multiple of them.
    let recording = motion(140_001);
    let read = written(&recording, &folder.path().join("a.parquet"));
    assert_eq!(read.warnings, [""; 0]);
    assert_eq!(read, recording);
    recording
        .write(folder.path().join("a"), Existing::Refuse)
        .unwrap();
    assert_eq!(read, Recording::read(folder.path().join("a")).unwrap());
}

/// The figure that was asked for: a tenth of the table's bytes, at the board's full rate. Stretches of rest and of motion at 50 mm/s
/// are stored alike; the noise of the converter decides.
#[test]
fn a_board_s_samples_take_a_tenth_of_the_table() {
    let folder = tempfile::tempdir().unwrap();
    let mut recording = motion(150_000);
    recording = recording.with_rows(|_, row| {
        (row.electrode_counts, row.reference) = (None, [None; 3]);
        true
    });
    let mut samples = Samples::default();
    (0..recording.samples.len()).for_each(|index| samples.push(&recording.samples.row(index)));
    recording.samples = samples;
    let file = folder.path().join("a.parquet");
    written(&recording, &file);
    recording
        .write(folder.path().join("a"), Existing::Refuse)
        .unwrap();
    let bytes = |path: &Path| std::fs::metadata(path).unwrap().len();
    let (new, table) = (bytes(&file), bytes(&folder.path().join("a/samples.csv")));
    assert!(new * 10 <= table, "{new} of {table}");
    let compact = 8.0 * bytes(&file.with_extension("compact.parquet")) as f64;
    let columns = COLUMNS.map(|(column, _)| recording.samples.column(column));
    let least: f64 = columns
        .into_iter()
        .map(|values| columnar::least_bits(values, columnar::BY_ANY_FORM))
        .sum();
    let counts: usize = columns[..9].iter().map(|values| values.len()).sum();
    // A difference has twice the noise's variance, half a bit; whole bits are one more at most, and 7 bytes head each 128 differences, half a bit. The
    // noise is even over 40 counts, which holds 0.62 bits less than a normal one of its median, so a file may come out below.
    let over = (compact - least) / counts as f64;
    println!(
        "{:.2} of the noise, {over:.2} bits a value",
        compact / least
    );
    assert!((-0.62..2.0).contains(&over), "{compact} {least}");
}

/// Waves past teeth, a good part of one from sample to sample. A miniblock of 32 differences has whole bits for its range, which of normal noise is as wide
/// as its entropy: at most one more; and half a bit a value is heads of blocks. Of a wave the range is 1.46 bits less than a normal one's of its median.
#[test]
fn counts_that_move_take_little_more_than_one_number_before_tells() {
    let folder = tempfile::tempdir().unwrap();
    let (mut samples, mut state) = (Samples::default(), 1);
    for index in 0..20_000 {
        // At ever another speed: the same waves again would be found again.
        let phase = (0.3 + 1.0e-5 * f64::from(index)) * f64::from(index);
        let mut count = |wave: f64| {
            let noise = (0..12).map(|_| next(&mut state)).sum::<f64>() - 6.0;
            (20_000.0 * wave + 20.0 * noise).round() + 0.0
        };
        samples.push(&Row {
            t_s: f64::from(index) / 400.0,
            quadrature_counts: [Some([count(phase.sin()), count(phase.cos())]); 4],
            ..Row::default()
        });
    }
    let file = folder.path().join("moving.parquet");
    columnar::write_compact(&meta(), &samples, &file, Existing::Refuse).unwrap();
    let columns = COLUMNS.map(|(column, _)| samples.column(column));
    let least: f64 = columns
        .into_iter()
        .map(|values| columnar::least_bits(values, columnar::BY_PARQUET))
        .sum();
    let bits = 8.0 * std::fs::metadata(&file).unwrap().len() as f64;
    let over = (bits - least) / (8 * samples.len()) as f64;
    println!("{over:.2} bits a value over one number before");
    assert!((-1.46..1.5).contains(&over), "{over} bits a value");
}

#[test]
fn numbers_that_other_types_would_lose_come_back() {
    let folder = tempfile::tempdir().unwrap();
    let mut samples = Samples::default();
    for (index, value) in [-0.0, 0.1 + 0.2, 1.0e-300, -999.999]
        .into_iter()
        .enumerate()
    {
        samples.push(&Row {
            t_s: f64::from(index as u32) + 0.1 * f64::from(index as u32),
            position_m: [Some(value); 4],
            quadrature_counts: [Some([value, 0.5]), None, None, None],
            teeth: [Some(-7), None, None, None],
            ..Row::default()
        });
    }
    let recording = Recording {
        meta: meta(),
        samples,
        warnings: Vec::new(),
    };
    let read = written(&recording, &folder.path().join("a.parquet"));
    for (column, name) in COLUMNS {
        let bits = |recording: &Recording| -> Vec<u64> {
            recording
                .samples
                .column(column)
                .iter()
                .map(|value| value.to_bits())
                .collect()
        };
        assert_eq!(bits(&read), bits(&recording), "{name}");
    }
    let counts = ["q1s", "q1c"].map(|name| {
        let row = if name == "q1c" { 1 } else { 2 };
        format!("a.parquet: column {name} holds counts that are not whole, first in row {row}")
    });
    assert_eq!(read.warnings, counts);
}

#[test]
fn what_is_there_is_replaced_only_where_it_is_a_recording_and_may_be() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.parquet");
    let recording = motion(10);
    let write = |existing| {
        columnar::write(&recording.meta, &recording.samples, &file, existing)
            .map_err(|error| error.to_string())
    };
    write(Existing::Refuse).unwrap();
    assert!(
        write(Existing::Refuse)
            .unwrap_err()
            .ends_with("found a file, wanted a new file")
    );
    write(Existing::ReplaceRecording).unwrap();
    std::fs::write(&file, "my own text").unwrap();
    let error = write(Existing::ReplaceRecording).unwrap_err();
    assert!(
        error.ends_with("found no recording, wanted a new file, or a recording"),
        "{error}"
    );
    assert_eq!(std::fs::read(&file).unwrap(), b"my own text");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

/// A value for each of these columns or none, in each row.
fn rows() -> impl Strategy<Value = Vec<[Option<i16>; 6]>> {
    proptest::collection::vec(
        proptest::array::uniform6(proptest::option::of(any::<i16>())),
        1..60,
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    /// Whatever is measured in whichever row, in whole counts or not.
    #[test]
    fn random_recordings_come_back(rows in rows(), fraction in 0.0..1.0f64) {
        let mut samples = Samples::default();
        for (index, [a, b, c, d, e, f]) in rows.into_iter().enumerate() {
            let real = |value: Option<i16>| value.map(|value| f64::from(value) * fraction);
            samples.push(&Row {
                t_s: index as f64 * fraction.max(1.0e-6),
                run: ["", "one", "two"][index % 3],
                position_m: [Some(0.001), real(a).map(|v| v * 0.01), None, None],
                quadrature_counts: [a.zip(b).map(|(a, b)| [f64::from(a), f64::from(b)]), None, None, None],
                teeth: [c.map(i32::from), None, None, None],
                electrode_counts: d.map(|d| [f64::from(d); 4]),
                temperature_c: real(e).map(f64::abs).map(|v| v.min(400.0)),
                reference: [real(f).map(|v| v * 0.01), None, None],
                ..Row::default()
            });
        }
        let recording = Recording { meta: meta(), samples, warnings: Vec::new() };
        let folder = tempfile::tempdir().unwrap();
        let read = written(&recording, &folder.path().join("a.parquet"));
        prop_assert_eq!(&read.samples, &recording.samples);
        prop_assert_eq!(read.samples.has(Column::Sine(0)), recording.samples.has(Column::Sine(0)));
    }
}
