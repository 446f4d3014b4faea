//! SimpleFOC: what `motor.monitor()` prints, as a serial terminal keeps it.
//!
//! A line a call: the variables that `monitor_variables` names, always in one order, each with `monitor_decimals` digits, with
//! `monitor_separator` between them, a letter before and after where one is set. The library prints other numbers too, as the commander's
//! answers, so the monitor's lines are those that look like most. The Arduino IDE and PlatformIO put the time of day before each line where
//! that is switched on, `23:59:59.995 -> ` and `23:59:59.995 > `.

use super::beside::first_lines;
use crate::table::{Log, LogColumn, told_how};
use crate::text::decode;
use recording::Error;
use std::f64::consts::TAU;
use std::path::Path;

/// The variables and their units in the library's order.
const ALL: [(&str, Option<&str>); 7] = [
    ("target", None),
    ("voltage_q", Some("V")),
    ("voltage_d", Some("V")),
    ("current_q_ma", None),
    ("current_d_ma", None),
    ("velocity", None),
    ("angle", Some("rad")),
];
/// Those that it prints where the program says nothing else.
const USUAL: [usize; 4] = [0, 1, 5, 6];
const NO_TIME: &str = "--rate-hz HZ, calls of monitor() a second over monitor_downsample: SimpleFOC prints no time; or time stamps by the monitor of the Arduino IDE or of PlatformIO";
/// How the angle comes into a log.
pub const HOW_TO_RECORD: &str = "motor.monitor_variables = _MON_TARGET | _MON_VEL | _MON_ANGLE, motor.useMonitoring(Serial) in setup(), and motor.monitor() in loop()";
/// A day, s, by definition: the time stamps begin anew at midnight.
const DAY_S: f64 = 86_400.0;

/// How a line of values looks: the same in all lines of one monitor.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Look {
    before: Option<char>,
    /// A blank stands for any number of blanks and tabs, as a terminal's screen has them.
    separator: Option<char>,
    after: Option<char>,
    width: usize,
    /// Digits behind the point; none where no value is a number.
    decimals: Option<usize>,
}

impl Look {
    /// True of two lines that one monitor may have printed.
    fn agrees(&self, other: &Self) -> bool {
        let bare = |look: &Self| Self {
            decimals: None,
            ..*look
        };
        let digits = self.decimals.zip(other.decimals);
        bare(self) == bare(other) && digits.is_none_or(|(own, others)| own == others)
    }
}

struct Row<'a> {
    line: u64,
    text: &'a str,
    t_s: Option<f64>,
    look: Look,
    values: Vec<f64>,
}

/// True of a file with a line of SimpleFOC's start, or with the time of day before values.
pub fn is_it(bytes: &[u8]) -> bool {
    first_lines(bytes).any(|line| {
        let (t_s, rest) = stamped(line);
        rest.starts_with("MOT:") || t_s.is_some() && values(rest).is_some()
    })
}

/// The variables, one row a line of values.
///
/// # Errors
/// No line of values in it.
pub fn read(file: &Path, bytes: &[u8]) -> Result<Log, Error> {
    let text = decode(bytes);
    let mut rows = Vec::new();
    let mut others: Vec<(u64, &str)> = Vec::new();
    for (line, text) in (1..)
        .zip(text.lines())
        .filter(|(_, text)| !text.trim().is_empty())
    {
        let (t_s, text) = stamped(text.trim());
        match values(text) {
            Some((look, values)) => rows.push(Row {
                line,
                text,
                t_s,
                look,
                values,
            }),
            None => others.push((line, text)),
        }
    }
    let Some(look) = most(&rows) else {
        let wanted = format!("lines of motor.monitor(){}", told_how(HOW_TO_RECORD));
        return Err(Error::new(
            file,
            "a log of SimpleFOC without values",
            wanted,
        ));
    };
    let (rows, unlike): (Vec<Row>, Vec<Row>) =
        rows.into_iter().partition(|row| look.agrees(&row.look));
    others.extend(unlike.iter().map(|row| (row.line, row.text)));
    let mirrored = others
        .iter()
        .any(|(_, text)| text.starts_with("MOT:") && text.ends_with("CCW"));
    others.retain(|(line, _)| *line > rows[0].line);
    let width = look.width;
    let places: Vec<usize> = match width {
        4 => USUAL.to_vec(),
        7 => (0..7).collect(),
        _ => Vec::new(),
    };
    let mut columns: Vec<LogColumn> = (0..width)
        .map(|place| column(place, places.get(place).copied(), &rows))
        .collect();
    if places.is_empty() {
        let last = &mut columns[width - 1];
        last.hint = Some(format!("p1_m={}:rad", last.name));
    }
    let mut log_time = None;
    if rows.iter().all(|row| row.t_s.is_some()) {
        columns.insert(0, time(&rows));
    } else {
        log_time = Some(NO_TIME);
    }
    let mut log = Log::of_columns(columns);
    (log.form, log.no_time) = ("a monitor of SimpleFOC", log_time);
    log.lines = rows.iter().map(|row| row.line).collect();
    log.notes = notes(width, &rows, &others);
    if mirrored {
        log.notes.push("the sensor counts against the motor (CCW): the angle is minus the sensor's; for a table of the sensor itself take its unit as rad/-1".into());
    }
    Ok(log)
}

