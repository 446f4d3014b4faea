//! Tables of answers for other programs: any columns, whose types do not depend on their values.

use crate::schema::Stored;
use crate::write::write_columns;
use recording::Error;
use std::path::Path;

/// A column of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Its name.
    pub name: String,
    /// A value or none a row.
    pub values: Values,
}

/// Values of a column, by type. Each may be none.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// `BYTE_ARRAY`, UTF-8.
    Texts(Vec<Option<String>>),
    /// `DOUBLE`.
    Reals(Vec<Option<f64>>),
    /// `INT32`.
    Wholes(Vec<Option<i32>>),
}

/// Writes a table, and replaces what is there; the columns are of one length.
///
/// # Errors
/// A failure to write; nothing is left behind.
pub fn write(path: &Path, columns: &[Column]) -> Result<(), Error> {
    let rows = columns.first().map_or(0, |column| match &column.values {
        Values::Texts(values) => values.len(),
        Values::Reals(values) => values.len(),
        Values::Wholes(values) => values.len(),
    });
    let stored: Vec<Stored> = columns
        .iter()
        .map(|column| match &column.values {
            Values::Texts(values) => Stored::optional_texts(&column.name, values),
            Values::Reals(values) => Stored::optional_reals(&column.name, values),
            Values::Wholes(values) => Stored::optional_wholes(&column.name, values),
        })
        .collect();
    write_columns(path, "table", &stored, rows, &[], true)
}
