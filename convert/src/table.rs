//! The table of a log: its columns as numbers, with the lines that they stand on.

use crate::dialect::{Dialect, Separator, comment, number, plain, recognise};
use recording::Error;
use std::path::Path;

/// Words that stand for a value that was not measured.
const NOT_MEASURED: [&str; 8] = ["", "nan", "na", "n/a", "null", "none", "-", "--"];

/// How the output of a sensor is recorded, to be put behind what is wanted.
#[must_use]
pub fn told_how(how_to_record: &str) -> String {
    format!("; to record the sensor's output where it is missing: {how_to_record}")
}

/// One column.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LogColumn {
    /// Name in the header; `#3` without one.
    pub name: String,
    /// What a row of units below the header says.
    pub unit: Option<String>,
    /// A number a row; NaN where the field is empty or holds a word.
    pub numbers: Vec<f64>,
    /// Words, each with its row's index, in order.
    pub words: Vec<(usize, String)>,
    /// What it can be in a recording, as `--column` says it, where its program tells.
    pub hint: Option<String>,
    /// What a user of this column must know, one sentence.
    pub note: Option<String>,
}

/// A whole log.
#[derive(Clone, Debug, PartialEq)]
pub struct Log {
    /// How it is written.
    pub dialect: Dialect,
    /// Its columns, those without a name and without a value left out.
    pub columns: Vec<LogColumn>,
    /// Line of the file on which each row stands.
    pub lines: Vec<u64>,
    /// True if the last row was cut short and left out.
    pub cut_short: bool,
    /// What it is, where it is no table of text.
    pub form: &'static str,
    /// What was done to read it, one sentence each.
    pub notes: Vec<String>,
    /// Why it has no times and what to do, where its program keeps none.
    pub no_time: Option<&'static str>,
    /// How the output of a sensor is recorded with its program, where that is known.
    pub how_to_record: Option<&'static str>,
}

impl Log {
    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.lines.len()
    }

    /// A log of whole columns, all of one length, from a file that is no text; rows count from 1.
    #[must_use]
    pub fn of_columns(columns: Vec<LogColumn>) -> Self {
        let rows = columns.first().map_or(0, |column| column.numbers.len());
        Self {
            dialect: Dialect::of_columns(columns.len()),
            columns,
            lines: (1..=rows as u64).collect(),
            cut_short: false,
            form: "a file of columns",
            notes: Vec::new(),
            no_time: None,
            how_to_record: None,
        }
    }

    /// The log, if anything is in it.
    ///
    /// # Errors
    /// There is no row.
    pub fn with_rows(self, file: &Path) -> Result<Self, Error> {
        if self.rows() == 0 {
            let wanted = format!("a log with rows{}", self.told_how());
            return Err(Error::new(file, "no rows of numbers or words", wanted));
        }
        Ok(self)
    }

    /// How the output of a sensor is recorded, to be put behind what is wanted; nothing where that is not known.
    #[must_use]
    pub fn told_how(&self) -> String {
        self.how_to_record.map(told_how).unwrap_or_default()
    }

    /// Reads a log.
    ///
    /// # Errors
    /// No table is found in it, or a row has more or fewer fields than the others.
    pub fn read(file: &Path, text: &str) -> Result<Self, Error> {
        let dialect = recognise(text).ok_or_else(|| {
            let found = match text.trim().is_empty() {
                true => "an empty file",
                false => "no table of numbers",
            };
            let wanted =
                "rows of numbers under a header, separated by commas, semicolons, tabs or blanks";
            Error::new(file, found, wanted)
        })?;
        let start: usize = text
            .split_inclusive('\n')
            .take(dialect.data_line - 1)
            .map(str::len)
            .sum();
        let body = &text[start..];
        let tabbed;
        let body = match dialect.separator {
            Separator::Blanks => {
                tabbed = with_tabs(body);
                tabbed.as_str()
            }
            _ => body,
        };
        let mut log = Self {
            columns: columns(&dialect),
            lines: Vec::new(),
            cut_short: false,
            form: "",
            notes: Vec::new(),
            no_time: None,
            how_to_record: None,
            dialect,
        };
        log.read_rows(file, body, text.ends_with(['\n', '\r']))?;
        let nothing = |column: &LogColumn| {
            column.words.is_empty() && column.numbers.iter().all(|number| number.is_nan())
        };
        log.columns
            .retain(|column| !(column.name.is_empty() && nothing(column)));
        for (place, column) in log.columns.iter_mut().enumerate() {
            if column.name.is_empty() {
                column.name = format!("#{}", place + 1);
            }
        }
        Ok(log)
    }

    fn read_rows(&mut self, file: &Path, body: &str, ended: bool) -> Result<(), Error> {
        let mut reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .delimiter(self.dialect.separator.byte())
            .from_reader(body.as_bytes());
        let mut row = csv::StringRecord::new();
        loop {
            // Text in memory that is UTF-8, rows of any length: there is nothing to fail.
            let more = reader.read_record(&mut row).unwrap_or(false);
            if !more {
                return Ok(());
            }
            let line =
                self.dialect.data_line as u64 - 1 + row.position().map_or(1, csv::Position::line);
            if row.get(0).is_some_and(|first| comment(first).is_some())
                || row.iter().all(|field| field.trim().is_empty())
            {
                continue;
            }
            if row.len() < self.dialect.width
                && !ended
                && reader.position().byte() as usize >= body.len()
            {
                self.cut_short = true;
                return Ok(());
            }
            self.push(file, &row, line)?;
        }
    }

    fn push(&mut self, file: &Path, row: &csv::StringRecord, line: u64) -> Result<(), Error> {
        let width = self.dialect.width;
        let over = row.iter().skip(width).any(|field| !field.trim().is_empty());
        if row.len() < width || over {
            let found = format!("{} fields", row.len());
            return Err(Error::new(file, found, format!("{width} as in the other rows")).row(line));
        }
        let index = self.lines.len();
        for (column, field) in self.columns.iter_mut().zip(row) {
            let field = plain(field, self.dialect.separator);
            let value = number(field, self.dialect.decimal_comma);
            column.numbers.push(value.unwrap_or(f64::NAN));
            if value.is_none() && !NOT_MEASURED.contains(&field.to_ascii_lowercase().as_str()) {
                column.words.push((index, field.to_owned()));
            }
        }
        self.lines.push(line);
        Ok(())
    }
}