/// The look that most lines have.
fn most(rows: &[Row]) -> Option<Look> {
    let mut looks: Vec<(Look, usize)> = Vec::new();
    for row in rows {
        match looks.iter_mut().find(|(look, _)| *look == row.look) {
            Some((_, count)) => *count += 1,
            None => looks.push((row.look, 1)),
        }
    }
    // Of several the first.
    let (look, _) = looks.into_iter().rev().max_by_key(|(_, count)| *count)?;
    Some(look)
}

/// What is not known of the variables, and what was left aside.
fn notes(width: usize, rows: &[Row], others: &[(u64, &str)]) -> Vec<String> {
    let mut notes = Vec::new();
    match width {
        7 => {}
        4 => notes.push("4 variables: target, voltage_q, velocity and angle, unless monitor_variables says otherwise".into()),
        _ => notes.push(format!("{width} variables: monitor_variables says which, in the order target, voltage_q, voltage_d, current_q, current_d, velocity, angle")),
    }
    if is_open_loop(width, rows) {
        notes.push("the last but one is the target in every line: if it is the velocity, this is the library's open loop, whose angle is the one commanded and no sensor's".into());
    }
    if let Some((line, text)) = others.iter().min() {
        notes.push(format!(
            "{} lines among the values were left aside, as line {line}, `{text}`",
            others.len()
        ));
    }
    notes
}

/// True where the velocity is the target in every line, not only zero, and the angle within a turn. No motor follows so well: the library's
/// open loop prints what it commands.
fn is_open_loop(width: usize, rows: &[Row]) -> bool {
    let commanded = |row: &Row| {
        row.values[width - 2] == row.values[0] && (0.0..=TAU).contains(&row.values[width - 1])
    };
    matches!(width, 3 | 4 | 7)
        && rows.iter().all(commanded)
        && rows.iter().any(|row| row.values[0] != 0.0)
}

fn column(place: usize, known: Option<usize>, rows: &[Row]) -> LogColumn {
    let (name, unit) = known.map_or((format!("#{}", place + 1), None), |known| {
        (ALL[known].0.to_owned(), ALL[known].1)
    });
    LogColumn {
        hint: (name == "angle").then(|| "p1_m=angle:rad".to_owned()),
        name,
        unit: unit.map(str::to_owned),
        numbers: rows.iter().map(|row| row.values[place]).collect(),
        ..LogColumn::default()
    }
}

/// Seconds since the first line, over midnight.
fn time(rows: &[Row]) -> LogColumn {
    let (mut days, mut last) = (0.0, f64::NEG_INFINITY);
    let mut numbers: Vec<f64> = Vec::new();
    for t_s in rows.iter().filter_map(|row| row.t_s) {
        if t_s < last - 0.5 * DAY_S {
            days += DAY_S;
        }
        last = t_s;
        numbers.push(t_s + days);
    }
    let first = numbers.first().copied().unwrap_or(0.0);
    numbers.iter_mut().for_each(|number| *number -= first);
    LogColumn {
        name: "time".into(),
        unit: Some("s".into()),
        numbers,
        ..LogColumn::default()
    }
}

/// The time of day, s, of the Arduino IDE or of PlatformIO, and what stands behind it.
fn stamped(line: &str) -> (Option<f64>, &str) {
    let parted = || {
        let (stamp, rest) = line.split_once(" -> ").or_else(|| line.split_once(" > "))?;
        let [hours, minutes, seconds] =
            <[&str; 3]>::try_from(stamp.split(':').collect::<Vec<_>>()).ok()?;
        let part = |text: &str| {
            text.parse::<f64>()
                .ok()
                .filter(|number| (0.0..61.0).contains(number))
        };
        Some((
            3600.0 * part(hours)? + 60.0 * part(minutes)? + part(seconds)?,
            rest,
        ))
    };
    parted().map_or((None, line), |(t_s, rest)| (Some(t_s), rest))
}

