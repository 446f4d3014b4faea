//! Any log of an encoder to a [`recording::Recording`]: values in, values out.
//!
//! [`read`] takes tables of text and files of other programs (`readers`). [`convert`] goes this way: `text` (bytes to text), `dialect` and `table` (text to columns of numbers), `source` and `mapping`
//! (which column is which), `columns` and `units` (values in SI units), `pair`, `teeth` and `segments` (counts, tooth
//! counts, places), `intervals` (time from sample to sample), `suspect` (what looks wrong beside the reference), `noise` and `meta` (recording.toml), `runs` (names of
//! motions). What it did, assumed and suspects is in [`Told`]. [`listing`] says what a log holds and suggests the options.

mod against;
mod columns;
mod dialect;
mod intervals;
pub mod listing;
mod mapping;
mod meta;
mod order;
mod pair;
mod readers;
mod runs;
mod segments;
mod source;
mod suspect;
mod table;
mod teeth;
mod telling;
mod text;
mod told;
mod units;

pub use columns::ROTARY_PITCH_M;
pub use order::{Order, Stated};
pub use readers::{Beside, Stream, together};
pub use runs::Runs;
pub use source::{Asked, Target, quoted};
pub use table::{Log, LogColumn, told_how};
pub use told::{Assumed, Told, ToldColumn, ToldPair, ToldRun, Warning, figures};
pub use units::{Quantity, Unit, length_m};

use columns::Values;
use intervals::follows;
use recording::{Column, Error, Recording, Row, Samples};
use segments::{Given, Segment};
use source::Source;
use std::path::Path;
use suspect::SAME_TRAVEL;

/// A converted log.
#[derive(Clone, Debug, PartialEq)]
pub struct Converted {
    /// What it became.
    pub recording: Recording,
    /// What was done, assumed and suspected.
    pub told: Told,
}

/// The log in a file's bytes.
///
/// # Errors
/// There is no table of numbers in it, or a row has more or fewer fields than the others.
pub fn read(file: &Path, bytes: &[u8]) -> Result<Log, Error> {
    read_with(file, bytes, &Beside::default())
}

/// The same with what the log needs and does not say itself.
///
/// # Errors
/// As [`read`], or something that it needs is missing.
pub fn read_with(file: &Path, bytes: &[u8], beside: &Beside) -> Result<Log, Error> {
    readers::read(file, bytes, beside)
}

/// Converts a log. `file` is what it is called in errors.
///
/// # Errors
/// The first thing that is wrong or missing, with the row and column of the log where there is one.
pub fn convert(file: &Path, log: &Log, order: &Order) -> Result<Converted, Error> {
    let mut told = Told {
        dialect: telling::dialect(log),
        rows: log.rows(),
        ..Told::default()
    };
    let sources = mapping::sources(file, log, order, &mut told)?;
    let noted = sources
        .iter()
        .filter_map(|source| log.columns[source.column].note.clone());
    told.done = log.notes.iter().cloned().chain(noted).collect();
    let pitch_m = columns::pitch_m(file, &sources, order, &mut told)?;
    let values = columns::values(file, log, &sources, order, pitch_m, &mut told)?;
    let t_s = columns::times_s(file, log, &values, order, &mut told)?;
    let follows = follows(&t_s);
    telling::times(log, &sources, &t_s, &mut told);
    let given = Given {
        file,
        log,
        order,
        values: &values,
        pitch_m,
        follows: &follows,
    };
    let (segments, bits) = given.segments(&mut told)?;
    let of = |column: Column| {
        values
            .iter()
            .find(|values| values.column == column)
            .map(|values| values.values.as_slice())
    };
    let electrodes = of(Column::Electrode(0)).and_then(|_| {
        let all: Vec<&[f64]> = (0..4)
            .filter_map(|electrode| of(Column::Electrode(electrode)))
            .collect();
        <[&[f64]; 4]>::try_from(all).ok()
    });
    let meta = meta::meta(
        file,
        order,
        pitch_m,
        (&segments, bits),
        (electrodes, &follows),
        &mut told,
    )?;
    let runs = runs_of(
        log,
        &sources,
        order,
        &t_s,
        (&segments, &values, pitch_m),
        &mut told,
    );
    let mut samples = samples(&t_s, &runs, &segments, &values);
    if let Some(index) = columns::index(file, log, &sources)? {
        samples.log(index);
    }
    let recording = Recording {
        meta,
        samples,
        warnings: Vec::new(),
    };
    recording
        .check(file)
        .map_err(|error| in_log(error, log, &sources))?;
    telling::columns(log, &sources, &recording, &mut told);
    telling::temperature(log, &sources, &recording, &mut told);
    Ok(Converted { recording, told })
}

