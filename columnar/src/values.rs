//! The columns of any Parquet file, as numbers and words.

use crate::guard::told;
use parquet::basic::{ConvertedType, LogicalType, TimeUnit, Type as Physical};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::{ByteArray, DataType};
use parquet::errors::{ParquetError, Result};
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::schema::types::ColumnDescriptor;
use recording::Error;
use std::fs::File;
use std::path::Path;

/// What the values of a column mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Meaning {
    /// A number as it stands.
    Number,
    /// A whole number without a sign.
    Unsigned,
    /// A whole number of so many powers of ten less.
    Decimal(i32),
    /// A point in time or a time of day: whole numbers of so many in a second.
    Instant(f64),
    /// Text.
    Text,
    /// None that is a number or a text.
    Other,
}

/// Values of a column: a number a row, NaN where there is none, or a text.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Content {
    Numbers(Vec<f64>),
    Texts(Vec<Option<ByteArray>>),
}

/// An opened file.
pub(crate) struct Opened<'a> {
    path: &'a Path,
    reader: SerializedFileReader<File>,
}

impl<'a> Opened<'a> {
    /// Opens a file and reads what it says of itself.
    ///
    /// # Errors
    /// It is not there, is no file, or is no whole Parquet file.
    pub(crate) fn open(path: &'a Path) -> std::result::Result<Self, Error> {
        let wanted = "a Parquet file";
        let no = |found: String| Error::new(path, found, wanted);
        let file = File::open(path).map_err(|error| match error.kind() {
            std::io::ErrorKind::NotFound => no("no such file".into()),
            _ => no(error.to_string()),
        })?;
        let data = file.metadata().map_err(|error| no(error.to_string()))?;
        if !data.is_file() {
            return Err(no("no regular file".into()));
        }
        let reader = SerializedFileReader::new(file).map_err(|error| told(path, &error))?;
        Ok(Self { path, reader })
    }

    /// The file's name.
    pub(crate) fn path(&self) -> &'a Path {
        self.path
    }

    /// The text under a key of the file's metadata.
    pub(crate) fn said(&self, key: &str) -> Option<&str> {
        let all = self
            .reader
            .metadata()
            .file_metadata()
            .key_value_metadata()?;
        all.iter().find(|pair| pair.key == key)?.value.as_deref()
    }

    /// The columns, those inside of others by their whole path.
    pub(crate) fn columns(&self) -> Vec<(String, Meaning)> {
        let schema = self.reader.metadata().file_metadata().schema_descr();
        let columns = schema.columns().iter();
        columns
            .map(|column| (column.path().string(), meaning(column)))
            .collect()
    }

    /// What the type of a column is called.
    pub(crate) fn type_name(&self, place: usize) -> String {
        let column = self
            .reader
            .metadata()
            .file_metadata()
            .schema_descr()
            .column(place);
        match (
            column.max_rep_level() > 0,
            meaning(&column),
            column.logical_type_ref(),
        ) {
            (true, ..) => "a list".into(),
            (_, Meaning::Text, _) => "text".into(),
            (_, Meaning::Instant(_), _) => "a TIMESTAMP".into(),
            (_, Meaning::Decimal(_), _) => "a DECIMAL".into(),
            (_, _, Some(LogicalType::Date)) => "a DATE".into(),
            _ => column.physical_type().to_string(),
        }
    }

    /// Every value of a column.
    ///
    /// # Errors
    /// The file is spoilt there, or the column holds neither numbers nor texts.
    pub(crate) fn content(&self, place: usize) -> std::result::Result<Content, Error> {
        let schema = self.reader.metadata().file_metadata().schema_descr();
        let column = schema.column(place);
        let content = self.content_of(place, meaning(&column), &column);
        content.map_err(|error| told(self.path, &error).column(column.path().string()))
    }

    fn content_of(
        &self,
        place: usize,
        meaning: Meaning,
        column: &ColumnDescriptor,
    ) -> Result<Content> {
        let mut content = match meaning {
            Meaning::Text => Content::Texts(Vec::new()),
            _ => Content::Numbers(Vec::new()),
        };
        // Of instants the first is zero: whole numbers of nanoseconds since 1970 are more than a number with a fraction holds.
        let mut first = None;
        let nullable = column.max_def_level();
        for group in 0..self.reader.num_row_groups() {
            let rows = self.reader.get_row_group(group)?;
            let wanted = rows.metadata().num_rows();
            let mut whole = |value: i64| match meaning {
                Meaning::Unsigned => value as u64 as f64,
                Meaning::Decimal(scale) => value as f64 / 10f64.powi(scale),
                Meaning::Instant(rate_hz) => {
                    value.wrapping_sub(*first.get_or_insert(value)) as f64 / rate_hz
                }
                _ => value as f64,
            };
            let before = content.len();
            match (rows.get_column_reader(place)?, &mut content) {
                (ColumnReader::BoolColumnReader(reader), Content::Numbers(into)) => {
                    numbers(reader, nullable, into, |value| f64::from(u8::from(*value)))?;
                }
                (ColumnReader::Int32ColumnReader(reader), Content::Numbers(into)) => {
                    match meaning {
                        Meaning::Unsigned => {
                            numbers(reader, nullable, into, |value| f64::from(*value as u32))?
                        }
                        _ => numbers(reader, nullable, into, |value| whole(i64::from(*value)))?,
                    }
                }
                (ColumnReader::Int64ColumnReader(reader), Content::Numbers(into)) => {
                    numbers(reader, nullable, into, |value| whole(*value))?;
                }
                (ColumnReader::FloatColumnReader(reader), Content::Numbers(into)) => {
                    numbers(reader, nullable, into, |value| f64::from(*value))?;
                }
                (ColumnReader::DoubleColumnReader(reader), Content::Numbers(into)) => {
                    numbers(reader, nullable, into, |value| *value)?;
                }
                (ColumnReader::ByteArrayColumnReader(reader), Content::Texts(into)) => {
                    each(reader, nullable, |value| into.push(value.cloned()))?;
                }
                _ => return Err(ParquetError::General("neither numbers nor text".into())),
            }
            if (content.len() - before) as i64 != wanted {
                let found = content.len() - before;
                return Err(ParquetError::General(format!("{found} values of {wanted}")));
            }
        }
        Ok(content)
    }
}

