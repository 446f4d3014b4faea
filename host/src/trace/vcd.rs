//! A value change dump (VCD), as sigrok and many instruments write it.

use super::contents::{Contents, frequency_hz};
use anyhow::{Context, Result, bail, ensure};
use std::collections::HashMap;
use std::io::{BufRead, Read};
use vcd::{Command, Header, IdCode, Parser, Scope, ScopeItem, TimescaleUnit, Value};

/// What sigrok says of the instrument's rate in a comment: `Acquisition with 3/8 channels at 24 MHz`.
const RATE: (&str, &str) = ("Acquisition with", " at ");

/// Reads it.
///
/// # Errors
/// It breaks the format, or its times fall.
pub fn contents(bytes: &[u8]) -> Result<Contents> {
    // The last line may have no end.
    let mut parser = Parser::new(bytes.chain(&b"\n"[..]));
    let header = parser
        .parse_header()
        .context("wanted the header of a VCD file")?;
    let unit_s = unit_s(&header)?;
    let (mut channels, mut places) = (Vec::new(), HashMap::new());
    let mut rate_hz = None;
    collect(&header.items, &mut |item| match item {
        ScopeItem::Var(var) if var.size == 1 => {
            places.insert(var.code, channels.len());
            channels.push((var.reference.clone(), Vec::new()));
        }
        ScopeItem::Comment(text) => rate_hz = rate_hz.or(rate_in(text)),
        _ => {}
    });
    let limits = changes(&mut parser, &places, &mut channels)?;
    Ok(Contents {
        channels,
        limits,
        unit_s,
        rate_hz,
    })
}

/// Reads all changes of levels; the first instant and the last.
fn changes(
    parser: &mut Parser<impl BufRead>,
    places: &HashMap<IdCode, usize>,
    channels: &mut [(String, Vec<(u64, bool)>)],
) -> Result<[u64; 2]> {
    let (mut first, mut now) = (None, 0);
    for command in parser {
        let (code, value) = match command.context("wanted changes of a VCD file")? {
            Command::Timestamp(at) => {
                ensure!(
                    first.is_none() || at >= now,
                    "found the time {at} after {now}, wanted times that do not fall"
                );
                first.get_or_insert(at);
                now = at;
                continue;
            }
            Command::ChangeScalar(code, value) => (code, value),
            Command::ChangeVector(code, values) if values.len() == 1 => {
                (code, values.get(0).unwrap_or(Value::X))
            }
            _ => continue,
        };
        // A level that is not known is taken as the one before.
        let high = match value {
            Value::V0 => false,
            Value::V1 => true,
            Value::X | Value::Z => continue,
        };
        if let Some((_, levels)) = places.get(&code).and_then(|place| channels.get_mut(*place)) {
            levels.push((now, high));
        }
    }
    Ok([first.unwrap_or(0), now])
}

fn unit_s(header: &Header) -> Result<f64> {
    let (number, unit) = header
        .timescale
        .context("found no $timescale, wanted one")?;
    let unit_s = match unit {
        TimescaleUnit::S => 1.0,
        TimescaleUnit::MS => 1.0e-3,
        TimescaleUnit::US => 1.0e-6,
        TimescaleUnit::NS => 1.0e-9,
        TimescaleUnit::PS => 1.0e-12,
        TimescaleUnit::FS => 1.0e-15,
    };
    if number == 0 {
        bail!("found $timescale 0, wanted a time");
    }
    Ok(f64::from(number) * unit_s)
}

fn rate_in(comment: &str) -> Option<f64> {
    let (_, rest) = comment.split_once(RATE.0)?;
    let (_, rate) = rest.split_once(RATE.1)?;
    frequency_hz(rate.lines().next()?)
}

/// Everything in the header, whatever scope it is in.
fn collect(items: &[ScopeItem], take: &mut impl FnMut(&ScopeItem)) {
    for item in items {
        match item {
            ScopeItem::Scope(Scope { items, .. }) => collect(items, take),
            item => take(item),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "$timescale 10 ns $end $scope module board $end $var wire 1 ! CONVST $end \
         $var wire 8 \" bus $end $var reg 1 # BUSY $end $upscope $end $enddefinitions $end ";

    fn read(changes: &str) -> Result<Contents> {
        contents(format!("{HEADER}{changes}").as_bytes())
    }

    #[test]
    fn channels_of_one_bit_are_read_and_others_left_out() {
        let found = read("#5 $dumpvars 0! b101 \" x# $end #7 1! b1 # #9 z! 0! #20").unwrap();
        assert_eq!(found.limits, [5, 20]);
        assert!((found.unit_s - 1.0e-8).abs() < 1.0e-20);
        let wanted = [
            ("CONVST".to_owned(), vec![(5, false), (7, true), (9, false)]),
            ("BUSY".to_owned(), vec![(7, true)]),
        ];
        assert_eq!(found.channels, wanted);
        assert_eq!(found.rate_hz, None);
    }

    /// Whatever a byte becomes, the file is read or refused.
    #[test]
    fn no_broken_byte_is_more_than_an_error() {
        let text = format!("{HEADER}#5 0! b1 # #7 1! r1.5 ! #20");
        let mut refused = 0;
        for place in 0..text.len() {
            for byte in *b"\0 $#b9-!\xFF" {
                let mut bytes = text.clone().into_bytes();
                bytes[place] = byte;
                refused += usize::from(contents(&bytes).is_err());
            }
        }
        assert!(refused > 100, "{refused}");
    }

    #[test]
    fn times_that_fall_and_broken_files_are_refused() {
        for changes in ["#5 0! #4 1!", "#5 0! %", "#x"] {
            assert!(read(changes).is_err(), "{changes}");
        }
        for text in [
            "$enddefinitions $end #1",
            "$timescale 0 ns $end $enddefinitions $end #1",
            "$timescale 1 ns",
        ] {
            assert!(contents(text.as_bytes()).is_err(), "{text}");
        }
    }
}