/// An error of a sample as one of the row and the column that it comes from.
fn in_log(mut error: Error, log: &Log, sources: &[Source]) -> Error {
    error.row = error
        .row
        .and_then(|row| log.lines.get(row as usize - 2).copied());
    let source = sources
        .iter()
        .find(|source| error.column.as_deref() == Some(source.target.name()));
    if let Some(source) = source {
        error.column = Some(format!(
            "{} (for {})",
            log.columns[source.column].name,
            source.target.name()
        ));
    }
    error
}

/// Names of the runs: the log's, or by the motion.
fn runs_of(
    log: &Log,
    sources: &[Source],
    order: &Order,
    t_s: &[f64],
    (segments, values, pitch_m): (&[Segment], &[Values], f64),
    told: &mut Told,
) -> Vec<String> {
    if let Some(source) = sources.iter().find(|source| source.target == Target::Run) {
        let column = &log.columns[source.column];
        told.runs_by = format!("the column {}", column.name);
        let mut names: Vec<String> = column
            .numbers
            .iter()
            .map(|number| {
                if number.is_nan() {
                    String::new()
                } else {
                    format!("{number}")
                }
            })
            .collect();
        for (row, word) in &column.words {
            names[*row] = word
                .chars()
                .filter(|letter| !letter.is_control())
                .collect::<String>()
                .trim()
                .to_owned();
        }
        return names;
    }
    let (place, noise) = motion(segments, values, pitch_m);
    let (way, names) = runs::names(order.runs, t_s, &place, noise);
    told.runs_by = way.to_string();
    if order.runs == Runs::Found {
        told.assume(
            format!("runs are separated by {way}"),
            "--runs rests, reversals, one or column:NAME",
        );
    }
    names
}

/// The path that travels furthest, of the references or else of the segments, pitches, and its noise.
fn motion(segments: &[Segment], values: &[Values], pitch_m: f64) -> (Vec<f64>, f64) {
    let travel = |path: &Vec<f64>| {
        let finite = || path.iter().copied().filter(|place| place.is_finite());
        finite().fold(f64::NEG_INFINITY, f64::max) - finite().fold(f64::INFINITY, f64::min)
    };
    let noise = |segment: &Segment| {
        let size = if segment.counts.is_some() {
            std::f64::consts::TAU * segment.amplitude_counts
        } else {
            pitch_m
        };
        segment.noise.map_or(0.0, |noise| noise.rms / size)
    };
    let references = values
        .iter()
        .filter(|values| matches!(values.column, Column::Reference(0 | 1)));
    let references = references.map(|values| {
        (
            values.values.iter().map(|value| value / pitch_m).collect(),
            0.0,
        )
    });
    let own = segments
        .iter()
        .map(|segment| (segment.place.clone(), noise(segment)));
    let paths: Vec<(Vec<f64>, f64)> = references.chain(own).collect();
    let furthest = paths
        .iter()
        .map(|(path, _)| travel(path))
        .fold(0.0, f64::max);
    paths
        .into_iter()
        // The first that travels as far: a reference, where there is one.
        .find(|(path, _)| travel(path) >= (1.0 - SAME_TRAVEL) * furthest)
        .unwrap_or_default()
}

fn samples(t_s: &[f64], runs: &[String], segments: &[Segment], values: &[Values]) -> Samples {
    let mut samples = Samples::default();
    let known = |value: f64| (!value.is_nan()).then_some(value);
    let of = |column: Column, row: usize| {
        values
            .iter()
            .find(|values| values.column == column)
            .and_then(|values| known(values.values[row]))
    };
    for (row, t_s) in t_s.iter().enumerate() {
        let mut sample = Row {
            t_s: *t_s,
            run: &runs[row],
            ..Row::default()
        };
        for segment in segments {
            let number = segment.number;
            if let Some([sine, cosine]) = &segment.counts {
                // A count without its tooth, or a tooth without its count, is no output.
                let pair = known(sine[row])
                    .zip(known(cosine[row]))
                    .zip(known(segment.teeth[row]));
                sample.quadrature_counts[number] = pair.map(|((sine, cosine), _)| [sine, cosine]);
                sample.teeth[number] = pair.map(|(_, teeth)| teeth as i32);
            }
            sample.position_m[number] = segment
                .position_m
                .as_ref()
                .and_then(|position| known(position[row]));
        }
        let electrodes: [Option<f64>; 4] =
            std::array::from_fn(|electrode| of(Column::Electrode(electrode), row));
        sample.electrode_counts = match electrodes {
            [Some(xp), Some(xn), Some(yp), Some(yn)] => Some([xp, xn, yp, yn]),
            _ => None,
        };
        sample.temperature_c = of(Column::Temperature, row);
        sample.commanded = std::array::from_fn(|axis| of(Column::Commanded(axis), row));
        sample.reference = std::array::from_fn(|axis| of(Column::Reference(axis), row));
        samples.push(&sample);
    }
    samples
}
