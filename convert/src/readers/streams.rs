//! Messages of several kinds, each at its own times, as the rows of one table.

use super::beside::Beside;
use crate::table::{Log, LogColumn};
use crate::told::figures;
use recording::Error;
use std::path::Path;

/// Messages of one kind.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Stream {
    /// What the log calls them.
    pub name: String,
    /// When each came, s.
    pub t_s: Vec<f64>,
    /// Line of the file on which each stands, or its number.
    pub lines: Vec<u64>,
    /// Their values, one a message.
    pub columns: Vec<LogColumn>,
    /// When a message said that it has no value, s, of each column; of those that never do it may be left out.
    pub none_s: Vec<Vec<f64>>,
}

/// A gap of more than so many usual intervals is not bridged: the recording's layout begins a new stretch there.
const GAP_INTERVALS: f64 = 10.0;
/// A step of more than this part of a column's whole range is where it begins anew, as an angle does at each turn.
const BEGINS_ANEW: f64 = 0.5;

impl Stream {
    /// How often columns had no value, one sentence each.
    fn nones(&self) -> Vec<String> {
        let all = self.columns.iter().zip(&self.none_s);
        let some = all.filter(|(_, none_s)| !none_s.is_empty());
        let told = |(column, none_s): (&LogColumn, &Vec<f64>)| {
            let (name, of) = (&column.name, self.t_s.len());
            format!(
                "{} of {of} messages {} say that {name} has no value",
                none_s.len(),
                self.name
            )
        };
        some.map(told).collect()
    }

    /// True if a `--column` with this source means one of its columns.
    fn is_source(&self, source: &str) -> bool {
        let means = |name: &str| {
            let (head, rest) = source.split_at_checked(name.len()).unwrap_or_default();
            head.eq_ignore_ascii_case(name)
                && rest
                    .chars()
                    .next()
                    .is_none_or(|next| ":*/+-".contains(next))
        };
        // A column by its whole name, or by its end behind a point.
        let ends = |name: &str| {
            let points = name.match_indices('.').map(|(at, _)| at + 1);
            std::iter::once(0)
                .chain(points)
                .any(|at| at < name.len() && means(&name[at..]))
        };
        self.columns
            .iter()
            .any(|column| ends(&format!("{}.{}", self.name, column.name)))
    }
}

/// One table, whose rows are the messages of one kind: those of `rows_of`, or that with the sensor's output, or else the most frequent. Values of the other kinds are
/// interpolated to its times, straight between the message before and the one after; nothing is where one of them is missing or far away.
/// The column `time` holds seconds since the first row. Columns are named by their kind of message, a point, and their own names.
///
/// # Errors
/// No messages, or none of the kind `rows_of`.
pub fn together(
    file: &Path,
    form: &'static str,
    mut streams: Vec<Stream>,
    beside: &Beside,
) -> Result<Log, Error> {
    streams.retain(|stream| !stream.t_s.is_empty() && !stream.columns.is_empty());
    streams.iter_mut().for_each(sort);
    let names = || {
        streams
            .iter()
            .map(|stream| stream.name.as_str())
            .collect::<Vec<_>>()
            .join(", ")
    };
    let most = (0..streams.len())
        .rev()
        .max_by_key(|place| streams[*place].t_s.len());
    let sensor = beside
        .sensor
        .as_deref()
        .and_then(|source| streams.iter().position(|stream| stream.is_source(source)));
    let base = match beside.rows_of.as_deref() {
        Some(wanted) => match streams
            .iter()
            .position(|stream| stream.name.eq_ignore_ascii_case(wanted))
        {
            Some(place) => place,
            None => {
                return Err(Error::new(
                    file,
                    format!("no messages \"{wanted}\""),
                    format!("--rows-of one of {}", names()),
                ));
            }
        },
        None => sensor
            .or(most)
            .ok_or_else(|| Error::new(file, "no messages with numbers", "a log with some"))?,
    };
    let mut notes = Vec::new();
    if streams.len() > 1 {
        let others = streams
            .iter()
            .enumerate()
            .filter(|(place, _)| *place != base);
        let told: Vec<String> = others
            .map(|(_, stream)| format!("{} ({})", stream.name, stream.t_s.len()))
            .collect();
        let name = &streams[base].name;
        notes.push(format!(
            "a row for each of {} messages {name}; --rows-of NAME takes another: {}",
            streams[base].t_s.len(),
            told.join(", ")
        ));
    }
    notes.extend(streams.iter().flat_map(Stream::nones));
    for stream in streams.iter_mut().filter(|stream| !stream.name.is_empty()) {
        for column in &mut stream.columns {
            column.name = format!("{}.{}", stream.name, column.name);
        }
    }
    let rows = streams.remove(base);
    let first_s = rows.t_s[0];
    let time = LogColumn {
        name: "time".into(),
        unit: Some("s".into()),
        numbers: rows.t_s.iter().map(|t_s| t_s - first_s).collect(),
        ..LogColumn::default()
    };
    let mut columns = vec![time];
    columns.extend(rows.columns);
    for stream in streams {
        let others = stream
            .columns
            .iter()
            .enumerate()
            .filter(|(_, column)| column.numbers.iter().any(|number| number.is_finite()));
        columns
            .extend(others.map(|(place, _)| interpolated(place, &stream, &rows.t_s, &rows.name)));
    }
    let mut log = Log::of_columns(columns);
    (log.form, log.lines, log.notes) = (form, rows.lines, notes);
    Ok(log)
}

