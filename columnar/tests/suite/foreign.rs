//! Files of other programs: what they lack, and how to get it. They are written here with the library as pandas and DuckDB write them;
//! `cargo xtask nightly` has the real ones write and read.

use parquet::basic::{LogicalType, Repetition, TimeUnit, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, FloatType, Int32Type, Int64Type};
use parquet::file::metadata::KeyValue;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use std::fs::File;
use std::path::Path;
use std::sync::Arc;

/// A column as another program writes it.
enum Values {
    Double(Vec<f64>),
    Float(Vec<f32>),
    Whole(Vec<i64>),
    Nanoseconds(Vec<i64>),
    Cents(Vec<i32>),
    Text(Vec<&'static str>),
    /// Text without a value in any row.
    NoText(usize),
}

const META: &str =
    "schema = 1\n[geometry]\npitch_m = 1e-3\n[electronics]\nposition_noise_m = 1e-8\n";

fn write(path: &Path, columns: &[(&str, Values)], meta: Option<&str>) {
    let field = |(name, values): &(&str, Values)| {
        let decimal = LogicalType::decimal(2, 9);
        let (physical, logical) = match values {
            Values::Double(_) => (Physical::DOUBLE, None),
            Values::Float(_) => (Physical::FLOAT, None),
            Values::Whole(_) => (Physical::INT64, None),
            Values::Nanoseconds(_) => (
                Physical::INT64,
                Some(LogicalType::timestamp(false, TimeUnit::NANOS)),
            ),
            Values::Cents(_) => (Physical::INT32, Some(decimal)),
            Values::Text(_) | Values::NoText(_) => {
                (Physical::BYTE_ARRAY, Some(LogicalType::String))
            }
        };
        let builder = Type::primitive_type_builder(name, physical)
            .with_repetition(Repetition::OPTIONAL)
            .with_logical_type(logical);
        let builder = if matches!(values, Values::Cents(_)) {
            builder.with_precision(9).with_scale(2)
        } else {
            builder
        };
        Arc::new(builder.build().unwrap())
    };
    let group = Type::group_type_builder("schema").with_fields(columns.iter().map(field).collect());
    let mut writer = SerializedFileWriter::new(
        File::create(path).unwrap(),
        Arc::new(group.build().unwrap()),
        Arc::default(),
    )
    .unwrap();
    let mut rows = writer.next_row_group().unwrap();
    for (_, values) in columns {
        let mut column = rows.next_column().unwrap().unwrap();
        let there = |length: usize| vec![1; length];
        match values {
            Values::Double(v) => {
                column
                    .typed::<DoubleType>()
                    .write_batch(v, Some(&there(v.len())), None)
            }
            Values::Float(v) => {
                column
                    .typed::<FloatType>()
                    .write_batch(v, Some(&there(v.len())), None)
            }
            Values::Whole(v) | Values::Nanoseconds(v) => {
                column
                    .typed::<Int64Type>()
                    .write_batch(v, Some(&there(v.len())), None)
            }
            Values::Cents(v) => {
                column
                    .typed::<Int32Type>()
                    .write_batch(v, Some(&there(v.len())), None)
            }
            Values::Text(v) => {
                let texts: Vec<ByteArray> = v.iter().map(|text| ByteArray::from(*text)).collect();
                column
                    .typed::<ByteArrayType>()
                    .write_batch(&texts, Some(&there(v.len())), None)
            }
            Values::NoText(length) => {
                column
                    .typed::<ByteArrayType>()
                    .write_batch(&[], Some(&vec![0; *length]), None)
            }
        }
        .unwrap();
        column.close().unwrap();
    }
    rows.close().unwrap();
    if let Some(text) = meta {
        writer.append_key_value_metadata(KeyValue::new("recording.toml".into(), text.to_owned()));
    }
    writer.close().unwrap();
}

fn two(name: &'static str, values: Values) -> (&'static str, Values) {
    (name, values)
}

fn time() -> (&'static str, Values) {
    two("t_s", Values::Double(vec![0.0, 0.5]))
}

/// What reading says, without the folder.
fn told(columns: &[(&str, Values)], meta: Option<&str>) -> String {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.parquet");
    write(&file, columns, meta);
    let told = match columnar::read(&file) {
        Ok(read) => read.warnings.join("; "),
        Err(error) => error.to_string(),
    };
    told.replace(&folder.path().display().to_string(), "")
        .trim_start_matches(['/', '\\'])
        .to_owned()
}

#[test]
fn types_that_hold_the_same_numbers_are_taken() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.parquet");
    let columns = [
        two("p1_m", Values::Float(vec![0.25, 0.5])),
        time(),
        two("ref_x_m", Values::Double(vec![f64::NAN, 0.125])),
        two("cmd_x_m", Values::Whole(vec![0, 1])),
        two("cmd_y_m", Values::Cents(vec![0, 25])),
        two("temp_c", Values::NoText(2)),
        two("run", Values::Text(vec!["there", "back"])),
        two("note", Values::Text(vec!["a", "b"])),
    ];
    write(&file, &columns, Some(META));
    let read = columnar::read(&file).unwrap();
    let row = read.samples.row(1);
    assert_eq!(
        (row.run, row.position_m[0], row.commanded[0]),
        ("back", Some(0.5), Some(1.0))
    );
    assert_eq!(row.commanded[1], Some(0.25));
    assert_eq!(read.samples.row(0).reference[0], None);
    assert_eq!(
        read.warnings,
        ["a.parquet: column \"note\" is not known and is left aside"]
    );
}

