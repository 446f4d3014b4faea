//! In which dialect a table is written: what separates its columns, its decimal mark, and where header and data begin.

use std::fmt;

/// What stands between two fields of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Separator {
    /// `,`
    Comma,
    /// `;`
    Semicolon,
    /// A tab.
    Tab,
    /// Any number of blanks.
    Blanks,
    /// Nothing: the file is no text, and holds whole columns.
    None,
}

impl Separator {
    /// The byte that separates; rows separated by blanks are written with tabs first.
    #[must_use]
    pub fn byte(self) -> u8 {
        match self {
            Self::Comma | Self::None => b',',
            Self::Semicolon => b';',
            Self::Tab | Self::Blanks => b'\t',
        }
    }
}

impl fmt::Display for Separator {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Comma => "commas",
            Self::Semicolon => "semicolons",
            Self::Tab => "tabs",
            Self::Blanks => "blanks",
            Self::None => "nothing",
        })
    }
}

/// How a table is written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Dialect {
    /// What separates the fields.
    pub separator: Separator,
    /// True where numbers are written as `1,5`.
    pub decimal_comma: bool,
    /// Fields of a row of data.
    pub width: usize,
    /// Names of the columns, `[width]`; none where the file has no header.
    pub names: Option<Vec<String>>,
    /// Units of the columns, `[width]`, where a row of them follows the header.
    pub units: Option<Vec<String>>,
    /// Line of the header, the first line of the file being 1; 0 without one.
    pub header_line: usize,
    /// Line on which the data begin.
    pub data_line: usize,
    /// Lines before the header that are neither names nor units.
    pub preamble: usize,
}

impl Dialect {
    /// Of a file that holds so many whole columns.
    pub(crate) fn of_columns(width: usize) -> Self {
        Self {
            separator: Separator::None,
            decimal_comma: false,
            width,
            names: None,
            units: None,
            header_line: 0,
            data_line: 1,
            preamble: 0,
        }
    }
}

/// Lines that are looked at: more than any logger writes before its data.
const LOOKED_AT: usize = 400;
/// Of these, the last so many tell how a row of data is written.
const BODY: usize = 100;

/// Recognises the dialect of a text; none where no line of it holds two fields with a number among them.
#[must_use]
pub fn recognise(text: &str) -> Option<Dialect> {
    let lines: Vec<&str> = text.lines().take(LOOKED_AT).collect();
    let body: Vec<&str> = lines
        .iter()
        .copied()
        .filter(|line| !line.trim().is_empty() && comment(line).is_none())
        .collect();
    let body = &body[body.len().saturating_sub(BODY)..];
    let separator = separator(body)?;
    let rows: Vec<Vec<String>> = body.iter().map(|line| fields(line, separator)).collect();
    let decimal_comma = decimal_comma(&rows, separator);
    let width = usual(rows.iter().map(Vec::len))?;
    let is_data = |line: &str| {
        comment(line).is_none() && {
            let row = fields(line, separator);
            row.len() == width
                && row
                    .iter()
                    .any(|field| number(field, decimal_comma).is_some())
        }
    };
    let first = lines.iter().position(|line| is_data(line))?;
    let above = rows_above(&lines[..first], separator, width);
    let header = match above[..] {
        [] => None,
        [header] | [header, _] => Some(header),
        // More than a header and units: what stands directly over the numbers are the names.
        [.., header] => Some(header),
    };
    let named = |line: usize| padded(fields(uncommented(lines[line]), separator), width);
    let units = match above[..] {
        [_, units] => Some(named(units).iter().map(|unit| bare(unit)).collect()),
        _ => None,
    };
    Some(Dialect {
        separator,
        decimal_comma,
        width,
        names: header.map(named),
        header_line: header.map_or(0, |line| line + 1),
        data_line: first + 1,
        preamble: lines[..header.unwrap_or(first)]
            .iter()
            .filter(|line| !line.trim().is_empty())
            .count(),
        units,
    })
}