/// Messages in the order of their times.
fn sort(stream: &mut Stream) {
    let all = stream.none_s.iter_mut();
    all.for_each(|none_s| none_s.sort_by(f64::total_cmp));
    if stream.t_s.is_sorted() {
        return;
    }
    let mut order: Vec<usize> = (0..stream.t_s.len()).collect();
    order.sort_by(|a, b| stream.t_s[*a].total_cmp(&stream.t_s[*b]));
    let mut place = vec![0; order.len()];
    order
        .iter()
        .enumerate()
        .for_each(|(new, old)| place[*old] = new);
    stream.t_s = order.iter().map(|old| stream.t_s[*old]).collect();
    stream.lines = order.iter().map(|old| stream.lines[*old]).collect();
    for column in &mut stream.columns {
        column.numbers = order.iter().map(|old| column.numbers[*old]).collect();
        column
            .words
            .iter_mut()
            .for_each(|(row, _)| *row = place[*row]);
        column.words.sort_by_key(|(row, _)| *row);
    }
}

/// A column at other times than its own.
fn interpolated(place: usize, stream: &Stream, t_s: &[f64], rows: &str) -> LogColumn {
    let column = &stream.columns[place];
    let none_s = stream.none_s.get(place).map_or(&[][..], Vec::as_slice);
    let is_told = |from_s: f64, until_s: f64| {
        let first = none_s.partition_point(|t_s| *t_s <= from_s);
        none_s.get(first).is_none_or(|t_s| *t_s >= until_s)
    };
    let points: Vec<[f64; 2]> = stream
        .t_s
        .iter()
        .zip(&column.numbers)
        .filter(|(_, x)| x.is_finite())
        .map(|(t, x)| [*t, *x])
        .collect();
    let (low, high) = points
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), [_, x]| {
            (low.min(*x), high.max(*x))
        });
    let mut intervals: Vec<f64> = points
        .windows(2)
        .map(|pair| pair[1][0] - pair[0][0])
        .collect();
    intervals.sort_by(f64::total_cmp);
    let longest_s = GAP_INTERVALS * intervals.get(intervals.len() / 2).copied().unwrap_or(0.0);
    let bridged = |[t0, x0]: [f64; 2], [t1, x1]: [f64; 2]| {
        let turns = (x1 - x0).abs() > BEGINS_ANEW * (high - low) && high > low;
        t1 - t0 <= longest_s && !turns && is_told(t0, t1)
    };
    let mut next = 0;
    let value = |t_s: &f64| {
        while points.get(next).is_some_and(|[t, _]| t < t_s) {
            next += 1;
        }
        let after = *points.get(next)?;
        if after[0] == *t_s {
            return Some(after[1]);
        }
        let before = points[next.checked_sub(1)?];
        let part = (t_s - before[0]) / (after[0] - before[0]);
        bridged(before, after).then(|| before[1] + part * (after[1] - before[1]))
    };
    let numbers = t_s
        .iter()
        .map(value)
        .map(|value| value.unwrap_or(f64::NAN))
        .collect();
    let off = bend(&points);
    let unit = column.unit.as_deref().unwrap_or_default();
    let note = format!(
        "{} was interpolated from {} messages {} to the times of {rows}: between them it may be off by {} {unit} rms",
        column.name,
        points.len(),
        stream.name,
        figures(off)
    );
    LogColumn {
        name: column.name.clone(),
        unit: column.unit.clone(),
        hint: column.hint.clone(),
        numbers,
        words: Vec::new(),
        note: Some(note.replace("  ", " ")),
    }
}

