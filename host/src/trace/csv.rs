//! A table of levels: sigrok's CSV, a row a look of the instrument's, or one with a column of times, a row a change, as Saleae's program
//! exports it.

use super::contents::{Contents, frequency_hz};
use anyhow::{Context, Result, bail, ensure};

/// Units of the file: picoseconds.
const UNIT_S: f64 = 1.0e-12;
/// A day: instants of more do not keep their picoseconds.
const LONGEST_S: f64 = 86_400.0;

/// What the head of a table says.
#[derive(Debug, Default, PartialEq)]
struct Head {
    /// Samples a second, by the comment `Samplerate: 24 MHz`.
    rate_hz: Option<f64>,
    /// Names of the channels, by the comment `Channels (2/8): D0, D1`.
    names: Vec<String>,
}

/// Reads it.
///
/// # Errors
/// It is no such table, a level is neither 0 nor 1, or its times fall.
pub fn contents(bytes: &[u8]) -> Result<Contents> {
    let text = std::str::from_utf8(bytes).context("found no text, wanted VCD or CSV")?;
    let head = head(text);
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .comment(Some(b';'))
        .trim(csv::Trim::All)
        .from_reader(bytes);
    let mut records = reader.records();
    let first = records
        .next()
        .context("found no rows, wanted VCD or CSV")??;
    let time = first.get(0).and_then(time_unit_s);
    let names = names(&first, time.is_some(), &head)?;
    let mut channels: Vec<(String, Vec<(u64, bool)>)> =
        names.into_iter().map(|name| (name, vec![])).collect();
    ensure!(
        time.is_some() || head.rate_hz.is_some(),
        "found neither a column of times nor a comment with the sample rate, wanted VCD or CSV with one of both"
    );
    let has_names = first.iter().any(|cell| level(cell).is_none());
    let rows = (!has_names).then_some(Ok(first)).into_iter().chain(records);
    let (mut begin, mut end) = (None, 0);
    for (number, row) in rows.enumerate() {
        let row = row?;
        let line = row.position().map_or(0, csv::Position::line);
        let at =
            instant(&row, number, time, head.rate_hz).with_context(|| format!("line {line}"))?;
        ensure!(
            begin.is_none() || at >= end,
            "line {line}: found a time that falls, wanted times in their order"
        );
        begin.get_or_insert(at);
        end = at;
        let cells = row.iter().skip(usize::from(time.is_some()));
        for ((name, levels), cell) in channels.iter_mut().zip(cells) {
            let Some(high) = level(cell) else {
                bail!("line {line}: found {cell:?} for {name}, wanted 0 or 1");
            };
            if levels.last().is_none_or(|(_, before)| *before != high) {
                levels.push((at, high));
            }
        }
    }
    Ok(Contents {
        channels,
        limits: [begin.unwrap_or(0), end],
        unit_s: UNIT_S,
        rate_hz: head.rate_hz,
    })
}

fn head(text: &str) -> Head {
    let mut head = Head::default();
    for comment in text
        .lines()
        .filter_map(|line| line.trim().strip_prefix(';'))
    {
        let Some((what, value)) = comment.split_once(':') else {
            continue;
        };
        match what.trim() {
            "Samplerate" => head.rate_hz = frequency_hz(value),
            what if what.starts_with("Channels") => {
                head.names = value
                    .split(',')
                    .map(|name| name.trim().to_owned())
                    .collect();
            }
            _ => {}
        }
    }
    head
}

/// The channels' names: those of the first row, unless it says only that they are logic, or has levels already.
fn names(first: &csv::StringRecord, has_time: bool, head: &Head) -> Result<Vec<String>> {
    let cells: Vec<&str> = first.iter().skip(usize::from(has_time)).collect();
    let says_nothing = cells
        .iter()
        .all(|cell| *cell == "logic" || level(cell).is_some());
    if !says_nothing {
        return Ok(cells.into_iter().map(ToOwned::to_owned).collect());
    }
    ensure!(
        head.names.len() == cells.len(),
        "found {} columns of levels and {} names, wanted a row of names",
        cells.len(),
        head.names.len()
    );
    Ok(head.names.clone())
}