/// The lines directly above the data that have as many fields as these, from above; one field less where each row of data ends
/// with a separator. A line that begins with `#` is one of them only where no other line is, and of those the last, with the one before it where
/// all of the last stands in brackets, as units do.
fn rows_above(lines: &[&str], separator: Separator, width: usize) -> Vec<usize> {
    let wide = |line: &str| {
        let fields = fields(uncommented(line), separator);
        let named = fields.iter().filter(|field| !field.is_empty()).count();
        2 * named > width && (fields.len() == width || fields.len() + 1 == width)
    };
    let directly = |wanted: &dyn Fn(&str) -> bool| {
        let mut above = Vec::new();
        for (place, line) in lines.iter().enumerate().rev() {
            if line.trim().is_empty() && above.is_empty() {
                continue;
            }
            if !wanted(line) {
                break;
            }
            above.insert(0, place);
        }
        above
    };
    let plain = directly(&|line| comment(line).is_none() && wide(line));
    if !plain.is_empty() {
        return plain;
    }
    let commented = directly(&|line| comment(line).is_some() && wide(line));
    let in_brackets = |line: &usize| {
        let units = fields(uncommented(lines[*line]), separator);
        units.iter().all(|unit| bare(unit).len() < unit.len())
    };
    let count = 1 + usize::from(commented.last().is_some_and(in_brackets));
    commented[commented.len().saturating_sub(count)..].to_vec()
}

/// A unit without the brackets that it stands in.
fn bare(unit: &str) -> String {
    let within = |open, close| unit.strip_prefix(open)?.strip_suffix(close);
    within('[', ']')
        .or_else(|| within('(', ')'))
        .unwrap_or(unit)
        .to_owned()
}

/// A field without the blanks around it, and without the semicolon that ends each row of a matrix as MATLAB writes it.
#[must_use]
pub fn plain(field: &str, separator: Separator) -> &str {
    match separator {
        Separator::Semicolon => field.trim(),
        _ => field.trim_end_matches([';', ' ', '\t']).trim_start(),
    }
}

/// The separator that splits all of these lines into equally many fields, the most of them numbers; failing that, the one that
/// splits most lines.
fn separator(lines: &[&str]) -> Option<Separator> {
    let rows = |separator: Separator| lines.iter().map(move |line| fields(line, separator));
    let even = |separator: &Separator| {
        let mut widths = rows(*separator).map(|row| row.len());
        let first = widths.next().unwrap_or(0);
        first > 1 && widths.all(|width| width == first)
    };
    // Of `1,5 2,5` the comma makes three even fields, of which one is no number.
    let numbers = |separator: &Separator| {
        let all: Vec<String> = rows(*separator).flatten().collect();
        let known = all
            .iter()
            .filter(|field| number(field, true).is_some())
            .count();
        1000 * known / all.len().max(1)
    };
    let split = |separator: &Separator| rows(*separator).filter(|row| row.len() > 1).count();
    // Of equals the last is taken: the least likely inside a number or a name.
    let all = [
        Separator::Blanks,
        Separator::Comma,
        Separator::Tab,
        Separator::Semicolon,
    ];
    let found = all.into_iter().filter(even).max_by_key(numbers);
    found.or_else(|| all.into_iter().filter(|s| split(s) > 0).max_by_key(split))
}

/// True if numbers have a comma where others have a point.
fn decimal_comma(rows: &[Vec<String>], separator: Separator) -> bool {
    let (mut commas, mut points) = (0_usize, 0_usize);
    for field in rows.iter().flatten() {
        let plain = field.parse::<f64>().is_ok();
        points += usize::from(plain && field.contains('.'));
        commas += usize::from(!plain && number(field, true).is_some());
    }
    // Where commas separate, one inside a field was put in quotation marks.
    commas > points && (separator != Separator::Comma || commas > 0)
}

/// The number that a field holds; none of an empty field and of text.
#[must_use]
pub fn number(field: &str, decimal_comma: bool) -> Option<f64> {
    let field = field.trim();
    // `inf` and `nan` are words here.
    if !field.ends_with(|letter: char| letter.is_ascii_digit() || letter == '.') {
        return None;
    }
    match decimal_comma {
        true if field.matches(',').count() == 1 && !field.contains('.') => {
            field.replace(',', ".").parse().ok()
        }
        _ => field.parse().ok(),
    }
}

