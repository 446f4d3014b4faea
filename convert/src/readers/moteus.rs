//! moteus: the readings of a calibration, as `moteus_tool --calibrate --cal-write-raw FILE` keeps them, and what else it writes of one.
//!
//! `CAL start`, then a line a reading, `DIRECTION PHASE ENCODER` and currents as `i1=12`, then `CAL done`. Phase and encoder are of 65536
//! to a turn, the phase to an electrical one.

use super::beside::first_lines;
use crate::table::{Log, LogColumn};
use crate::text::decode;
use recording::{Error, excerpt};
use std::path::Path;

/// Steps of a turn, electrical or of the encoder.
const TURN: f64 = 65_536.0;
/// Why times are missing, and what to do.
const NO_TIME: &str = "--rate-hz HZ, readings a second: moteus keeps no times of a calibration; any rate will do where speed does not matter, as --rate-hz 100";

/// How readings of an encoder are had.
pub const HOW_TO_RECORD: &str = "moteus_tool --calibrate --cal-write-raw FILE, let run to its end";

/// True of all of these files.
pub fn is_it(bytes: &[u8]) -> bool {
    first_lines(bytes).next().is_some_and(begins) || is_report(bytes) || is_of_halls(bytes)
}

/// What `--cal-write-raw` keeps of a calibration of Hall sensors (`--cal-hall`): pairs of a phase and the state of three switches.
fn is_of_halls(bytes: &[u8]) -> bool {
    /// Three switches, by definition.
    const STATES: u64 = 8;
    let pairs: Option<Vec<(f64, u64)>> = serde_json::from_slice(bytes).ok();
    pairs.is_some_and(|pairs| !pairs.is_empty() && pairs.iter().all(|pair| pair.1 < STATES))
}

fn begins(line: &str) -> bool {
    ["CAL start", "CALI start"]
        .iter()
        .any(|begin| line.starts_with(begin))
}

/// The JSON of a calibration, which `moteus_tool` writes in any case.
fn is_report(bytes: &[u8]) -> bool {
    let text = String::from_utf8_lossy(&bytes[..bytes.len().min(1 << 16)]);
    text.trim_start().starts_with('{')
        && text.contains("\"device_info\"")
        && text.contains("\"calibration\"")
}

/// The readings: `direction`, `encoder` and `phase` in turns, counted on over the ends of a turn, and currents in mA.
///
/// # Errors
/// A line that is no reading, or a file that holds none.
pub fn read(file: &Path, bytes: &[u8]) -> Result<Log, Error> {
    if is_report(bytes) {
        let wanted =
            "the readings, which `moteus_tool --calibrate --cal-write-raw FILE` writes as well";
        return Err(Error::new(
            file,
            "moteus_tool's report of a calibration, without readings",
            wanted,
        ));
    }
    if is_of_halls(bytes) {
        let wanted =
            "readings of an encoder: without --cal-hall `--cal-write-raw FILE` writes them";
        let found = "states of Hall sensors, six in a turn of the field";
        return Err(Error::new(file, found, wanted));
    }
    let text = decode(bytes);
    let mut names = vec![
        "direction".to_owned(),
        "phase".to_owned(),
        "encoder".to_owned(),
    ];
    let (mut rows, mut lines, mut done): (Vec<Vec<f64>>, Vec<u64>, bool) =
        (Vec::new(), Vec::new(), false);
    for (place, line) in text
        .lines()
        .enumerate()
        .filter(|(_, line)| !line.trim().is_empty())
        .skip(1)
    {
        done |= ["CAL done", "CALI done"]
            .iter()
            .any(|end| line.starts_with(end));
        if done {
            break;
        }
        match reading(line, &mut names) {
            Some(row) => {
                rows.push(row);
                lines.push(place as u64 + 1);
            }
            None if place + 1 == text.lines().count() => break,
            None => {
                return Err(Error::new(
                    file,
                    excerpt(line.as_bytes()),
                    "DIRECTION PHASE ENCODER, whole numbers",
                )
                .row(place as u64 + 1));
            }
        }
    }
    let of = |place: usize| {
        rows.iter()
            .map(|row| row.get(place).copied().unwrap_or(f64::NAN))
            .collect::<Vec<f64>>()
    };
    let column =
        |name: &str, unit: Option<&str>, numbers: Vec<f64>, hint: Option<String>| LogColumn {
            name: name.to_owned(),
            unit: unit.map(str::to_owned),
            numbers,
            hint,
            ..LogColumn::default()
        };
    let (phase, encoder) = (joined(of(1)), joined(of(2)));
    let pairs = pole_pairs(&phase, &encoder, &of(0));
    let reference = pairs.map(|pairs| format!("ref_x_m=phase:turn/{pairs}"));
    let mut columns = vec![
        column("direction", None, of(0), Some("run=direction".into())),
        column("phase", Some("turn"), phase, reference),
        column(
            "encoder",
            Some("turn"),
            encoder,
            Some("p1_m=encoder:turn".into()),
        ),
    ];
    columns.extend((3..names.len()).map(|place| column(&names[place], None, of(place), None)));
    let mut log = Log::of_columns(columns);
    (log.form, log.lines, log.cut_short, log.no_time) = (
        "readings of moteus' calibration",
        lines,
        !done,
        Some(NO_TIME),
    );
    if let Some(pairs) = pairs {
        log.notes.push(format!("phase and encoder were counted on over the ends of a turn; a turn of the encoder is {pairs} of the phase"));
    }
    Ok(log)
}

fn reading(line: &str, names: &mut Vec<String>) -> Option<Vec<f64>> {
    let mut words = line.split_whitespace();
    let mut row = Vec::new();
    for _ in 0..3 {
        row.push(f64::from(words.next()?.parse::<i32>().ok()?));
    }
    for word in words {
        let (name, value) = word.split_once('=')?;
        let place = names
            .iter()
            .position(|known| known == name)
            .unwrap_or_else(|| {
                names.push(name.to_owned());
                names.len() - 1
            });
        row.resize(row.len().max(place + 1), f64::NAN);
        row[place] = value.parse().ok()?;
    }
    Some(row)
}

/// Steps as turns, counted on where they begin anew.
fn joined(mut steps: Vec<f64>) -> Vec<f64> {
    let (mut whole, mut last): (f64, Option<f64>) = (0.0, None);
    for step in &mut steps {
        if let Some(last) = last {
            whole -= ((*step - last) / TURN).round();
        }
        last = Some(*step);
        *step = *step / TURN + whole;
    }
    steps
}

/// Electrical turns of one of the encoder, where they are a whole number of it; from the way there, as `moteus_tool` has it.
fn pole_pairs(phase: &[f64], encoder: &[f64], direction: &[f64]) -> Option<i64> {
    let there: Vec<usize> = (0..phase.len())
        .filter(|row| direction[*row] == direction[0])
        .collect();
    let way = |path: &[f64]| Some(path[*there.last()?] - path[*there.first()?]);
    let ratio = way(phase)? / way(encoder)?;
    /// As moteus_tool's max_remainder_error.
    const WHOLE: f64 = 0.1;
    let pairs = ratio.round();
    (pairs != 0.0 && (ratio - pairs).abs() < WHOLE).then_some(pairs as i64)
}