/// Unit of a column of times, seconds; none if the column is another.
fn time_unit_s(name: &str) -> Option<f64> {
    let name = name.to_ascii_lowercase();
    let unit = match name.strip_prefix("time") {
        Some(rest) => rest.trim().trim_matches(['[', ']', '(', ')']),
        None => &name,
    };
    match unit {
        "ns" | "nanoseconds" => Some(1.0e-9),
        "us" | "µs" | "microseconds" => Some(1.0e-6),
        "ms" | "milliseconds" => Some(1.0e-3),
        "s" | "seconds" | "" => Some(1.0),
        _ => None,
    }
}

fn instant(
    row: &csv::StringRecord,
    number: usize,
    time: Option<f64>,
    rate_hz: Option<f64>,
) -> Result<u64> {
    let at_s = match time {
        Some(unit_s) => {
            let cell = row.get(0).unwrap_or_default();
            let number: Option<f64> = cell.parse().ok();
            number.with_context(|| format!("found the time {cell:?}, wanted a number"))? * unit_s
        }
        None => number as f64 / rate_hz.unwrap_or(1.0),
    };
    ensure!(
        (0.0..LONGEST_S).contains(&at_s),
        "found the time {at_s} s, wanted 0 to {LONGEST_S} s"
    );
    Ok((at_s / UNIT_S).round() as u64)
}

fn level(cell: &str) -> Option<bool> {
    match cell {
        "0" => Some(false),
        "1" => Some(true),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_of_sigroks_has_its_names_and_rate_in_comments() {
        let text = "; CSV, generated by libsigrok\n; Channels (2/8): CONVST, BUSY\n; Samplerate: 10 MHz\nlogic,logic\n0,0\n1,0\n1,1\n0,1\n";
        let found = contents(text.as_bytes()).unwrap();
        assert_eq!(found.rate_hz, Some(10.0e6));
        assert_eq!(found.limits, [0, 300_000]);
        let wanted = [
            (
                "CONVST".to_owned(),
                vec![(0, false), (100_000, true), (300_000, false)],
            ),
            ("BUSY".to_owned(), vec![(0, false), (200_000, true)]),
        ];
        assert_eq!(found.channels, wanted);
        // Without that row, and with names in it.
        for row in ["", "CONVST,BUSY\n"] {
            let other = contents(text.replace("logic,logic\n", row).as_bytes()).unwrap();
            assert_eq!(other.channels, found.channels, "{row}");
        }
    }

    #[test]
    fn a_table_of_changes_has_a_column_of_times() {
        let text = "Time [s],Channel 0,BUSY\n0.000000000,0,1\n0.000000500,1,1\n0.000001000,1,0\n";
        let found = contents(text.as_bytes()).unwrap();
        assert_eq!(
            found.channels[0],
            ("Channel 0".to_owned(), vec![(0, false), (500_000, true)])
        );
        assert_eq!(
            found.channels[1],
            ("BUSY".to_owned(), vec![(0, true), (1_000_000, false)])
        );
        let in_us = contents("Time [us],BUSY\n1,1\n2.5,0\n".as_bytes()).unwrap();
        assert_eq!(in_us.limits, [1_000_000, 2_500_000]);
    }

    #[test]
    fn what_is_wrong_is_told_with_its_line() {
        let refused = |text: &str, wanted: &str| {
            let told = format!("{:#}", contents(text.as_bytes()).unwrap_err());
            assert!(told.contains(wanted), "{told}");
        };
        refused(
            "Time [s],BUSY\n0,0\n1e-6,0.4\n",
            "line 3: found \"0.4\" for BUSY, wanted 0 or 1",
        );
        refused(
            "Time [s],BUSY\n2e-6,0\n1e-6,1\n",
            "line 3: found a time that falls",
        );
        refused("Time [s],BUSY\nsoon,0\n", "line 2: found the time \"soon\"");
        refused("CONVST,BUSY\n0,0\n", "neither a column of times nor");
        refused(
            "; Samplerate: 1 MHz\n0,0\n",
            "2 columns of levels and 0 names",
        );
        refused("", "no rows");
    }
}