/// The fields of one line, without quotation marks and the blanks around them.
#[must_use]
pub fn fields(line: &str, separator: Separator) -> Vec<String> {
    let own = |field: &str| plain(field, separator).to_owned();
    if separator == Separator::Blanks {
        return line.split_whitespace().map(own).collect();
    }
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .delimiter(separator.byte())
        .from_reader(line.as_bytes());
    let row = reader.records().next().and_then(Result::ok);
    row.iter().flatten().map(own).collect()
}

/// What follows the mark of a line that begins with one of a comment.
#[must_use]
pub fn comment(line: &str) -> Option<&str> {
    let line = line.trim_start();
    line.strip_prefix('#').or_else(|| line.strip_prefix('%'))
}

fn uncommented(line: &str) -> &str {
    comment(line).map_or(line, |rest| {
        rest.trim_start_matches(['#', '%']).trim_start()
    })
}

fn padded(mut row: Vec<String>, width: usize) -> Vec<String> {
    row.resize(width, String::new());
    row
}

/// The commonest of some numbers, the larger of equally common ones.
fn usual(numbers: impl Iterator<Item = usize>) -> Option<usize> {
    let mut counts = std::collections::BTreeMap::new();
    numbers.for_each(|number| *counts.entry(number).or_insert(0_usize) += 1);
    counts
        .into_iter()
        .max_by_key(|(_, count)| *count)
        .map(|(number, _)| number)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Dialect {
        recognise(text).unwrap_or_else(|| panic!("{text:?}"))
    }

    #[test]
    fn separators_and_decimal_marks() {
        for (text, separator, decimal_comma) in [
            ("t,a\n0,1\n1,2\n", Separator::Comma, false),
            ("t;a\n0;1\n1;2\n", Separator::Semicolon, false),
            ("t;a\n0;1,5\n1;2,5\n", Separator::Semicolon, true),
            ("t\ta\n0\t1,5\n1\t2,5\n", Separator::Tab, true),
            ("t a\n0 1.5\n1   2\n", Separator::Blanks, false),
            ("t, a\n0, 1.5\n1, 2.5\n", Separator::Comma, false),
            ("t a\n0,5 1,5\n1,5 2,5\n", Separator::Blanks, true),
            (
                "t,a\n\"0,1\",\"1,5\"\n\"0,2\",\"2,5\"\n",
                Separator::Comma,
                true,
            ),
        ] {
            let dialect = of(text);
            assert_eq!(
                (dialect.separator, dialect.decimal_comma),
                (separator, decimal_comma),
                "{text:?}"
            );
            assert_eq!(dialect.names.unwrap().join("|"), "t|a", "{text:?}");
        }
    }

    #[test]
    fn headers_comments_units_and_preambles() {
        for (text, names, units, data_line) in [
            ("# t;a\n0;1\n", Some("t|a"), None, 2),
            ("# made; by hand\nt;a\n0;1\n", Some("t|a"), None, 3),
            ("% one\n%\n% t;a\n0;1\n", Some("t|a"), None, 4),
            (
                "Model;MSO\n\nt;a;\ns;V;\n0;1;2\n0;1;2\n",
                Some("t|a|"),
                Some("s|V|"),
                5,
            ),
            ("0;1\n1;2\n", None, None, 1),
            // As a logger of an ODrive writes for MATLAB.
            (
                "%Data\n%Date:,today\n\n%t,a\n%[s],[rad]\n0,1;\n1,2;\n",
                Some("t|a"),
                Some("s|rad"),
                6,
            ),
            ("logger 7\nt;a\n0;1\n1;2\n", Some("t|a"), None, 3),
            ("t;a\n0;1;\n1;2;\n", Some("t|a|"), None, 2),
        ] {
            let dialect = of(text);
            let joined = |row: &Option<Vec<String>>| row.as_ref().map(|row| row.join("|"));
            assert_eq!(joined(&dialect.names).as_deref(), names, "{text:?}");
            assert_eq!(joined(&dialect.units).as_deref(), units, "{text:?}");
            assert_eq!(dialect.data_line, data_line, "{text:?}");
        }
        for text in ["", "\n\n", "words\nalone\n", "a;b\nc;d\n"] {
            assert_eq!(recognise(text), None, "{text:?}");
        }
    }
}
