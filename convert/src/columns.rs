//! Values of the log in the recording's units.

use crate::order::Order;
use crate::source::{Source, Target};
use crate::table::Log;
use crate::told::{Told, figures};
use recording::{Column, Error, INDEX, Logged};
use std::path::Path;

/// A column of the recording: where it comes from, and its values.
#[derive(Clone, Debug, PartialEq)]
pub struct Values {
    /// The recording's column.
    pub column: Column,
    /// Where it comes from.
    pub source: Source,
    /// One a row, in the recording's unit; NaN where not measured. Counts are in the log's unit still.
    pub values: Vec<f64>,
}

/// A length that one period of a rotary sensor is written as where nothing is stated.
pub const ROTARY_PITCH_M: f64 = 1.0e-3;

/// Length of a signal period, m.
///
/// # Errors
/// None is stated, and no column is an angle: then it is a length of the sensor's, which nothing in the log tells.
pub fn pitch_m(
    file: &Path,
    sources: &[Source],
    order: &Order,
    told: &mut Told,
) -> Result<f64, Error> {
    if let Some(pitch_m) = order.pitch_m {
        return Ok(pitch_m);
    }
    if sources.iter().any(|source| source.unit.of_turn) {
        told.assume(
            "one signal period is written as a length of 1 mm",
            "--pitch LENGTH",
        );
        return Ok(ROTARY_PITCH_M);
    }
    let wanted = "--pitch LENGTH, the length of one signal period, as in --pitch 1.016mm (for an encoder on a shaft give the \
                  reference as an angle, as in --column ref_x_m=COLUMN:deg)";
    Err(Error::new(file, "no length of a signal period", wanted))
}

/// Values of every column of numbers.
///
/// # Errors
/// A word where a number is wanted.
pub fn values(
    file: &Path,
    log: &Log,
    sources: &[Source],
    order: &Order,
    pitch_m: f64,
    told: &mut Told,
) -> Result<Vec<Values>, Error> {
    let mut all = Vec::new();
    for source in sources {
        let Target::Numbers(column) = source.target else {
            continue;
        };
        let logged = &log.columns[source.column];
        of_numbers(file, log, source)?;
        let mut values = source.values(log);
        if let Some(turn) = source.unit.turn_in_it() {
            let turn = turn * source.unit.factor;
            let passes = unwrap(&mut values, turn);
            if passes > 0 {
                told.did(format!(
                    "{}: angles that begin anew at each turn were joined at {passes} places",
                    logged.name
                ));
            }
        }
        if source.unit.of_turn {
            let periods = order.periods_per_turn.unwrap_or(1.0);
            if order.periods_per_turn.is_none() {
                told.assume(
                    "a turn of the shaft is one signal period",
                    "--periods-per-turn N",
                );
            }
            values
                .iter_mut()
                .for_each(|value| *value *= periods * pitch_m);
            told.did(format!(
                "{}: one turn is written as {} m",
                logged.name,
                figures(periods * pitch_m)
            ));
        }
        all.push(Values {
            column,
            source: source.clone(),
            values,
        });
    }
    // Several angles say the same once.
    told.assumed.dedup();
    Ok(all)
}

/// Refuses a word where numbers are wanted.
fn of_numbers(file: &Path, log: &Log, source: &Source) -> Result<(), Error> {
    let logged = &log.columns[source.column];
    let Some((row, word)) = logged.words.first() else {
        return Ok(());
    };
    let error = Error::new(file, recording::excerpt(word.as_bytes()), "a number");
    Err(error.row(log.lines[*row]).column(&logged.name))
}

/// The index, if one was asked for: as it was logged.
///
/// # Errors
/// A word where a number is wanted.
pub fn index(file: &Path, log: &Log, sources: &[Source]) -> Result<Option<Logged>, Error> {
    let Some(source) = sources.iter().find(|source| source.target == Target::Index) else {
        return Ok(None);
    };
    of_numbers(file, log, source)?;
    Ok(Some(Logged {
        name: INDEX.to_owned(),
        values: log.columns[source.column].numbers.clone(),
    }))
}

/// Joins angles that stay within one turn and jump by over half of it; gives the number of joints. `turn` is one turn in their unit.
fn unwrap(values: &mut [f64], turn: f64) -> usize {
    let finite = || values.iter().copied().filter(|value| value.is_finite());
    let (low, high) = (
        finite().fold(f64::INFINITY, f64::min),
        finite().fold(f64::NEG_INFINITY, f64::max),
    );
    /// An angle that begins anew at each turn spans one turn, and its noise at both ends: so many turns with noise of 1 % of a turn, or
    /// 3.6°, which is beyond that of any encoder. What spans more was counted on from turn to turn already.
    const TURN_WITH_NOISE: f64 = 1.02;
    if !(high - low <= TURN_WITH_NOISE * turn) {
        return 0;
    }
    let (mut whole, mut passes, mut last) = (0.0, 0, f64::NAN);
    for value in values.iter_mut().filter(|value| value.is_finite()) {
        let step = *value - last;
        if step.abs() > 0.5 * turn {
            whole -= step.signum() * turn;
            passes += 1;
        }
        last = *value;
        *value += whole;
    }
    passes
}

/// Times of all rows, s.
///
/// # Errors
/// A time that is missing, or does not rise.
pub fn times_s(
    file: &Path,
    log: &Log,
    values: &[Values],
    order: &Order,
    told: &mut Told,
) -> Result<Vec<f64>, Error> {
    let column = values.iter().find(|values| values.column == Column::Time);
    let (Some(time), None) = (column, order.rate_hz) else {
        let rate_hz = order.rate_hz.unwrap_or(1.0);
        told.did(format!(
            "t_s from the number of the row, at {} rows a second",
            figures(rate_hz)
        ));
        return Ok((0..log.rows()).map(|row| row as f64 / rate_hz).collect());
    };
    let logged = &log.columns[time.source.column];
    let refuse = |row: usize, found: String, wanted: String| {
        Err(Error::new(file, found, wanted)
            .row(log.lines[row])
            .column(&logged.name))
    };
    let hint = "--rate-hz HZ takes the rows as evenly spaced";
    for (row, t_s) in time.values.iter().enumerate() {
        if !t_s.is_finite() {
            return refuse(row, "no time".into(), format!("one in every row; {hint}"));
        }
        if row > 0 && *t_s <= time.values[row - 1] {
            let before = logged.numbers[row - 1];
            return refuse(
                row,
                format!("{}", logged.numbers[row]),
                format!("a time after the row before, {before}; {hint}"),
            );
        }
    }
    Ok(time.values.clone())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_that_begin_anew_are_joined_and_others_are_not() {
        let path: Vec<f64> = (0..1000)
            .map(|k| 2.5 * 360.0 * (0.01 * f64::from(k)).sin())
            .collect();
        let mut wrapped: Vec<f64> = path.iter().map(|angle| angle.rem_euclid(360.0)).collect();
        assert!(unwrap(&mut wrapped, 360.0) > 3);
        assert!(
            path.iter()
                .zip(&wrapped)
                .all(|(path, joined)| (path - joined).abs() < 1e-9)
        );
        let mut whole = path.clone();
        assert_eq!(unwrap(&mut whole, 360.0), 0);
        assert_eq!(whole, path);
        // One that spans more than a turn was counted on already: a jump in it is the shaft's.
        let mut jumps = vec![0.0, 90.0, 300.0, 400.0];
        assert_eq!(unwrap(&mut jumps, 360.0), 0);
        assert_eq!(jumps, [0.0, 90.0, 300.0, 400.0]);
    }
}