fn columns(dialect: &Dialect) -> Vec<LogColumn> {
    let of = |rows: &Option<Vec<String>>, place: usize| rows.as_ref().map(|row| row[place].clone());
    (0..dialect.width)
        .map(|place| LogColumn {
            name: of(&dialect.names, place).unwrap_or_else(|| format!("#{}", place + 1)),
            unit: of(&dialect.units, place).filter(|unit| !unit.is_empty()),
            ..LogColumn::default()
        })
        .collect()
}

/// Each line's words with one tab between them; as many lines as before.
fn with_tabs(text: &str) -> String {
    let mut tabbed = String::with_capacity(text.len());
    for line in text.lines() {
        for (place, word) in line.split_whitespace().enumerate() {
            if place > 0 {
                tabbed.push('\t');
            }
            tabbed.push_str(word);
        }
        tabbed.push('\n');
    }
    tabbed
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Log, String> {
        Log::read(Path::new("log.csv"), text).map_err(|error| error.to_string())
    }

    #[test]
    fn columns_words_and_lines() {
        let log = read("note\n\nt;a;mode\n0;1;up\n\n# pause\n1;nan;down\n2;;3\n").unwrap();
        assert_eq!(log.lines, [4, 7, 8]);
        assert_eq!(log.columns[1].numbers[0], 1.0);
        assert!(log.columns[1].numbers[1].is_nan() && log.columns[1].words.is_empty());
        assert_eq!(log.columns[2].words, [(0, "up".into()), (1, "down".into())]);
    }

    /// A row of a matrix as MATLAB writes it ends with a semicolon.
    #[test]
    fn what_ends_a_row_is_no_word() {
        let log = read("t,a\n0,1;\nnan,nan;\n1,2;\n").unwrap();
        assert!(log.columns.iter().all(|column| column.words.is_empty()));
        assert_eq!([0, 2].map(|row| log.columns[1].numbers[row]), [1.0, 2.0]);
        assert!(log.columns[1].numbers[1].is_nan());
    }

    #[test]
    fn ragged_rows_are_refused_and_a_cut_last_one_is_left_out() {
        let error = read("t,a\n0,1\n1\n2,3\n").unwrap_err();
        assert_eq!(
            error,
            "log.csv: row 3, found 1 fields, wanted 2 as in the other rows"
        );
        let log = read("t,a,b\n0,1,1\n1,2,2\n2,").unwrap();
        assert!(log.cut_short && log.rows() == 2);
        assert!(read("").unwrap_err().contains("an empty file"));
        assert!(
            read("hello\nworld\n")
                .unwrap_err()
                .contains("no table of numbers")
        );
    }
}
