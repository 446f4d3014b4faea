//! How a column of numbers is stored: its physical type, its encoding and its codec.

use crate::decimal;
use parquet::basic::{Compression, Encoding, LogicalType, Repetition, Type as Physical, ZstdLevel};
use parquet::errors::Result;
use parquet::file::properties::{EnabledStatistics, WriterProperties, WriterPropertiesBuilder};
use parquet::schema::types::{ColumnPath, Type, TypePtr};
use std::collections::HashSet;
use std::sync::Arc;

/// Columns of fewer distinct numbers are stored as places in a list of them: a byte or less a sample, then runs.
const LISTED: usize = 256;

/// A codec that everything reads; its work is the runs that the encodings leave.
const CODEC: Compression = Compression::SNAPPY;

/// Values of one column.
#[derive(Clone)]
pub(crate) enum Values<'a> {
    /// Whole numbers of 32 bits, without those that were not measured.
    Whole(Vec<i32>),
    /// Any numbers, without those that were not measured.
    Real(Vec<f64>),
    /// Whole numbers of so many powers of ten less, without those that were not measured.
    Decimal(Vec<i64>, i32),
    /// Texts, one a row.
    Text(Vec<&'a str>),
}

/// A column as it is stored.
#[derive(Clone)]
pub(crate) struct Stored<'a> {
    pub(crate) name: String,
    pub(crate) values: Values<'a>,
    /// For each row 1 where there is a value and 0 where not; none where each row has one.
    pub(crate) levels: Option<Vec<i16>>,
    encoding: Encoding,
    codec: Compression,
}

impl<'a> Stored<'a> {
    /// A column of numbers, NaN where there is none. Whole ones differ little from row to row, and their differences are stored; of
    /// others the first bytes differ little, and these are stored together.
    pub(crate) fn numbers(name: &str, values: &[f64]) -> Self {
        let there = values.iter().filter(|value| !value.is_nan()).count();
        let levels = (there < values.len()).then(|| {
            values
                .iter()
                .map(|value| i16::from(!value.is_nan()))
                .collect()
        });
        let measured = || values.iter().copied().filter(|value| !value.is_nan());
        let (values, encoding) = if measured().all(is_whole) {
            let whole = measured().map(|value| value as i32).collect();
            (Values::Whole(whole), Encoding::DELTA_BINARY_PACKED)
        } else if few(measured()) {
            (Values::Real(measured().collect()), Encoding::RLE_DICTIONARY)
        } else {
            let real = measured().collect();
            (Values::Real(real), Encoding::BYTE_STREAM_SPLIT)
        };
        Self {
            name: name.to_owned(),
            values,
            levels,
            encoding,
            codec: CODEC,
        }
    }

    /// As [`Stored::numbers`], stored as numbers with a fraction whatever they are.
    pub(crate) fn reals(name: &str, values: &[f64]) -> Self {
        let mut stored = Self::numbers(name, values);
        if let Values::Whole(whole) = &stored.values {
            stored.values = Values::Real(whole.iter().copied().map(f64::from).collect());
            stored.encoding = Encoding::BYTE_STREAM_SPLIT;
        }
        stored
    }

    /// The same as decimals, where these give numbers of many digits back bit for bit.
    pub(crate) fn decimal(self) -> Self {
        let Values::Real(real) = &self.values else {
            return self;
        };
        match decimal::decimals(real) {
            Some((numbers, scale)) if self.encoding == Encoding::BYTE_STREAM_SPLIT => Self {
                values: Values::Decimal(numbers, scale),
                encoding: Encoding::DELTA_BINARY_PACKED,
                ..self
            },
            _ => self,
        }
    }

    /// The encodings that the format has for such values, by the codec that takes the least place of those that are as quick.
    pub(crate) fn ways(self) -> Vec<Self> {
        let encodings: &[Encoding] = match self.values {
            Values::Whole(_) | Values::Decimal(..) => &[
                Encoding::DELTA_BINARY_PACKED,
                Encoding::BYTE_STREAM_SPLIT,
                Encoding::RLE_DICTIONARY,
            ],
            Values::Real(_) => &[Encoding::BYTE_STREAM_SPLIT, Encoding::RLE_DICTIONARY],
            Values::Text(_) => &[Encoding::RLE_DICTIONARY],
        };
        let codec = Compression::ZSTD(ZstdLevel::default());
        let way = |encoding: &Encoding| Self {
            encoding: *encoding,
            codec,
            ..self.clone()
        };
        encodings.iter().map(way).collect()
    }