#[test]
fn what_is_missing_or_of_another_type_is_told_with_the_way_to_it() {
    let position = || two("p1_m", Values::Double(vec![0.0, 0.001]));
    for (columns, meta, wanted) in [
        (
            vec![time(), position()],
            None,
            "a.parquet: found no recording.toml in its metadata, and 2 of the layout's columns, wanted that text, which states lengths, converter and noise; `courier convert FILE OUT --pitch LENGTH` measures and adds it",
        ),
        (
            vec![two("time", Values::Double(vec![0.0, 1.0]))],
            None,
            "a.parquet: found no recording.toml in its metadata, and 0 of the layout's columns, wanted a recording; `courier convert` makes one of a log: `courier convert FILE` lists the columns",
        ),
        (
            vec![position()],
            Some(META),
            "a.parquet: column t_s, found none, wanted the column of time, s; `courier convert FILE OUT` makes it of what there is",
        ),
        (
            vec![two("t_s", Values::Nanoseconds(vec![0, 5])), position()],
            Some(META),
            "a.parquet: column t_s, found a TIMESTAMP, wanted numbers; seconds: epoch_ns(t_s) / 1e9 in DuckDB, (t_s - t_s.iloc[0]).dt.total_seconds() in pandas",
        ),
        (
            vec![time(), two("p1_m", Values::Text(vec!["0", "1"]))],
            Some(META),
            "a.parquet: column p1_m, found text, wanted numbers; CAST(p1_m AS DOUBLE) in DuckDB, .astype(float) in pandas",
        ),
        (
            vec![time(), position(), two("run", Values::Whole(vec![1, 2]))],
            Some(META),
            "a.parquet: column run, found INT64, wanted text; CAST(run AS VARCHAR) in DuckDB, .astype(str) in pandas",
        ),
        (
            vec![
                time(),
                two("p1_m", Values::Double(vec![0.0, f64::INFINITY])),
            ],
            Some(META),
            "a.parquet: row 2, column p1_m, found \"inf\", wanted a finite number",
        ),
        (
            vec![time(), position()],
            Some("schema = 2"),
            "a.parquet/recording.toml: key schema, found 2, wanted 1, the only schema that is known",
        ),
        (
            vec![time(), time(), position()],
            Some(META),
            "a.parquet: column t_s, found the name a second time, wanted each column once",
        ),
    ] {
        assert_eq!(told(&columns, meta).replace('\\', "/"), wanted);
    }
}

#[test]
fn a_file_that_is_no_parquet_or_is_not_there_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.parquet");
    let told = || columnar::read(&file).unwrap_err().to_string();
    assert!(
        told().ends_with("found no such file, wanted a Parquet file"),
        "{}",
        told()
    );
    for text in ["", "t_s,p1_m\n0,0\n"] {
        std::fs::write(&file, text).unwrap();
        assert!(
            told().ends_with("wanted a whole Parquet file, not compressed, or by snappy or zstd"),
            "{}",
            told()
        );
    }
    assert!(
        columnar::read(folder.path())
            .unwrap_err()
            .to_string()
            .contains("wanted a Parquet file")
    );
}

#[test]
fn a_log_has_its_times_as_seconds_and_its_words() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("log.parquet");
    let columns = [
        two(
            "when",
            Values::Nanoseconds(vec![1_700_000_000_000_000_001, 1_700_000_000_500_000_001]),
        ),
        two("sin", Values::Cents(vec![150, -25])),
        two("part", Values::Text(vec!["up", "down"])),
    ];
    write(&file, &columns, None);
    let log = columnar::log(&file).unwrap();
    assert_eq!(log.columns[0].numbers, [0.0, 0.5]);
    assert_eq!(log.columns[0].unit.as_deref(), Some("s"));
    assert_eq!(log.columns[1].numbers, [1.5, -0.25]);
    assert_eq!(
        log.columns[2].words,
        [(0, "up".to_owned()), (1, "down".to_owned())]
    );
    assert_eq!(log.lines, [1, 2]);
}
