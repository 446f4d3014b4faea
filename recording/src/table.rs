//! A recording from whole columns: how forms other than the folder are read.

use crate::column::{Column, CountLimits, is_logged};
use crate::error::{Error, excerpt, one_line};
use crate::foreign::warn_of_unknown;
use crate::layout::META_FILE;
use crate::meta::Meta;
use crate::recording::Recording;
use crate::samples::{Logged, Samples};
use crate::together::lack;
use std::path::Path;

/// What another form than the folder holds, before any check.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// Text of a `recording.toml`.
    pub meta: String,
    /// Columns of numbers by their names, all of one length; NaN is not measured.
    pub columns: Vec<(String, Vec<f64>)>,
    /// Names of the motions in order, each with its number of samples; samples without one come last.
    pub runs: Vec<(String, usize)>,
    /// Names of columns that were not read, since the layout does not know them.
    pub left_aside: Vec<String>,
}

impl Table {
    /// True for the name of a column that [`Recording::of_table`] takes: the layout's, those that begin with `aux_`, and `run`.
    #[must_use]
    pub fn takes(name: &str) -> bool {
        name == "run" || Column::by_name(name).is_some() || is_logged(name)
    }
}

impl Recording {
    /// Checks what `file` holds as [`Recording::read`] checks a folder; the first sample is row 1.
    ///
    /// # Errors
    /// One [`Error`] for the first thing that is wrong, naming file, row and column.
    pub fn of_table(file: &Path, table: Table) -> Result<Self, Error> {
        let mut warnings = Vec::new();
        let meta_file = file.join(META_FILE);
        let meta = Meta::parse(&meta_file, &table.meta, &mut warnings)?;
        let name = file.file_name().unwrap_or(file.as_os_str());
        let name = one_line(&name.to_string_lossy(), 60);
        warn_of_unknown(&name, &table.left_aside, &mut warnings);
        let known = |column: Column| table.columns.iter().any(|(name, _)| *name == column.name());
        if let Some(lack) = lack(known) {
            let error = Error::new(file, lack.found, lack.wanted);
            return Err(match lack.column {
                Some(column) => error.column(column.name()),
                None => error,
            });
        }
        let samples = samples(file, &name, table, meta.count_limits(), &mut warnings)?;
        meta.check_against(&meta_file, &samples)?;
        Ok(Self {
            meta,
            samples,
            warnings,
        })
    }
}

fn samples(
    file: &Path,
    told: &str,
    table: Table,
    limits: CountLimits,
    warnings: &mut Vec<String>,
) -> Result<Samples, Error> {
    let rows = table.columns.first().map_or(0, |(_, values)| values.len());
    if rows == 0 {
        return Err(Error::new(file, "no samples", "at least one row"));
    }
    let mut samples = Samples::of_runs(rows, &table.runs);
    for (name, values) in table.columns {
        if values.len() != rows {
            let found = format!("{} values", values.len());
            let wanted = format!("{rows} as in the first column");
            return Err(Error::new(file, found, wanted).column(name));
        }
        match Column::by_name(&name) {
            Some(column) => {
                check(file, column, &values, &limits)?;
                let broken = |value: &f64| column.is_count() && value.fract() != 0.0;
                if let Some(row) = values.iter().position(|v| !v.is_nan() && broken(v)) {
                    let row = row + 1;
                    warnings.push(format!(
                        "{told}: column {name} holds counts that are not whole, first in row {row}"
                    ));
                }
                samples.set_column(column, values);
            }
            None => {
                if let Some(row) = values.iter().position(|value| value.is_infinite()) {
                    let error = Error::new(file, values[row].to_string(), "a finite number");
                    return Err(error.row(1 + row as u64).column(name));
                }
                samples.log(Logged { name, values });
            }
        }
    }
    if !(0..4).any(|segment| samples.has_segment(segment)) {
        let wanted = "counts with their tooth count, or positions";
        return Err(Error::new(file, "no output of any segment", wanted));
    }
    Ok(samples)
}

