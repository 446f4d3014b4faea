//! Where a column of the recording comes from: `--column ref_x_m=stage:mm*-1`.

use crate::table::Log;
use crate::units::{Quantity, Unit, name_without_unit, unit_in_name};
use recording::{Column, INDEX};

/// A column of the recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// One of numbers.
    Numbers(Column),
    /// `run`.
    Run,
    /// The index of an encoder, which a recording keeps as [`recording::INDEX`].
    Index,
}

impl Target {
    /// The column of this name, capitals or not.
    #[must_use]
    pub fn by_name(name: &str) -> Option<Self> {
        let name = name.trim().to_ascii_lowercase();
        match name.as_str() {
            "run" => Some(Self::Run),
            INDEX => Some(Self::Index),
            _ => Column::by_name(&name).map(Self::Numbers),
        }
    }

    /// Its name in the recording.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Numbers(column) => column.name(),
            Self::Run => "run",
            Self::Index => INDEX,
        }
    }
}

/// What was asked for with one `--column`: `TARGET=NAME[:UNIT][*FACTOR|/DIVISOR|+SUM|-DIFFERENCE]…`.
#[derive(Clone, Debug, PartialEq)]
pub struct Asked {
    /// The recording's column.
    pub target: Target,
    /// What stands after the `=`. What of it is the name of a column is known once the log is.
    pub source: String,
}

impl Asked {
    /// Takes `TARGET=SOURCE` apart.
    ///
    /// # Errors
    /// What was found and wanted, in words.
    pub fn parse(text: &str) -> Result<Self, String> {
        let (target, source) = text
            .split_once('=')
            .filter(|(_, source)| !source.trim().is_empty())
            .ok_or("wanted TARGET=COLUMN, as in q1s=sin or ref_x_m=stage:mm")?;
        // In a log such a name is as often that of a row's number.
        let of_index = target.trim().eq_ignore_ascii_case("index");
        let known = if of_index {
            Some(Target::Index)
        } else {
            Target::by_name(target)
        };
        let target = known.ok_or_else(|| {
            format!(
                "{target}: no column of a recording, wanted t_s, run, index, q1s, q1c, n1, p1_m (to q4s, …), psd_xp, psd_xn, psd_yp, \
                 psd_yn, temp_c, ref_x_m, ref_y_m, ref_theta_rad, cmd_x_m, cmd_y_m or cmd_theta_rad"
            )
        })?;
        Ok(Self {
            target,
            source: source.trim().to_owned(),
        })
    }
}

/// A step of arithmetic, done in the log's own unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Step {
    /// `*2`
    Times(f64),
    /// `+2`, and `-2` with a negative number.
    Plus(f64),
}

/// How one column of the log becomes one of the recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Source {
    /// The recording's column.
    pub target: Target,
    /// Index of the log's column.
    pub column: usize,
    /// Its unit.
    pub unit: Unit,
    /// True where neither `--column` nor the log says the unit.
    pub unit_assumed: bool,
    /// True where the unit was read from the log's header.
    pub unit_from_log: bool,
    /// Arithmetic, from left to right.
    pub steps: Vec<Step>,
}

impl Source {
    /// The values in the recording's unit, or in turns of a shaft where the unit is of a turn.
    #[must_use]
    pub fn values(&self, log: &Log) -> Vec<f64> {
        let numbers = &log.columns[self.column].numbers;
        numbers
            .iter()
            .map(|number| self.stepped(*number) * self.unit.factor + self.unit.offset)
            .collect()
    }

    /// A value after the arithmetic, in the log's unit.
    #[must_use]
    pub fn stepped(&self, number: f64) -> f64 {
        self.steps.iter().fold(number, |value, step| match step {
            Step::Times(factor) => value * factor,
            Step::Plus(sum) => value + sum,
        })
    }

    /// `stage:mm*-1`: what `--column` would say of it.
    #[must_use]
    pub fn text(&self, log: &Log, unit: &Unit, more: &str) -> String {
        let name = &log.columns[self.column].name;
        let steps: String = self
            .steps
            .iter()
            .map(|step| match step {
                Step::Times(factor) => format!("*{factor}"),
                Step::Plus(sum) if *sum < 0.0 => format!("{sum}"),
                Step::Plus(sum) => format!("+{sum}"),
            })
            .collect();
        format!(
            "--column {}",
            quoted(&format!(
                "{}={name}:{}{steps}{more}",
                self.target.name(),
                unit.name
            ))
        )
    }
}

