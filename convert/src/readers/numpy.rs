//! NumPy's `.npy`: a table with named columns, or rows and columns of one kind of number.
//!
//! The form is that of NumPy Enhancement Proposal 1: a mark, a version, a head that is a dictionary of Python's, the values.

use super::literal::Literal;
use crate::table::{Log, LogColumn};
use recording::Error;
use std::path::Path;

const MARK: &[u8] = b"\x93NUMPY";
/// How to have a table that is read, from whatever there is.
const WANTED: &str = "numbers in columns: numpy.save(FILE, TABLE) of one row a sample, with names (a structured array) or without";
/// How columns come into a file.
pub const HOW_TO_RECORD: &str =
    "numpy.savez(FILE, t=…, sin=…, cos=…), or numpy.savez(FILE, t=…, position=…)";
/// More columns than these are no table of columns.
const MOST_COLUMNS: usize = 1024;

/// True of a file that begins as such files do.
pub fn is_it(bytes: &[u8]) -> bool {
    bytes.starts_with(MARK)
}

/// The columns of a file.
///
/// # Errors
/// It is cut short, or holds no table.
pub fn read(file: &Path, bytes: &[u8]) -> Result<Log, Error> {
    let array = Array::parse(bytes).map_err(|found| Error::new(file, found, WANTED))?;
    let (columns, notes) = array
        .columns("")
        .map_err(|found| Error::new(file, found, WANTED))?;
    let mut log = Log::of_columns(columns);
    log.form = "a NumPy array";
    log.notes = notes;
    Ok(log)
}

/// What stands at one place of an element.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Real,
    Signed,
    Unsigned,
    /// Seconds that one step of a point in time is worth.
    Instant(f64),
    /// Text, complex numbers and all else.
    Other,
}

/// A column within an element.
struct Field {
    name: String,
    kind: Kind,
    /// Where it begins, bytes.
    at: usize,
    size: usize,
    big: bool,
}

/// An array and its bytes.
pub struct Array<'a> {
    fields: Vec<Field>,
    named: bool,
    shape: Vec<usize>,
    fortran: bool,
    size: usize,
    data: &'a [u8],
}

impl<'a> Array<'a> {
    /// Takes a file apart.
    ///
    /// # Errors
    /// What was found instead, in words.
    pub fn parse(bytes: &'a [u8]) -> Result<Self, String> {
        let cut = || "a NumPy file that is cut short".to_owned();
        let word = |at: usize, size: usize| {
            let bytes = bytes.get(at..at + size)?;
            Some(
                bytes
                    .iter()
                    .rev()
                    .fold(0, |sum, byte| sum << 8 | usize::from(*byte)),
            )
        };
        let (length, begin) = match bytes.get(6) {
            Some(1) => (word(8, 2).ok_or_else(cut)?, 10),
            Some(2 | 3) => (word(8, 4).ok_or_else(cut)?, 12),
            Some(version) => return Err(format!("a NumPy file of version {version}")),
            None => return Err(cut()),
        };
        let head = bytes.get(begin..begin + length).ok_or_else(cut)?;
        let head = Literal::parse(&String::from_utf8_lossy(head))
            .ok_or("a NumPy file with an unknown head")?;
        let (Some(descr), Some(Literal::Truth(fortran)), Some(Literal::Row(shape))) = (
            head.get("descr"),
            head.get("fortran_order"),
            head.get("shape"),
        ) else {
            return Err("a NumPy file whose head lacks descr, fortran_order or shape".into());
        };
        let number = |one: &Literal| {
            if let Literal::Number(number) = one {
                Some(*number)
            } else {
                None
            }
        };
        let shape: Vec<usize> = shape.iter().filter_map(number).collect();
        let (fields, size) = fields(descr)?;
        let wanted = shape
            .iter()
            .try_fold(size, |product, one| product.checked_mul(*one))
            .ok_or_else(cut)?;
        let data = bytes[begin + length..].get(..wanted).ok_or_else(cut)?;
        Ok(Self {
            named: matches!(descr, Literal::Row(_)),
            fields,
            shape,
            fortran: *fortran,
            size,
            data,
        })
    }

    /// Rows, where it has columns.
    pub fn rows(&self) -> Option<usize> {
        self.shape.first().copied()
    }

