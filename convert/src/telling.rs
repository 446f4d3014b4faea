//! What a conversion tells of the log, its times, columns and runs.

use crate::dialect::Separator;
use crate::intervals::interval_s;
use crate::source::{Source, Step, Target};
use crate::table::Log;
use crate::told::{Told, ToldColumn, ToldRun, figures};
use crate::units::Quantity;
use recording::{COLUMNS, Column, INDEX, Recording};

/// How the log is written, in words.
#[must_use]
pub fn dialect(log: &Log) -> String {
    let dialect = &log.dialect;
    if dialect.separator == Separator::None {
        let cut = if log.cut_short {
            ", last row cut short and left out"
        } else {
            ""
        };
        return format!("{}{cut}", log.form);
    }
    let mut text = format!("columns separated by {}", dialect.separator);
    if dialect.decimal_comma {
        text += ", decimal commas";
    }
    match dialect.header_line {
        0 => text += ", no header",
        line => text += &format!(", header in row {line}"),
    }
    if dialect.preamble > 0 {
        text += &format!(", {} rows before it left aside", dialect.preamble);
    }
    if dialect.units.is_some() {
        text += ", a row of units";
    }
    if log.cut_short {
        text += ", last row cut short and left out";
    }
    text
}

/// A gap of over this many intervals begins a new stretch, by the layout.
const GAP_INTERVALS: f64 = 10.0;

/// Loggers give a sample at least every half second, and no more than ten million a second: else the unit is likely another.
const USUAL_INTERVALS_S: [f64; 2] = [1.0e-7, 0.5];

/// Rate and duration, and what looks wrong with them.
pub fn times(log: &Log, sources: &[Source], t_s: &[f64], told: &mut Told) {
    let usual_s = interval_s(t_s);
    told.rate_hz = 1.0 / usual_s;
    told.duration_s = t_s.last().copied().unwrap_or(0.0) - t_s.first().copied().unwrap_or(0.0);
    let gaps: Vec<usize> = (1..t_s.len())
        .filter(|&row| t_s[row] - t_s[row - 1] > GAP_INTERVALS * usual_s)
        .collect();
    if let Some(first) = gaps.first() {
        let what = format!(
            "time jumps at {} rows, the first row {}: by {} s after steps of {} s",
            gaps.len(),
            log.lines[*first],
            figures(t_s[*first] - t_s[first - 1]),
            figures(usual_s)
        );
        told.warn(what, "tooth counts may be off across a jump: log without gaps, or with a reference; --rate-hz HZ if the clock is wrong");
    }
    let [shortest_s, longest_s] = USUAL_INTERVALS_S;
    if t_s.len() > 1 && !(shortest_s..=longest_s).contains(&usual_s) {
        let time = sources
            .iter()
            .find(|source| source.target == Target::Numbers(Column::Time));
        let mend = time.map_or("--rate-hz HZ".to_owned(), |source| {
            format!(
                "--column t_s={}:UNIT with UNIT one of {}",
                log.columns[source.column].name,
                Quantity::Time.unit_names()
            )
        });
        told.warn(format!("a sample every {} s", figures(usual_s)), mend);
    }
}

/// Temperatures of boards, °C.
const BOARDS_C: [f64; 2] = [-60.0, 160.0];

/// A temperature that no board has.
pub fn temperature(log: &Log, sources: &[Source], recording: &Recording, told: &mut Told) {
    let column = recording.samples.column(Column::Temperature);
    let source = sources
        .iter()
        .find(|source| source.target == Target::Numbers(Column::Temperature));
    let odd = column
        .iter()
        .find(|value| value.is_finite() && !(BOARDS_C[0]..=BOARDS_C[1]).contains(*value));
    if let (Some(odd), Some(source)) = (odd, source) {
        let mend = format!(
            "--column temp_c={}:K or :F",
            log.columns[source.column].name
        );
        told.warn(format!("a board at {} °C", figures(*odd)), mend);
    }
}

/// The recording's columns and runs, and what of the log is in none of them.
pub fn columns(log: &Log, sources: &[Source], recording: &Recording, told: &mut Told) {
    let samples = &recording.samples;
    for (column, name) in COLUMNS {
        let source = sources
            .iter()
            .find(|source| source.target == Target::Numbers(column));
        let from = match source {
            Some(source) => from(log, source),
            None if column == Column::Time => "the row's number".to_owned(),
            None => "the phase".to_owned(),
        };
        told.columns
            .extend(of_values(name, from, samples.column(column)));
    }
    let index = sources.iter().find(|source| source.target == Target::Index);
    let logged = samples.logged().iter().find(|logged| logged.name == INDEX);
    if let (Some(source), Some(logged)) = (index, logged) {
        let from = log.columns[source.column].name.clone();
        told.columns.extend(of_values(INDEX, from, &logged.values));
    }
    let used = |place: usize| sources.iter().any(|source| source.column == place);
    told.left_aside = (0..log.columns.len())
        .filter(|place| !used(*place))
        .map(|place| log.columns[place].name.clone())
        .collect();
    for run in 0..samples.run_names().len() {
        let of_it = || (0..samples.len()).filter(|index| samples.run_number(*index) == run);
        let (Some(first), Some(last)) = (of_it().next(), of_it().next_back()) else {
            continue;
        };
        told.runs.push(ToldRun {
            name: samples.run_names()[run].clone(),
            samples: of_it().count(),
            times_s: [samples.t_s()[first], samples.t_s()[last]],
        });
    }
}

/// A column and its range; none of one without a value.
fn of_values(name: &'static str, from: String, values: &[f64]) -> Option<ToldColumn> {
    let values = values.iter().copied().filter(|value| value.is_finite());
    let widened = |[low, high]: [f64; 2], value: f64| [low.min(value), high.max(value)];
    let range = values
        .clone()
        .fold([f64::INFINITY, f64::NEG_INFINITY], widened);
    let count = values.count();
    (count > 0).then_some(ToldColumn {
        name,
        from,
        values: count,
        range,
    })
}

/// `stage, mm, *-1`.
fn from(log: &Log, source: &Source) -> String {
    let steps: String = source
        .steps
        .iter()
        .map(|step| match step {
            Step::Times(factor) => format!(", times {}", figures(*factor)),
            Step::Plus(sum) => format!(", plus {}", figures(*sum)),
        })
        .collect();
    let known = if source.unit_from_log {
        " (its header)"
    } else {
        ""
    };
    format!(
        "{}, {}{known}{steps}",
        log.columns[source.column].name, source.unit.name
    )
}