/// An argument as a shell takes it.
#[must_use]
pub fn quoted(argument: &str) -> String {
    let plain = |letter: char| letter.is_alphanumeric() || "_-+=:./".contains(letter);
    match argument.chars().all(plain) {
        true => argument.to_owned(),
        false => format!("'{}'", argument.replace('\'', "'\\''")),
    }
}

/// Finds what was asked for in a log. The longest name that fits is taken, so that a name may hold any letter.
///
/// # Errors
/// What was found and wanted, in words.
pub fn resolve(log: &Log, asked: &Asked) -> Result<Source, (String, String)> {
    let text = asked.source.as_str();
    let ends = text
        .char_indices()
        .filter(|(_, letter)| ":*/+-".contains(*letter))
        .map(|(place, _)| place);
    let ends: Vec<usize> = std::iter::once(text.len())
        .chain(ends.collect::<Vec<_>>().into_iter().rev())
        .collect();
    for end in ends {
        if let Some(column) = column_named(log, &text[..end])? {
            return with_suffix(log, asked.target, column, &text[end..]);
        }
    }
    let name = text.split([':', '*', '/']).next().unwrap_or(text);
    Err((
        format!("no column \"{name}\""),
        format!("one of {}", names(log)),
    ))
}

/// Names of a log's columns, for a message.
#[must_use]
pub fn names(log: &Log) -> String {
    /// More names than these are only counted: a message is one line.
    const NAMED: usize = 20;
    let mut names: Vec<String> = log
        .columns
        .iter()
        .take(NAMED)
        .map(|column| format!("\"{}\"", column.name))
        .collect();
    if log.columns.len() > NAMED {
        names.push(format!("{} more", log.columns.len() - NAMED));
    }
    names.join(", ")
}

/// The column of this name: as it stands, else capitals or not, else without a unit in brackets, else by what
/// stands behind a point, as `angle` for `axis0.angle`; `#3` is the third.
fn column_named(log: &Log, name: &str) -> Result<Option<usize>, (String, String)> {
    let name = name.trim();
    let ends = |known: &str| {
        let before = known.len().checked_sub(name.len() + 1)?;
        let end = known.get(before..)?.strip_prefix('.')?;
        end.eq_ignore_ascii_case(name).then_some(())
    };
    let ways: [&dyn Fn(&str) -> bool; 4] = [
        &|known| known == name,
        &|known| known.eq_ignore_ascii_case(name),
        &|known| name_without_unit(known).eq_ignore_ascii_case(name) && !name.is_empty(),
        &|known| ends(known).is_some() && !name.is_empty(),
    ];
    for way in ways {
        let mut found = (0..log.columns.len()).filter(|place| way(&log.columns[*place].name));
        match (found.next(), found.next()) {
            (None, _) => {}
            (Some(column), None) => return Ok(Some(column)),
            (Some(first), Some(second)) => {
                let wanted = format!("its number, #{} or #{}", first + 1, second + 1);
                return Err((format!("two columns \"{name}\""), wanted));
            }
        }
    }
    let number = name
        .strip_prefix('#')
        .and_then(|number| number.parse::<usize>().ok());
    Ok(number
        .and_then(|number| number.checked_sub(1))
        .filter(|place| *place < log.columns.len()))
}

fn with_suffix(
    log: &Log,
    target: Target,
    column: usize,
    suffix: &str,
) -> Result<Source, (String, String)> {
    let Target::Numbers(of) = target else {
        return match suffix {
            "" => Ok(Source {
                target,
                column,
                unit: Quantity::Teeth.default_unit(),
                unit_assumed: false,
                unit_from_log: false,
                steps: Vec::new(),
            }),
            _ => Err((
                format!("\"{suffix}\" after a column that is taken as it is"),
                "the name of a column alone".into(),
            )),
        };
    };
    let quantity = Quantity::of(of);
    let (unit, rest) = match suffix.strip_prefix(':') {
        None => (None, suffix),
        Some(after) => {
            let end = after.find(['*', '/', '+', '-']).unwrap_or(after.len());
            let name = &after[..end];
            let unit = quantity.unit(name).ok_or_else(|| {
                (
                    format!("the unit \"{name}\""),
                    format!("one of {}", quantity.unit_names()),
                )
            })?;
            (Some(unit), &after[end..])
        }
    };
    let told = &log.columns[column];
    let from_log = || {
        told.unit
            .as_deref()
            .and_then(|unit| quantity.unit(unit))
            .or_else(|| unit_in_name(quantity, &told.name))
    };
    let logged = if unit.is_none() { from_log() } else { None };
    Ok(Source {
        target,
        column,
        unit: unit.or(logged).unwrap_or_else(|| quantity.default_unit()),
        unit_assumed: unit.is_none() && logged.is_none(),
        unit_from_log: logged.is_some(),
        steps: steps(rest)?,
    })
}

