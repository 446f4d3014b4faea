//! SimpleFOC: what `motor.monitor()` prints, as a serial terminal keeps it.
//!
//! A line a call: the variables that `monitor_variables` names, always in one order, with `monitor_separator` between them, a letter before
//! and after where one is set. Lines of the start (`MOT: …`) and of the commander stand between them. The Arduino IDE puts the time of
//! day before each line where that is switched on, `23:59:59.995 -> `.

use super::beside::first_lines;
use crate::table::{Log, LogColumn};
use crate::text::decode;
use recording::Error;
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
const NO_TIME: &str = "--rate-hz HZ, calls of monitor() a second over monitor_downsample: SimpleFOC prints no time; or the time stamps of the Arduino IDE's monitor";
/// A day, s, by definition: the time stamps begin anew at midnight.
const DAY_S: f64 = 86_400.0;

/// True of a file with a line of SimpleFOC's start, or one with the IDE's time before values with tabs between them.
pub fn is_it(bytes: &[u8]) -> bool {
    first_lines(bytes).any(|line| {
        let (t_s, rest) = stamped(line);
        rest.starts_with("MOT:") || t_s.is_some() && rest.contains('\t')
    })
}

/// The variables, one row a line of values.
///
/// # Errors
/// No line of values in it.
pub fn read(file: &Path, bytes: &[u8]) -> Result<Log, Error> {
    let text = decode(bytes);
    let mut rows: Vec<(u64, Option<f64>, Vec<f64>)> = Vec::new();
    let mut others = 0;
    for (place, line) in text
        .lines()
        .enumerate()
        .filter(|(_, line)| !line.trim().is_empty())
    {
        let (t_s, rest) = stamped(line.trim());
        match values(rest) {
            Some(values) => rows.push((place as u64 + 1, t_s, values)),
            None => others += usize::from(!rest.starts_with("MOT:")),
        }
    }
    let widths = |row: &(u64, Option<f64>, Vec<f64>)| {
        rows.iter()
            .filter(|other| other.2.len() == row.2.len())
            .count()
    };
    let Some(width) = rows
        .iter()
        .max_by_key(|row| widths(row))
        .map(|row| row.2.len())
    else {
        let wanted = "lines of motor.monitor(): call it in loop(), with motor.useMonitoring(Serial) in setup()";
        return Err(Error::new(
            file,
            "a log of SimpleFOC without values",
            wanted,
        ));
    };
    let before = rows.len();
    rows.retain(|row| row.2.len() == width);
    others += before - rows.len();
    let places: Vec<usize> = match width {
        4 => USUAL.to_vec(),
        7 => (0..7).collect(),
        _ => Vec::new(),
    };
    let mut columns: Vec<LogColumn> = (0..width)
        .map(|place| column(place, places.get(place).copied(), &rows))
        .collect();
    let mut log_time = None;
    if rows.iter().all(|row| row.1.is_some()) {
        columns.insert(0, time(&rows));
    } else {
        log_time = Some(NO_TIME);
    }
    let mut log = Log::of_columns(file, columns)?;
    (log.form, log.no_time) = ("a monitor of SimpleFOC", log_time);
    log.lines = rows.iter().map(|row| row.0).collect();
    match places.is_empty() {
        true => log.notes.push(format!("{width} variables: monitor_variables says which, in the order target, voltage_q, voltage_d, current_q, current_d, velocity, angle")),
        false if width == 4 => log.notes.push("4 variables: target, voltage_q, velocity and angle, unless monitor_variables says otherwise".into()),
        false => {}
    }
    if others > 0 {
        log.notes.push(format!(
            "{others} lines without {width} values were left aside"
        ));
    }
    Ok(log)
}

fn column(place: usize, known: Option<usize>, rows: &[(u64, Option<f64>, Vec<f64>)]) -> LogColumn {
    let (name, unit) = known.map_or((format!("#{}", place + 1), None), |known| {
        (ALL[known].0.to_owned(), ALL[known].1)
    });
    LogColumn {
        hint: (name == "angle").then(|| "p1_m=angle:rad".to_owned()),
        name,
        unit: unit.map(str::to_owned),
        numbers: rows.iter().map(|row| row.2[place]).collect(),
        ..LogColumn::default()
    }
}

/// Seconds since the first line, over midnight.
fn time(rows: &[(u64, Option<f64>, Vec<f64>)]) -> LogColumn {
    let (mut days, mut last) = (0.0, f64::NEG_INFINITY);
    let mut numbers: Vec<f64> = Vec::new();
    for t_s in rows.iter().filter_map(|row| row.1) {
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

/// The IDE's time of day, s, and what stands behind it.
fn stamped(line: &str) -> (Option<f64>, &str) {
    let parted = || {
        let (stamp, rest) = line.split_once(" -> ")?;
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

/// The values of a line; none where it holds a word.
fn values(line: &str) -> Option<Vec<f64>> {
    let line = line.trim();
    // A letter at each end, as SimpleFOCStudio sets them.
    let bare = line
        .trim_start_matches(|letter: char| letter.is_ascii_alphabetic())
        .trim_end_matches(|letter: char| letter.is_ascii_alphabetic());
    let (before, after) = (
        line.len()
            - line
                .trim_start_matches(|letter: char| letter.is_ascii_alphabetic())
                .len(),
        line.len() - bare.len(),
    );
    let words = || {
        bare.split(['\t', ' ', ',', ';'])
            .map(str::trim)
            .filter(|word| !word.is_empty())
    };
    // Before a separator it is a word of its own.
    let own_word = bare.trim() != bare;
    if own_word || before > 1 || after - before > 1 || words().next().is_none() {
        return None;
    }
    // `nan`, `inf` and `ovf` are what Arduino prints of what is no number or too large.
    words()
        .map(|word| {
            word.parse()
                .ok()
                .or_else(|| ["nan", "inf", "ovf"].contains(&word).then_some(f64::NAN))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_values_and_others() {
        assert_eq!(values("1.0\t-2.5"), Some(vec![1.0, -2.5]));
        assert_eq!(values("M1.0\t-2.5M"), Some(vec![1.0, -2.5]));
        assert_eq!(values("0.5"), Some(vec![0.5]));
        for line in [
            "Target: 2.0",
            "MOT: Ready.",
            "",
            "M",
            "PID vel| P: 0.20",
            "1.0\tx",
        ] {
            assert_eq!(values(line), None, "{line}");
        }
        assert_eq!(stamped("23:59:59.995 -> 1\t2"), (Some(86_399.995), "1\t2"));
        assert_eq!(stamped("a -> b"), (None, "a -> b"));
    }
}