    /// Its columns, and what is to be told of them. `name` stands before a point and theirs, or is the only one's.
    ///
    /// # Errors
    /// What was found instead of columns, in words.
    pub fn columns(&self, name: &str) -> Result<(Vec<LogColumn>, Vec<String>), String> {
        let told = || {
            format!("an array of shape {:?}", self.shape)
                .replace('[', "(")
                .replace(']', ")")
        };
        let (rows, across, mut notes) = match *self.shape.as_slice() {
            [rows] => (rows, 1, Vec::new()),
            [rows, across] if !self.named => (rows, across, Vec::new()),
            _ => return Err(told()),
        };
        let turned = across > rows && self.shape.len() == 2;
        let (rows, across) = if turned {
            (across, rows)
        } else {
            (rows, across)
        };
        if across > MOST_COLUMNS {
            return Err(told());
        }
        if turned {
            notes.push(format!(
                "{} is wider than long: its rows were taken as columns",
                told()
            ));
        }
        let mut columns = Vec::new();
        for place in 0..across {
            for field in self.fields.iter().filter(|field| field.kind != Kind::Other) {
                let index = |row: usize| match (self.shape.len() == 2, turned != self.fortran) {
                    (false, _) => row,
                    (true, false) => row * across + place,
                    (true, true) => place * rows + row,
                };
                let mut numbers: Vec<f64> = (0..rows)
                    .map(|row| self.number(field, index(row)))
                    .collect();
                let unit = match field.kind {
                    Kind::Instant(step_s) => {
                        let first = numbers
                            .iter()
                            .copied()
                            .find(|number| number.is_finite())
                            .unwrap_or(0.0);
                        numbers
                            .iter_mut()
                            .for_each(|number| *number = (*number - first) * step_s);
                        Some("s".to_owned())
                    }
                    _ => None,
                };
                let name = match (name, field.name.as_str(), self.shape.len()) {
                    ("", "", _) => format!("#{}", place + 1),
                    ("", field, _) => field.to_owned(),
                    (name, "", 2) => format!("{name}[{place}]"),
                    (name, "", _) => name.to_owned(),
                    (name, field, _) => format!("{name}.{field}"),
                };
                columns.push(LogColumn {
                    name,
                    unit,
                    numbers,
                    ..LogColumn::default()
                });
            }
        }
        if columns.is_empty() {
            return Err("an array without numbers".into());
        }
        Ok((columns, notes))
    }

    fn number(&self, field: &Field, index: usize) -> f64 {
        let at = index * self.size + field.at;
        let mut bytes = [0; 8];
        for (place, byte) in self.data[at..at + field.size].iter().enumerate() {
            bytes[if field.big {
                field.size - 1 - place
            } else {
                place
            }] = *byte;
        }
        let word = u64::from_le_bytes(bytes);
        // The sign, at the upper end of the word.
        let unused = 64 - 8 * field.size as u32;
        match (field.kind, field.size) {
            (Kind::Real, 8) => f64::from_bits(word),
            (Kind::Real, 4) => f64::from(f32::from_bits(word as u32)),
            (Kind::Real, _) => half(word as u16),
            (Kind::Unsigned, _) => word as f64,
            // `NaT`, NumPy's "not a time", is the least number.
            (Kind::Instant(_), _) if word == 1 << 63 => f64::NAN,
            _ => ((word << unused) as i64 >> unused) as f64,
        }
    }
}

/// A number of 16 bits, IEEE 754.
fn half(bits: u16) -> f64 {
    let sign = if bits >> 15 == 1 { -1.0 } else { 1.0 };
    let (exponent, fraction) = (i32::from(bits >> 10 & 31), f64::from(bits & 1023) / 1024.0);
    sign * match exponent {
        0 => fraction * 2.0_f64.powi(-14),
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        _ => (1.0 + fraction) * 2.0_f64.powi(exponent - 15),
    }
}