/// `*-1+0.5` from left to right.
fn steps(text: &str) -> Result<Vec<Step>, (String, String)> {
    let refuse = || {
        (
            format!("\"{text}\""),
            "*FACTOR, /DIVISOR, +SUM or -DIFFERENCE, as in *-1".to_owned(),
        )
    };
    let mut steps = Vec::new();
    let mut rest = text.trim();
    while let Some(sign) = rest.chars().next() {
        let after = rest
            .get(1..)
            .filter(|_| "*/+-".contains(sign))
            .ok_or_else(refuse)?;
        let length = number_length(after);
        let value: f64 = after[..length].trim().parse().map_err(|_| refuse())?;
        let usable = value.is_finite() && (value != 0.0 || "+-".contains(sign));
        steps.push(match sign {
            _ if !usable => return Err(refuse()),
            '*' => Step::Times(value),
            '/' => Step::Times(1.0 / value),
            '+' => Step::Plus(value),
            _ => Step::Plus(-value),
        });
        rest = after[length..].trim_start();
    }
    Ok(steps)
}

/// Bytes of the number with which a text begins.
fn number_length(text: &str) -> usize {
    let mut before = ' ';
    for (place, letter) in text.char_indices() {
        let sign = "+-".contains(letter) && (place == 0 || "eE".contains(before));
        if !(sign || letter.is_ascii_digit() || ".eE".contains(letter)) {
            return place;
        }
        before = letter;
    }
    text.len()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn log() -> Log {
        Log::read(
            Path::new("log.csv"),
            "t;stage [mm];a-b:c;twice;twice;V_1;axis0.angle\n0;1;2;3;4;5;6\n1;1;2;3;4;5;6\n",
        )
        .unwrap()
    }

    fn found(text: &str) -> Result<(usize, &'static str, Vec<f64>), String> {
        let log = log();
        let source = resolve(&log, &Asked::parse(text)?)
            .map_err(|(found, wanted)| format!("{found}; {wanted}"))?;
        Ok((source.column, source.unit.name, source.values(&log)))
    }

    #[test]
    fn names_units_and_arithmetic() {
        for (text, column, unit, value) in [
            ("ref_x_m=stage [mm]", 1, "mm", 1e-3),
            ("ref_x_m=stage", 1, "mm", 1e-3),
            ("REF_X_M=Stage:um*-2", 1, "um", -2e-6),
            ("ref_x_m=stage:m/4+1", 1, "m", 1.25),
            ("ref_x_m=stage:m-1e-3", 1, "m", 0.999),
            ("ref_x_m=stage*1e+2*3", 1, "mm", 0.3),
            ("q1s=a-b:c", 2, "counts", 2.0),
            ("q1s=a-b:c:V-2", 2, "V", 0.0),
            ("q1s=#4", 3, "counts", 3.0),
            ("ref_x_m=stage:turn/2", 1, "turn", 0.5),
            ("q1s=angle*2", 6, "counts", 12.0),
        ] {
            let (at, name, values) = found(text).unwrap();
            assert_eq!((at, name), (column, unit), "{text}");
            assert!((values[0] - value).abs() < 1e-12, "{text}: {values:?}");
        }
    }

    #[test]
    fn what_cannot_be_meant_is_told() {
        for (text, told) in [
            ("ref_x_m", "wanted TARGET=COLUMN"),
            ("ref_x=stage", "no column of a recording"),
            ("ref_x_m=table:mm", "no column \"table\""),
            ("ref_x_m=stage:kg", "the unit \"kg\""),
            ("ref_x_m=stage*", "*FACTOR"),
            ("ref_x_m=stage*0", "*FACTOR"),
            ("ref_x_m=stage:mmµ", "the unit"),
            ("q1s=twice", "#4 or #5"),
            ("q1s=#9", "no column"),
            ("run=stage:mm", "alone"),
        ] {
            let error = found(text).unwrap_err();
            assert!(error.contains(told), "{text}: {error}");
        }
    }
}
