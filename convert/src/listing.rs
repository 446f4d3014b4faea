//! What a log holds, and the options that a first conversion may have.

use crate::mapping::named_as_time;
use crate::source::{Asked, Target, quoted};
use crate::table::{Log, LogColumn};
use crate::units::{Quantity, name_without_unit, unit_in_name};
use recording::Column;

/// One column of a log.
#[derive(Clone, Debug, PartialEq)]
pub struct Listed {
    /// Its name.
    pub name: String,
    /// Rows that hold a number.
    pub numbers: usize,
    /// Rows that hold a word.
    pub words: usize,
    /// Lowest and highest number; none without one.
    pub range: Option<[f64; 2]>,
    /// What it may be, as options would say it.
    pub guess: Option<String>,
}

/// What each column holds, with guesses by names.
#[must_use]
pub fn listing(log: &Log) -> Vec<Listed> {
    let guesses = guesses(log);
    let listed = |(column, guess): (&LogColumn, &Option<String>)| {
        let numbers = column
            .numbers
            .iter()
            .copied()
            .filter(|number| number.is_finite());
        let range = numbers
            .clone()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], n| {
                [low.min(n), high.max(n)]
            });
        Listed {
            name: column.name.clone(),
            numbers: numbers.count(),
            words: column.words.len(),
            range: (range[0] <= range[1]).then_some(range),
            guess: guess.clone(),
        }
    };
    log.columns.iter().zip(&guesses).map(listed).collect()
}

/// Words in a column's name by which it is guessed, the more telling first.
const SINES: [&str; 3] = ["sine", "sin", "chs"];
const COSINES: [&str; 3] = ["cosine", "cos", "chc"];
const TEMPERATURES: [&str; 2] = ["temp", "temperature"];
const REFERENCES: [&str; 8] = [
    "ref",
    "reference",
    "stage",
    "laser",
    "interferometer",
    "true",
    "stepper",
    "steps",
];
const POSITIONS: [&str; 5] = ["encoder", "position", "pos", "angle", "enc"];
/// Of an encoder's messages these are no positions.
const RATES: [&str; 4] = ["vel", "velocity", "speed", "acceleration"];

fn is_called(name: &str, words: &[&str]) -> bool {
    let small = name.to_lowercase();
    small
        .split(|letter: char| !letter.is_alphabetic())
        .any(|part| words.contains(&part))
}

/// `--column …` for each column that its name tells something of.
fn guesses(log: &Log) -> Vec<Option<String>> {
    let mut taken: Vec<Target> = Vec::new();
    let mut guesses = vec![None; log.columns.len()];
    let has_pair = log
        .columns
        .iter()
        .any(|column| is_called(&column.name, &SINES));
    for (place, column) in log.columns.iter().enumerate() {
        if let Some(target) = Target::by_name(&column.name) {
            taken.push(target);
            guesses[place] = Some(format!("is {}", target.name()));
            continue;
        }
        let Some(target) = of_column(column, has_pair) else {
            continue;
        };
        let same = |other: &&LogColumn| of_column(other, has_pair) == Some(target);
        let mut rest = log.columns[place..].iter().filter(same);
        let may_stand_still = target == Target::Numbers(Column::Temperature);
        let is_meant = may_stand_still || moves(column) || !rest.any(moves);
        let hint = hint_of(column).map(|(hint, _)| hint);
        let has_values = hint.is_some() || has_values(column, may_stand_still);
        if !taken.contains(&target) && is_meant && has_values {
            taken.push(target);
            guesses[place] = Some(match hint {
                Some(hint) => format!("--column {}", quoted(hint)),
                None => option(target, column),
            });
        }
    }
    guesses
}

/// What a column may be: by what its program calls it, or by words in its name.
fn of_column(column: &LogColumn, has_pair: bool) -> Option<Target> {
    let by_words = || target_by_words(&column.name, has_pair).map(Target::Numbers);
    hint_of(column).map(|(_, target)| target).or_else(by_words)
}

/// What the log's program is known to mean by a column, as an option says it, and what that gives.
fn hint_of(column: &LogColumn) -> Option<(&str, Target)> {
    let hint = column.hint.as_deref()?;
    Some((hint, Asked::parse(hint).ok()?.target))
}

/// What a column may be by words in its name; `has_pair` where the log has sines and cosines, beside which positions follow from these.
fn target_by_words(name: &str, has_pair: bool) -> Option<Column> {
    let target = if named_as_time(name) {
        Column::Time
    } else if is_called(name, &SINES) {
        Column::Sine(0)
    } else if is_called(name, &COSINES) {
        Column::Cosine(0)
    } else if is_called(name, &TEMPERATURES) {
        Column::Temperature
    } else if is_called(name, &REFERENCES) {
        Column::Reference(0)
    } else if is_called(name, &POSITIONS) && !is_called(name, &RATES) && !has_pair {
        Column::Position(0)
    } else {
        return None;
    };
    Some(target)
}

