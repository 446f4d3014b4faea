//! Which column of the log becomes which of the recording.

use crate::order::Order;
use crate::source::{Asked, Source, Target, names, resolve};
use crate::table::Log;
use crate::told::Told;
use crate::units::Quantity;
use recording::{COLUMNS, Column, Error};
use std::path::Path;

/// The sources of all columns of the recording: those that were asked for, those whose names are a recording's, and time by its name.
///
/// # Errors
/// A column that the log does not have, a column asked for twice, no time, or no output of any segment.
pub fn sources(
    file: &Path,
    log: &Log,
    order: &Order,
    told: &mut Told,
) -> Result<Vec<Source>, Error> {
    let mut sources: Vec<Source> = Vec::new();
    for asked in &order.columns {
        if sources.iter().any(|source| source.target == asked.target) {
            let found = format!("--column {} twice", asked.target.name());
            return Err(Error::new(file, found, "each column of the recording once"));
        }
        let source = resolve(log, asked).map_err(|(found, wanted)| {
            let option = format!("--column {}={}", asked.target.name(), asked.source);
            let output = matches!(
                asked.target,
                Target::Numbers(Column::Sine(_) | Column::Cosine(_) | Column::Position(_))
            );
            let how = if output {
                log.told_how()
            } else {
                String::new()
            };
            let error = Error::new(file, found, format!("{wanted}, for {option}{how}"));
            if log.dialect.header_line > 0 {
                error.row(log.dialect.header_line as u64)
            } else {
                error
            }
        })?;
        sources.push(source);
    }
    by_name(log, &mut sources);
    if !sources
        .iter()
        .any(|source| source.target == Target::Numbers(Column::Time))
        && order.rate_hz.is_none()
    {
        sources.push(time_by_name(file, log, &sources, told)?);
    }
    complete(file, log, &sources)?;
    for source in sources.iter().filter(|source| source.unit_assumed) {
        let Target::Numbers(column) = source.target else {
            continue;
        };
        if !matches!(Quantity::of(column), Quantity::Teeth | Quantity::Counts)
            && !is_name_of(&log.columns[source.column].name, source.target)
        {
            let what = format!(
                "{} is in {}",
                log.columns[source.column].name, source.unit.name
            );
            told.assume(
                what,
                source
                    .text(log, &source.unit, "")
                    .replace(&format!(":{}", source.unit.name), ":UNIT"),
            );
        }
    }
    sources.sort_by_key(|source| {
        COLUMNS
            .iter()
            .position(|(_, name)| *name == source.target.name())
    });
    Ok(sources)
}

fn is_name_of(name: &str, target: Target) -> bool {
    name.trim().eq_ignore_ascii_case(target.name())
}

/// Columns whose names are a recording's already, capitals or not.
fn by_name(log: &Log, sources: &mut Vec<Source>) {
    for (place, column) in log.columns.iter().enumerate() {
        let Some(target) = Target::by_name(&column.name) else {
            continue;
        };
        let asked = Asked {
            target,
            source: format!("#{}", place + 1),
        };
        if !sources.iter().any(|source| source.target == target)
            && let Ok(mut source) = resolve(log, &asked)
        {
            // Its name ends with the recording's own unit, which is no unit of the log's header.
            source.unit = match target {
                Target::Numbers(of) => log.columns[place]
                    .unit
                    .as_deref()
                    .and_then(|unit| Quantity::of(of).unit(unit))
                    .unwrap_or_else(|| Quantity::of(of).default_unit()),
                Target::Run | Target::Index => source.unit,
            };
            (source.unit_assumed, source.unit_from_log) = (false, false);
            sources.push(source);
        }
    }
}

/// Words with which names of columns of time begin.
const TIMES: [&str; 6] = ["t", "time", "timestamp", "timestamps", "zeit", "seconds"];

/// True if a column is one of time by its name: its first word is one of time.
#[must_use]
pub fn named_as_time(name: &str) -> bool {
    let small = name.trim().to_lowercase();
    let first = small
        .split(|letter: char| !letter.is_alphanumeric())
        .next()
        .unwrap_or("");
    TIMES.contains(&first)
}

/// The one column that is called time and rises.
fn time_by_name(
    file: &Path,
    log: &Log,
    sources: &[Source],
    told: &mut Told,
) -> Result<Source, Error> {
    let missing = || {
        Error::new(
            file,
            "no column of time",
            log.no_time.unwrap_or(
                "--column t_s=COLUMN:UNIT, or --rate-hz HZ where rows are evenly spaced",
            ),
        )
        .row(log.dialect.header_line.max(1) as u64)
    };
    let rises = |place: usize| {
        log.columns[place]
            .numbers
            .windows(2)
            .all(|pair| pair[1] > pair[0])
    };
    let free = |place: &usize| sources.iter().all(|source| source.column != *place);
    let mut called = (0..log.columns.len())
        .filter(|place| named_as_time(&log.columns[*place].name) && rises(*place))
        .filter(free);
    let place = called.next().ok_or_else(missing)?;
    let asked = Asked {
        target: Target::Numbers(Column::Time),
        source: format!("#{}", place + 1),
    };
    let source = resolve(log, &asked).map_err(|_| missing())?;
    if !source.unit_assumed {
        told.assume(
            format!(
                "time is {}, in {}",
                log.columns[place].name, source.unit.name
            ),
            "--column t_s=COLUMN:UNIT",
        );
    }
    Ok(source)
}

/// Columns that make sense only together must be there together.
fn complete(file: &Path, log: &Log, sources: &[Source]) -> Result<(), Error> {
    let has = |column: Column| {
        sources
            .iter()
            .any(|source| source.target == Target::Numbers(column))
    };
    let lacks = |column: Column, why: &str| {
        let wanted = format!("--column {}=COLUMN, {why}", column.name());
        Err(Error::new(
            file,
            format!("nothing for {}", column.name()),
            wanted,
        ))
    };
    for segment in 0..4 {
        let pair = [Column::Sine(segment), Column::Cosine(segment)];
        match pair.map(has) {
            [true, false] => return lacks(pair[1], "since there is its sine"),
            [false, true] => return lacks(pair[0], "since there is its cosine"),
            [false, false] if has(Column::Teeth(segment)) => {
                return lacks(pair[0], "since there is its tooth count");
            }
            _ => {}
        }
    }
    let electrodes: [Column; 4] = std::array::from_fn(Column::Electrode);
    if electrodes.iter().any(|column| has(*column))
        && let Some(absent) = electrodes.iter().find(|column| !has(**column))
    {
        return lacks(*absent, "since there are other electrodes");
    }
    if (0..4).any(|segment| has(Column::Sine(segment)) || has(Column::Position(segment))) {
        return Ok(());
    }
    let wanted = format!(
        "--column q1s=COLUMN --column q1c=COLUMN, or --column p1_m=COLUMN:UNIT; the log has {}{}",
        names(log),
        log.told_how()
    );
    Err(Error::new(file, "nothing for any segment", wanted))
}