    /// A column of texts, one a row.
    pub(crate) fn texts(name: &str, values: Vec<&'a str>) -> Self {
        Self {
            name: name.to_owned(),
            values: Values::Text(values),
            levels: None,
            encoding: Encoding::RLE_DICTIONARY,
            codec: CODEC,
        }
    }

    /// Texts or none, whatever they are: so for all of these, the type does not depend on the values.
    pub(crate) fn optional_texts(name: &str, values: &'a [Option<String>]) -> Self {
        let there = values.iter().flatten().map(String::as_str).collect();
        Self::optional(
            name,
            Values::Text(there),
            levels(values),
            Encoding::RLE_DICTIONARY,
        )
    }

    /// Numbers or none.
    pub(crate) fn optional_reals(name: &str, values: &[Option<f64>]) -> Self {
        let there = values.iter().copied().flatten().collect();
        Self::optional(
            name,
            Values::Real(there),
            levels(values),
            Encoding::BYTE_STREAM_SPLIT,
        )
    }

    /// Whole numbers or none.
    pub(crate) fn optional_wholes(name: &str, values: &[Option<i32>]) -> Self {
        let there = values.iter().copied().flatten().collect();
        Self::optional(
            name,
            Values::Whole(there),
            levels(values),
            Encoding::DELTA_BINARY_PACKED,
        )
    }

    fn optional(name: &str, values: Values<'a>, levels: Vec<i16>, encoding: Encoding) -> Self {
        Self {
            name: name.to_owned(),
            values,
            levels: Some(levels),
            encoding,
            codec: CODEC,
        }
    }

    fn field(&self) -> Result<TypePtr> {
        let (physical, logical) = match self.values {
            Values::Whole(_) => (Physical::INT32, None),
            Values::Real(_) => (Physical::DOUBLE, None),
            Values::Decimal(_, scale) => (
                Physical::INT64,
                Some(LogicalType::decimal(scale, decimal::PRECISION)),
            ),
            Values::Text(_) => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
        };
        let repetition = match self.levels {
            Some(_) => Repetition::OPTIONAL,
            None => Repetition::REQUIRED,
        };
        let field = Type::primitive_type_builder(&self.name, physical)
            .with_repetition(repetition)
            .with_logical_type(logical.clone());
        let field = match logical {
            Some(LogicalType::Decimal(of)) => {
                field.with_scale(of.scale).with_precision(of.precision)
            }
            _ => field,
        };
        Ok(Arc::new(field.build()?))
    }

    fn properties(&self, builder: WriterPropertiesBuilder) -> WriterPropertiesBuilder {
        let path = ColumnPath::from(self.name.as_str());
        let builder = builder.set_column_compression(path.clone(), self.codec);
        match self.encoding {
            Encoding::RLE_DICTIONARY => builder.set_column_dictionary_enabled(path, true),
            encoding => builder
                .set_column_dictionary_enabled(path.clone(), false)
                .set_column_encoding(path, encoding),
        }
    }
}

/// For each row 1 where there is a value and 0 where not.
fn levels<T>(values: &[Option<T>]) -> Vec<i16> {
    values
        .iter()
        .map(|value| i16::from(value.is_some()))
        .collect()
}

/// True of a number that 32 bits hold and give back bit for bit: not of minus zero.
fn is_whole(value: f64) -> bool {
    f64::from(value as i32).to_bits() == value.to_bits()
}

/// True if the numbers are few that recur.
fn few(mut values: impl Iterator<Item = f64>) -> bool {
    let mut distinct = HashSet::new();
    values.all(|value| {
        distinct.insert(value.to_bits());
        distinct.len() <= LISTED
    })
}

/// The type of a file with these columns.
pub(crate) fn schema(name: &str, columns: &[Stored]) -> Result<TypePtr> {
    let fields: Result<Vec<TypePtr>> = columns.iter().map(Stored::field).collect();
    let group = Type::group_type_builder(name).with_fields(fields?);
    Ok(Arc::new(group.build()?))
}

/// How the columns are written.
pub(crate) fn properties(columns: &[Stored]) -> WriterProperties {
    let builder = WriterProperties::builder()
        .set_created_by(concat!("courier ", env!("CARGO_PKG_VERSION")).to_owned())
        .set_statistics_enabled(EnabledStatistics::Chunk);
    let each = |builder, column: &Stored| column.properties(builder);
    columns.iter().fold(builder, each).build()
}