/// True of a column that goes farther than its own jitter: of several drives in one log the first that moves is the one that was meant.
/// White noise of deviation `s` in `n` rows has second differences of `√6 s` rms and reaches `√(2 ln n) s` to either side.
fn moves(column: &LogColumn) -> bool {
    let finite = column.numbers.iter().copied().filter(|n| n.is_finite());
    let numbers: Vec<f64> = finite.collect();
    let (low, high) = numbers
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), n| {
            (low.min(*n), high.max(*n))
        });
    let second_differences = numbers.windows(3).map(|w| w[0] - 2.0 * w[1] + w[2]);
    let squares: f64 = second_differences.map(|d| d * d).sum();
    let rows = numbers.len() as f64;
    let deviation = (squares / (6.0 * (rows - 2.0).max(1.0))).sqrt();
    high - low > 2.0 * (2.0 * rows.ln()).sqrt() * deviation
}

/// True of a column with a number, and where it may not stand still with another one: a flag is no reading of a motion.
fn has_values(column: &LogColumn, may_stand_still: bool) -> bool {
    let mut numbers = column.numbers.iter().filter(|number| !number.is_nan());
    let first = numbers.next();
    first.is_some_and(|first| may_stand_still || numbers.any(|number| number != first))
}

fn option(target: Target, column: &LogColumn) -> String {
    let Target::Numbers(of) = target else {
        return String::new();
    };
    let quantity = Quantity::of(of);
    let known = column
        .unit
        .as_deref()
        .and_then(|unit| quantity.unit(unit))
        .or_else(|| unit_in_name(quantity, &column.name));
    let unit = match (quantity, known) {
        (_, Some(unit)) => format!(":{}", unit.name),
        (Quantity::Length | Quantity::Time | Quantity::Temperature, None) => ":UNIT".into(),
        _ => String::new(),
    };
    let name = match column.name.contains(['[', '(']) {
        true => name_without_unit(&column.name),
        false => &column.name,
    };
    format!(
        "--column {}",
        quoted(&format!("{}={name}{unit}", target.name()))
    )
}

/// What to do where no column is an output of the sensor by its name, and the log's program is known.
#[must_use]
pub fn lacks(log: &Log) -> Option<String> {
    let is_output = |guess: &String| OUTPUTS.into_iter().any(|name| gives(guess, name));
    let lacks = !guesses(log).iter().flatten().any(is_output);
    lacks
        .then(|| log.told_how())
        .filter(|how| !how.is_empty())
        .map(|how| format!("no column is the sensor's output by its name{how}"))
}

/// Outputs of the segments that a first conversion may have.
const OUTPUTS: [&str; 4] = ["q1s", "p1_m", "q2s", "p2_m"];

/// True of a guess that a column is this one of the recording.
fn gives(guess: &str, name: &str) -> bool {
    guess.contains(&format!("{name}=")) || guess == format!("is {name}")
}

/// The command line to begin with. What only the user knows stands in capitals.
#[must_use]
pub fn suggestion(log: &Log, file: &str) -> String {
    let guesses: Vec<String> = guesses(log).into_iter().flatten().collect();
    let mut options: Vec<String> = guesses
        .iter()
        .filter(|guess| guess.starts_with("--"))
        .cloned()
        .collect();
    let has = |name: &str| guesses.iter().any(|guess| gives(guess, name));
    if !has("t_s") {
        options.insert(0, "--rate-hz HZ".into());
    }
    if !OUTPUTS.into_iter().any(has) {
        options.push("--column q1s=SINE --column q1c=COSINE".into());
    }
    if !["ref_x_m", "ref_y_m", "q4s", "p4_m"].into_iter().any(has) {
        options.push("--column ref_x_m=REFERENCE:UNIT".into());
    }
    let rotary = guesses.iter().any(|guess| {
        Quantity::Angle
            .units()
            .iter()
            .any(|unit| guess.ends_with(&format!(":{}", unit.name)))
    });
    options.push(if rotary {
        "--periods-per-turn N".into()
    } else {
        "--pitch LENGTH".into()
    });
    format!("courier convert {} OUT {}", quoted(file), options.join(" "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn columns_are_guessed_by_their_names() {
        let log = Log::read(
            Path::new("log.csv"),
            "time_ms;Sin;Cos;stage [µm];mode\n0;1;2;3;up\n1;2;3;4;up\n",
        )
        .unwrap();
        assert_eq!(
            suggestion(&log, "my log.csv"),
            "courier convert 'my log.csv' OUT --column t_s=time_ms:ms --column q1s=Sin --column q1c=Cos --column ref_x_m=stage:um --pitch LENGTH"
        );
        let listed = listing(&log);
        assert_eq!((listed[4].words, listed[4].range), (2, None));
        assert_eq!(listed[3].range, Some([3.0, 4.0]));
        // A flag is no reference.
        let log = Log::read(Path::new("log.csv"), "reference;Encoder\n1;2\n1;3\n").unwrap();
        assert!(
            suggestion(&log, "a")
                .contains("--column p1_m=Encoder:UNIT --column ref_x_m=REFERENCE:UNIT")
        );
        let log = Log::read(Path::new("log.csv"), "0;1;2\n1;2;3\n").unwrap();
        assert!(suggestion(&log, "a").contains(
            "--rate-hz HZ --column q1s=SINE --column q1c=COSINE --column ref_x_m=REFERENCE:UNIT"
        ));
    }
}