/// Every value of one column, as the reader of `samples.csv` checks it.
fn check(file: &Path, column: Column, values: &[f64], limits: &CountLimits) -> Result<(), Error> {
    let mut last_time_s = f64::NEG_INFINITY;
    for (row, value) in values.iter().enumerate() {
        let refuse = |found: String, wanted: String| {
            let error = Error::new(file, found, wanted);
            Err(error.row(1 + row as u64).column(column.name()))
        };
        let is_time = column == Column::Time;
        if value.is_nan() {
            if is_time {
                return refuse("nothing".into(), "a time in every row, s".into());
            }
            continue;
        }
        if let Err(wanted) = column.check(*value, limits) {
            return refuse(excerpt(value.to_string().as_bytes()), wanted);
        }
        if is_time {
            if *value <= last_time_s {
                let wanted = format!("a time after the row before, {last_time_s} s");
                return refuse(excerpt(value.to_string().as_bytes()), wanted);
            }
            last_time_s = *value;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const META: &str =
        "schema = 1\n[geometry]\npitch_m = 1e-3\n[electronics]\nposition_noise_m = 1e-8\n";

    fn table(columns: &[(&str, &[f64])]) -> Table {
        Table {
            meta: META.into(),
            columns: columns
                .iter()
                .map(|(name, values)| ((*name).to_owned(), values.to_vec()))
                .collect(),
            ..Table::default()
        }
    }

    fn told(table: Table) -> String {
        let read = Recording::of_table(Path::new("a.parquet"), table);
        read.map_or_else(|error| error.to_string(), |read| read.warnings.join("; "))
    }

    #[test]
    fn columns_become_rows_with_their_runs() {
        let mut given = table(&[
            ("t_s", &[0.0, 1.0, 2.0]),
            ("p1_m", &[1.0e-3, f64::NAN, 3.0e-3]),
            ("aux_drive_a", &[f64::NAN, 2.0, f64::NAN]),
        ]);
        given.runs = vec![("there".into(), 1), ("back".into(), 1)];
        let read = Recording::of_table(Path::new("a.parquet"), given).unwrap();
        let runs: Vec<&str> = (0..3).map(|row| read.samples.run(row)).collect();
        assert_eq!(runs, ["there", "back", ""]);
        assert_eq!(read.samples.row(1).position_m[0], None);
        assert_eq!(read.samples.row(2).position_m[0], Some(3.0e-3));
        assert_eq!(read.samples.logged()[0].values[1], 2.0);
        assert_eq!(read.warnings, [""; 0]);
    }

    #[test]
    fn what_is_wrong_is_told_by_file_row_and_column() {
        for (given, wanted) in [
            (
                table(&[("p1_m", &[0.0])]),
                "a.parquet: column t_s, found none, wanted the column of time, s",
            ),
            (
                table(&[("t_s", &[0.0, 1.0, 1.0]), ("p1_m", &[0.0; 3])]),
                "a.parquet: row 3, column t_s, found \"1\", wanted a time after the row before, 1 s",
            ),
            (
                table(&[("t_s", &[0.0, f64::NAN]), ("p1_m", &[0.0; 2])]),
                "a.parquet: row 2, column t_s, found nothing, wanted a time in every row, s",
            ),
            (
                table(&[("t_s", &[0.0]), ("p1_m", &[f64::INFINITY])]),
                "a.parquet: row 1, column p1_m, found \"inf\", wanted a finite number",
            ),
            (
                table(&[("t_s", &[0.0]), ("p1_m", &[f64::NAN])]),
                "a.parquet: found no output of any segment, wanted counts with their tooth count, or positions",
            ),
            (
                table(&[("t_s", &[0.0]), ("q1s", &[1.0]), ("q1c", &[1.0])]),
                "a.parquet: column n1, found none, wanted it beside the segment's other columns of counts",
            ),
            (
                table(&[
                    ("t_s", &[0.0]),
                    ("q1s", &[0.5]),
                    ("q1c", &[1.0]),
                    ("n1", &[0.0]),
                ]),
                "a.parquet/recording.toml: key [electronics] adc_bits, found none, wanted a number, since quadrature counts were recorded",
            ),
            (
                table(&[("t_s", &[]), ("p1_m", &[])]),
                "a.parquet: found no samples, wanted at least one row",
            ),
            (
                table(&[("t_s", &[0.0]), ("p1_m", &[])]),
                "a.parquet: column p1_m, found 0 values, wanted 1 as in the first column",
            ),
        ] {
            assert_eq!(told(given), wanted);
        }
    }

    #[test]
    fn unknown_columns_are_named() {
        let mut given = table(&[("t_s", &[0.0]), ("p1_m", &[0.0])]);
        given.left_aside = vec!["note".into()];
        assert_eq!(
            told(given),
            "a.parquet: column \"note\" is not known and is left aside"
        );
    }
}