/// How a line looks and its values; none of a line that is not only values, or that was cut.
fn values(line: &str) -> Option<(Look, Vec<f64>)> {
    let mut rest = line.trim();
    let mut look = Look {
        before: None,
        separator: None,
        after: None,
        width: 0,
        decimals: None,
    };
    if number(rest).is_none() {
        (look.before, rest) = split_first(rest)?;
    }
    let mut values = Vec::new();
    loop {
        let (value, decimals, behind) = number(rest)?;
        if decimals.is_some() && *look.decimals.get_or_insert(decimals?) != decimals? {
            return None;
        }
        values.push(value);
        if behind.is_empty() {
            break;
        }
        (look.after, rest) = split_first(behind)?;
        if rest.is_empty() {
            break;
        }
        let separator = look.after.take()?;
        if separator.is_alphanumeric() || *look.separator.get_or_insert(separator) != separator {
            return None;
        }
    }
    look.width = values.len();
    Some((look, values))
}

/// A line's first character, a blank for any blanks and tabs, and what stands behind it.
fn split_first(text: &str) -> Option<(Option<char>, &str)> {
    let first = text.chars().next()?;
    let rest = &text[first.len_utf8()..];
    Some(match first {
        ' ' | '\t' => (Some(' '), rest.trim_start()),
        _ => (Some(first), rest),
    })
}

/// The number at the start as Arduino's `print` writes it, its digits behind the point, and what stands behind it.
fn number(text: &str) -> Option<(f64, Option<usize>, &str)> {
    // What is no number, or too large.
    if let Some(rest) = ["nan", "inf", "ovf"]
        .iter()
        .find_map(|word| text.strip_prefix(word))
    {
        return Some((f64::NAN, None, rest));
    }
    let digits = |text: &str| text.bytes().take_while(u8::is_ascii_digit).count();
    let sign = usize::from(text.starts_with('-'));
    let whole = digits(&text[sign..]);
    let point = sign + whole;
    let decimals = match text[point..].strip_prefix('.') {
        Some(behind) => digits(behind),
        None => 0,
    };
    let end = if decimals > 0 {
        point + 1 + decimals
    } else {
        point
    };
    let value = text[..end].parse().ok().filter(|_| whole > 0)?;
    Some((value, Some(decimals), &text[end..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_values_and_others() {
        let of = |line| values(line).map(|(_, values)| values);
        for line in [
            "1.0\t-2.5",
            "M1.0\t-2.5M",
            "1.0;-2.5",
            "$1.0--2.5",
            "1.0 \t -2.5",
            "1.0|-2.5\n",
        ] {
            assert_eq!(of(line), Some(vec![1.0, -2.5]), "{line}");
        }
        assert_eq!(of("0.5"), Some(vec![0.5]));
        let missing = of("nan\tinf\t1.00").unwrap();
        assert!(missing[0].is_nan() && missing[1].is_nan() && missing[2] == 1.0);
        for line in [
            "Target: 2.0",
            "MOT:Ready.",
            "",
            "M",
            "PID vel| P: 0.20",
            "1.0\tx",
            "1.00\t2.0",
            "1.0\t2.0;3.0",
            "1.0e-3",
            "MM1.0",
        ] {
            assert_eq!(of(line), None, "{line}");
        }
        assert_eq!(stamped("23:59:59.995 -> 1\t2"), (Some(86_399.995), "1\t2"));
        assert_eq!(stamped("23:59:59.995 > 1\t2"), (Some(86_399.995), "1\t2"));
        assert_eq!(stamped("a -> b"), (None, "a -> b"));
    }

    #[test]
    fn the_look_of_most_lines_is_the_monitors() {
        let log = read(
            Path::new("log"),
            b"MOT:Init\n2.000\nA1.0000A\nA2.0000A\nA2.5000A\nAnanA\nB7.0000B\n3.000\nA1.00",
        )
        .unwrap();
        let numbers = &log.columns[0].numbers;
        assert!(numbers[..3] == [1.0, 2.0, 2.5] && numbers[3].is_nan());
        assert_eq!(log.lines, [3, 4, 5, 6]);
        assert!(
            log.notes
                .last()
                .unwrap()
                .contains("3 lines among the values were left aside, as line 7, `B7.0000B`"),
            "{:?}",
            log.notes
        );
    }
}