/// How far a curve may be from the straight line between two points, rms: an eighth of its second derivative times the interval's square.
fn bend(points: &[[f64; 2]]) -> f64 {
    let one = |three: &[[f64; 2]]| {
        let [[t0, x0], [t1, x1], [t2, x2]] = [three[0], three[1], three[2]];
        let second = 2.0 * ((x2 - x1) / (t2 - t1) - (x1 - x0) / (t1 - t0)) / (t2 - t0);
        let interval = (t1 - t0).max(t2 - t1);
        second * interval * interval / 8.0
    };
    let all: Vec<f64> = points
        .windows(3)
        .map(one)
        .filter(|value| value.is_finite())
        .collect();
    (all.iter().map(|value| value * value).sum::<f64>() / all.len().max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stream(name: &str, points: &[[f64; 2]], column: &str) -> Stream {
        Stream {
            name: name.into(),
            t_s: points.iter().map(|point| point[0]).collect(),
            lines: (1..=points.len() as u64).collect(),
            columns: vec![LogColumn {
                name: column.into(),
                numbers: points.iter().map(|point| point[1]).collect(),
                ..LogColumn::default()
            }],
            none_s: Vec::new(),
        }
    }

    #[test]
    fn rows_are_of_the_most_frequent_and_others_are_interpolated() {
        // The second kind out of order, with a step back by a turn and a gap.
        let fast: Vec<[f64; 2]> = (0..40)
            .map(|row| [f64::from(row), f64::from(row)])
            .collect();
        let slow = [
            [1.5, 15.0],
            [0.5, 5.0],
            [2.5, 25.0],
            [3.5, -30.0],
            [20.0, -29.0],
        ];
        let log = together(
            Path::new("a"),
            "a test",
            vec![stream("slow", &slow, "x"), stream("fast", &fast, "x")],
            &Beside::default(),
        )
        .unwrap();
        let names: Vec<&str> = log
            .columns
            .iter()
            .map(|column| column.name.as_str())
            .collect();
        assert_eq!(names, ["time", "fast.x", "slow.x"]);
        let x = &log.columns[2].numbers;
        assert_eq!((x[1], x[2], x[20]), (10.0, 20.0, -29.0));
        assert!([0, 3, 10, 21].iter().all(|row| x[*row].is_nan()));
        let by_sensor = Beside {
            sensor: Some("y:turn*2".into()),
            ..Beside::default()
        };
        let log_of_it = together(
            Path::new("a"),
            "a test",
            vec![stream("slow", &slow, "y"), stream("fast", &fast, "x")],
            &by_sensor,
        )
        .unwrap();
        assert_eq!(log_of_it.rows(), 5);
        let rows_of = |name: &str| Beside {
            rows_of: Some(name.into()),
            ..by_sensor.clone()
        };
        let other = together(
            Path::new("a"),
            "a test",
            vec![stream("slow", &slow, "x"), stream("fast", &fast, "y")],
            &rows_of("SLOW"),
        )
        .unwrap();
        assert_eq!(
            (other.rows(), other.lines[0], other.columns[0].numbers[1]),
            (5, 2, 1.0)
        );
        assert_eq!(
            (other.columns[2].name.as_str(), other.columns[2].numbers[0]),
            ("fast.y", 0.5)
        );
        let error = together(
            Path::new("a"),
            "a test",
            vec![stream("slow", &slow, "x")],
            &rows_of("none"),
        )
        .unwrap_err();
        assert_eq!(
            error.to_string(),
            "a: found no messages \"none\", wanted --rows-of one of slow"
        );
    }

    /// What has no value is not bridged by its neighbours.
    #[test]
    fn nothing_is_interpolated_over_a_message_without_a_value() {
        let fast: Vec<[f64; 2]> = (0..40).map(|row| [f64::from(row), 0.0]).collect();
        let points = [0.5, 2.5, 4.5, 6.5, 8.5, 10.5]
            .map(|t_s| [t_s, if t_s == 4.5 { f64::NAN } else { t_s }]);
        let mut slow = stream("slow", &points, "x");
        let read = |slow: &Stream| {
            let streams = vec![slow.clone(), stream("fast", &fast, "x")];
            together(Path::new("a"), "a test", streams, &Beside::default()).unwrap()
        };
        assert_eq!(read(&slow).columns[2].numbers[3..7], [3.0, 4.0, 5.0, 6.0]);
        slow.none_s = vec![vec![4.5]];
        let log = read(&slow);
        assert_eq!(log.columns[2].numbers[1..3], [1.0, 2.0]);
        assert!(log.columns[2].numbers[3..7].iter().all(|x| x.is_nan()));
        let told = "1 of 6 messages slow say that x has no value";
        assert!(log.notes.iter().any(|note| note == told), "{:?}", log.notes);
    }

    #[test]
    fn the_bend_of_a_parabola_is_that_at_the_middle_of_an_interval() {
        let points: Vec<[f64; 2]> = (0..10)
            .map(|k| [0.1 * f64::from(k), (0.1 * f64::from(k)).powi(2)])
            .collect();
        // Between 0 and 0.1 the straight line is 0.005 at the middle, the parabola 0.0025.
        assert!((bend(&points) - 0.0025).abs() < 1e-9);
    }
}
