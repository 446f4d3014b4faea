//! A recording as the instrument's program has written it: VCD, or a table with a column a channel.

use super::contents::Contents;
use super::{Signal, Span, Trace, csv, vcd};
use anyhow::{Context, Result, ensure};
use std::path::Path;

/// Reads a file. `rate_hz`: how often the instrument looked at the levels, if the user says so; otherwise the file does, or all its instants are
/// multiples of the time between two looks.
///
/// # Errors
/// It cannot be read, or is no such file; the error names it.
pub fn read(path: &Path, rate_hz: Option<f64>) -> Result<Trace> {
    let name = path.display().to_string();
    let bytes = std::fs::read(path).with_context(|| format!("{name}: wanted a readable file"))?;
    let first = bytes.iter().find(|byte| !byte.is_ascii_whitespace());
    let contents = match first {
        Some(b'$') => vcd::contents(&bytes),
        _ => csv::contents(&bytes),
    };
    trace(contents.with_context(|| name.clone())?, rate_hz).with_context(|| name)
}

fn trace(contents: Contents, rate_hz: Option<f64>) -> Result<Trace> {
    ensure!(
        !contents.channels.is_empty(),
        "found no channel of levels, wanted some"
    );
    let [begin, end] = contents.limits;
    ensure!(
        end > begin,
        "found a trace without a duration, wanted some microseconds"
    );
    let unit_s = contents.unit_s;
    let step_s = match rate_hz.or(contents.rate_hz) {
        Some(rate_hz) => 1.0 / rate_hz,
        None => common_step(&contents) as f64 * unit_s,
    };
    let seconds = |at: u64| at as f64 * unit_s;
    let channels = contents.channels.into_iter().map(|(name, levels)| {
        let levels = levels.into_iter().map(|(at, high)| (seconds(at), high));
        (name, Signal::of_levels(levels))
    });
    Ok(Trace {
        channels: channels.collect(),
        span: Span {
            begin_s: seconds(begin),
            end_s: seconds(end),
            step_s,
        },
    })
}

/// The longest time of which every instant is a multiple, from the first on, units of the file.
fn common_step(contents: &Contents) -> u64 {
    let [begin, end] = contents.limits;
    let instants = contents.channels.iter().flat_map(|(_, levels)| levels);
    let instants = instants.map(|(at, _)| at - begin);
    instants.fold(end - begin, greatest_common_divisor)
}

fn greatest_common_divisor(mut a: u64, mut b: u64) -> u64 {
    while b > 0 {
        (a, b) = (b, a % b);
    }
    a
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_text(text: &str) -> Result<Trace> {
        let folder = tempfile::tempdir()?;
        let path = folder.path().join("trace");
        std::fs::write(&path, text)?;
        read(&path, None)
    }

    #[test]
    fn the_step_is_told_or_what_all_instants_are_multiples_of() {
        let vcd = |comment: &str| {
            format!(
                "{comment}$timescale 1 ns $end $var wire 1 ! CONVST $end $enddefinitions $end #40 0! #100 1! #160 0! #400"
            )
        };
        let told = read_text(&vcd(
            "$comment\n Acquisition with 1/8 channels at 100 MHz\n$end ",
        ))
        .unwrap();
        assert!((told.span.step_s - 1.0e-8).abs() < 1.0e-15);
        let found = read_text(&vcd("")).unwrap();
        assert!((found.span.step_s - 6.0e-8).abs() < 1.0e-15);
        assert!((found.span.begin_s - 4.0e-8).abs() < 1.0e-15);
        let edges_s = found.channels[0].1.edges_s();
        assert!((edges_s[0] - 1.0e-7).abs() < 1.0e-15 && edges_s.len() == 2);
    }

    #[test]
    fn what_is_no_trace_is_refused_with_its_name() {
        for text in [
            "",
            "$timescale 1 ns $end $enddefinitions $end #5",
            "hello",
            "$nothing",
        ] {
            let error = format!("{:#}", read_text(text).unwrap_err());
            assert!(error.contains("trace: "), "{error}");
        }
    }
}