/// The columns of an element, and its bytes.
fn fields(descr: &Literal) -> Result<(Vec<Field>, usize), String> {
    let one = |name: &str, text: &str, at: usize| {
        let (kind, size, big) = kind(text)?;
        Ok::<_, String>(Field {
            name: name.to_owned(),
            kind,
            at,
            size,
            big,
        })
    };
    match descr {
        Literal::Text(text) => {
            let field = one("", text, 0)?;
            let size = field.size;
            Ok((vec![field], size))
        }
        Literal::Row(row) => {
            let (mut fields, mut at) = (Vec::new(), 0);
            for part in row {
                let Literal::Row(part) = part else {
                    return Err("a NumPy file with an unknown head".into());
                };
                let name = match part.first() {
                    Some(Literal::Text(name)) => name.clone(),
                    // A title and a name.
                    Some(Literal::Row(names)) => match names.last() {
                        Some(Literal::Text(name)) => name.clone(),
                        _ => String::new(),
                    },
                    _ => String::new(),
                };
                let Some(Literal::Text(text)) = part.get(1) else {
                    return Err(format!("columns within the column {name}"));
                };
                let times = match part.get(2) {
                    Some(Literal::Row(shape)) => {
                        shape.iter().try_fold(1_usize, |product, one| match one {
                            Literal::Number(number) => product.checked_mul(*number),
                            _ => None,
                        })
                    }
                    Some(Literal::Number(number)) => Some(*number),
                    _ => Some(1),
                };
                let times = times
                    .filter(|times| *times <= MOST_COLUMNS)
                    .ok_or_else(|| format!("an array within the column {name}"))?;
                for place in 0..times {
                    let called = if part.len() > 2 {
                        format!("{name}[{place}]")
                    } else {
                        name.clone()
                    };
                    let field = one(&called, text, at)?;
                    at += field.size;
                    fields.push(field);
                }
            }
            Ok((fields, at))
        }
        _ => Err("a NumPy file with an unknown head".into()),
    }
}

/// What `<f8` means: kind, bytes, most significant byte first or not.
fn kind(text: &str) -> Result<(Kind, usize, bool), String> {
    let refuse = || format!("a NumPy array of \"{text}\"");
    let (order, rest) = text.split_at_checked(1).ok_or_else(refuse)?;
    let (letter, rest) = rest.split_at_checked(1).ok_or_else(refuse)?;
    let (digits, unit) = rest.split_at(rest.find('[').unwrap_or(rest.len()));
    if letter == "O" {
        return Err("a NumPy array of Python's objects".into());
    }
    let size: usize = digits.parse().map_err(|_| refuse())?;
    let kind = match (letter, size) {
        ("f", 2 | 4 | 8) => Kind::Real,
        ("i", 1 | 2 | 4 | 8) => Kind::Signed,
        ("u", 1 | 2 | 4 | 8) | ("b", 1) => Kind::Unsigned,
        ("M" | "m", 8) => Kind::Instant(step_s(unit).ok_or_else(refuse)?),
        _ => Kind::Other,
    };
    // A letter of text takes four bytes.
    let size = if letter == "U" {
        size.checked_mul(4).ok_or_else(refuse)?
    } else {
        size
    };
    Ok((kind, size, order == ">"))
}

/// Seconds of one step of `[ns]`, `[10us]`.
fn step_s(unit: &str) -> Option<f64> {
    let unit = unit.strip_prefix('[')?.strip_suffix(']')?;
    let letters = unit.find(|letter: char| !letter.is_ascii_digit())?;
    let times: f64 = if letters == 0 {
        1.0
    } else {
        unit[..letters].parse().ok()?
    };
    let (_, seconds) = [
        ("s", 1.0),
        ("ms", 1e-3),
        ("us", 1e-6),
        ("ns", 1e-9),
        ("m", 60.0),
        ("h", 3600.0),
    ]
    .into_iter()
    .find(|(name, _)| *name == &unit[letters..])?;
    Some(times * seconds)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_numbers() {
        for (bits, value) in [
            (0x3c00, 1.0),
            (0xc000, -2.0),
            (0x7bff, 65504.0),
            (0x0001, 5.960_464_477_539_063e-8),
            (0x3555, 0.333_251_953_125),
        ] {
            assert_eq!(half(bits), value);
        }
        assert!(half(0x7e00).is_nan() && half(0xfc00) == f64::NEG_INFINITY);
    }

    #[test]
    fn steps_of_time() {
        for (unit, wanted) in [
            ("[ns]", Some(1e-9)),
            ("[10us]", Some(10.0 * 1e-6)),
            ("[D]", None),
            ("", None),
            ("[]", None),
        ] {
            assert_eq!(step_s(unit), wanted, "{unit}");
        }
    }
}