impl Content {
    pub(crate) fn len(&self) -> usize {
        match self {
            Self::Numbers(numbers) => numbers.len(),
            Self::Texts(texts) => texts.len(),
        }
    }

    /// True without a single value.
    pub(crate) fn is_nothing(&self) -> bool {
        match self {
            Self::Numbers(numbers) => numbers.iter().all(|number| number.is_nan()),
            Self::Texts(texts) => texts.iter().all(Option::is_none),
        }
    }
}

/// What a column's values mean, by its type.
fn meaning(column: &ColumnDescriptor) -> Meaning {
    if column.max_rep_level() > 0 {
        return Meaning::Other;
    }
    let per_second = |unit: &TimeUnit| match unit {
        TimeUnit::MILLIS => 1.0e3,
        TimeUnit::MICROS => 1.0e6,
        TimeUnit::NANOS => 1.0e9,
    };
    let physical = column.physical_type();
    match column.logical_type_ref() {
        Some(LogicalType::Timestamp(of)) => return Meaning::Instant(per_second(&of.unit)),
        Some(LogicalType::Time(of)) => return Meaning::Instant(per_second(&of.unit)),
        Some(LogicalType::Decimal(of)) if matches!(physical, Physical::INT32 | Physical::INT64) => {
            return Meaning::Decimal(of.scale);
        }
        Some(LogicalType::Integer(of)) if !of.is_signed => return Meaning::Unsigned,
        Some(LogicalType::Date | LogicalType::Decimal(_)) => return Meaning::Other,
        _ => {}
    }
    match (column.converted_type(), physical) {
        (ConvertedType::TIMESTAMP_MILLIS | ConvertedType::TIME_MILLIS, _) => {
            Meaning::Instant(1.0e3)
        }
        (ConvertedType::TIMESTAMP_MICROS | ConvertedType::TIME_MICROS, _) => {
            Meaning::Instant(1.0e6)
        }
        (ConvertedType::DATE | ConvertedType::INTERVAL | ConvertedType::DECIMAL, _) => {
            Meaning::Other
        }
        (_, Physical::BYTE_ARRAY) => Meaning::Text,
        (_, Physical::INT96 | Physical::FIXED_LEN_BYTE_ARRAY) => Meaning::Other,
        _ => Meaning::Number,
    }
}

fn numbers<T: DataType>(
    reader: ColumnReaderImpl<T>,
    nullable: i16,
    into: &mut Vec<f64>,
    mut number: impl FnMut(&T::T) -> f64,
) -> Result<()> {
    each(reader, nullable, |value| {
        into.push(value.map_or(f64::NAN, &mut number))
    })
}

/// Values that are read at once.
const BATCH: usize = 1 << 14;

/// Calls `take` for every row, with its value where there is one: where the level is `nullable`, or everywhere if that is 0.
fn each<T: DataType>(
    mut reader: ColumnReaderImpl<T>,
    nullable: i16,
    mut take: impl FnMut(Option<&T::T>),
) -> Result<()> {
    let (mut values, mut levels) = (Vec::with_capacity(BATCH), Vec::with_capacity(BATCH));
    loop {
        values.clear();
        levels.clear();
        let into = (nullable > 0).then_some(&mut levels);
        let (records, _, _) = reader.read_records(BATCH, into, None, &mut values)?;
        if records == 0 {
            return Ok(());
        }
        let mut there = values.iter();
        match nullable {
            0 => there.for_each(|value| take(Some(value))),
            most => levels
                .iter()
                .for_each(|level| take((*level == most).then(|| there.next()).flatten())),
        }
    }
}
