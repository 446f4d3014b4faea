//! Which channel of a recording is which line of the board.

use super::{Signal, Trace};
use anyhow::{Result, bail, ensure};

/// A line of the board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Line {
    /// Start of a conversion.
    Convst,
    /// A conversion is under way.
    Busy,
    /// Chip select of converter 0 or 1; low while it is selected.
    Select(usize),
    /// Clock of converter 0's bus or 1's.
    Clock(usize),
    /// Data from converter 0 or 1.
    Data(usize),
    /// Reset of both converters.
    Reset,
    /// Reset of the processor; low.
    Nrst,
}

/// Each line with its names: the one by which it is told, what instruments' users call it, and the pin (README).
const NAMES: [(Line, &[&str]); 10] = [
    (Line::Convst, &["CONVST", "CNV", "PC6"]),
    (Line::Busy, &["BUSY", "PC8"]),
    (Line::Select(0), &["CS0", "NCS0", "PA4"]),
    (Line::Select(1), &["CS1", "NCS1", "PB12"]),
    (Line::Clock(0), &["SCLK0", "SCK0", "PA5"]),
    (Line::Clock(1), &["SCLK1", "SCK1", "PB13"]),
    (Line::Data(0), &["DOUT0", "MISO0", "PA6"]),
    (Line::Data(1), &["DOUT1", "MISO1", "PB14"]),
    (Line::Reset, &["RESET", "PC7"]),
    (Line::Nrst, &["NRST"]),
];

impl Line {
    /// The name by which it is told.
    pub fn name(self) -> &'static str {
        NAMES[self.place()].1[0]
    }

    fn place(self) -> usize {
        let place = NAMES.iter().position(|(line, _)| *line == self);
        place.unwrap_or_default()
    }

    fn by_name(name: &str) -> Option<Self> {
        let plain: String = name.chars().filter(char::is_ascii_alphanumeric).collect();
        let plain = plain.to_ascii_uppercase();
        let found = NAMES
            .iter()
            .find(|(_, names)| names.contains(&plain.as_str()));
        found.map(|(line, _)| *line)
    }
}

/// `LINE=CHANNEL`, as the option `--channel` takes it.
#[derive(Clone, Debug, PartialEq)]
pub struct Named {
    line: Line,
    channel: String,
}

impl Named {
    /// Takes an option's value apart.
    ///
    /// # Errors
    /// It has no such form, or there is no such line.
    pub fn parse(text: &str) -> Result<Self, String> {
        let (line, channel) = text
            .split_once('=')
            .ok_or("wanted LINE=CHANNEL, such as CONVST=D0")?;
        let known = || NAMES.map(|(line, _)| line.name()).join(", ");
        let line =
            Line::by_name(line).ok_or_else(|| format!("{line}: wanted one of {}", known()))?;
        Ok(Self {
            line,
            channel: channel.trim().to_owned(),
        })
    }
}

/// The lines of a recording that are known.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lines([Option<(String, Signal)>; NAMES.len()]);

impl Lines {
    /// The lines of a recording: those that are named, and of the other channels those whose own name says what they are.
    ///
    /// # Errors
    /// A channel that is named is not there, two channels are one line, or there is no line at all.
    pub fn of(trace: Trace, named: &[Named]) -> Result<Self> {
        let there: Vec<String> = trace
            .channels
            .iter()
            .map(|(name, _)| name.clone())
            .collect();
        let there = there.join(", ");
        for name in named {
            let known = trace.channels.iter().any(|(own, _)| *own == name.channel);
            ensure!(
                known,
                "--channel {}: found the channels {there}, wanted one of them",
                name.channel
            );
        }
        let mut lines = Self::default();
        for (own, signal) in trace.channels {
            let given = named.iter().filter(|name| name.channel == own);
            let mut meant: Vec<Line> = given.map(|name| name.line).collect();
            if meant.is_empty() {
                let by_option = |line: &Line| named.iter().any(|name| name.line == *line);
                meant.extend(Line::by_name(&own).filter(|line| !by_option(line)));
            }
            for line in meant {
                let before = lines.0[line.place()].replace((own.clone(), signal.clone()));
                if let Some((before, _)) = before {
                    let line = line.name();
                    bail!(
                        "found two channels for {line}, {before} and {own}, wanted one: --channel {line}={own}"
                    );
                }
            }
        }
        ensure!(
            lines.0.iter().any(Option::is_some),
            "found the channels {there}, wanted CONVST, BUSY, CS0, SCLK0 or another line of the board: --channel CONVST=NAME names one"
        );
        Ok(lines)
    }

    /// A line, if it is recorded.
    pub fn get(&self, line: Line) -> Option<&Signal> {
        let (_, signal) = self.0[line.place()].as_ref()?;
        Some(signal)
    }

    /// Takes another signal for a line.
    pub fn put(&mut self, line: Line, signal: Signal) {
        self.0[line.place()] = Some((line.name().to_owned(), signal));
    }

    /// Each line that is recorded, by name, and its channel's name.
    pub fn told(&self) -> Vec<(&'static str, &str)> {
        let pairs = NAMES.iter().zip(&self.0);
        pairs
            .filter_map(|((line, _), own)| Some((line.name(), own.as_ref()?.0.as_str())))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::Span;
    use super::*;

    fn trace(names: &[&str]) -> Trace {
        let channels = names
            .iter()
            .map(|name| ((*name).to_owned(), Signal::default()));
        let span = Span {
            begin_s: 0.0,
            end_s: 1.0,
            step_s: 1.0e-8,
        };
        Trace {
            channels: channels.collect(),
            span,
        }
    }

    fn told(names: &[&str], named: &[&str]) -> Result<Vec<(String, String)>> {
        let named: Vec<Named> = named
            .iter()
            .map(|text| Named::parse(text).unwrap())
            .collect();
        let lines = Lines::of(trace(names), &named)?;
        let told = lines.told().into_iter();
        Ok(told
            .map(|(line, own)| (line.to_owned(), own.to_owned()))
            .collect())
    }

    #[test]
    fn channels_are_found_by_their_names_and_by_the_pins() {
        let found = told(&["convst", "/CS-0", "PB13", "D4"], &[]).unwrap();
        let wanted = [("CONVST", "convst"), ("CS0", "/CS-0"), ("SCLK1", "PB13")];
        assert_eq!(
            found,
            wanted.map(|(line, own)| (line.to_owned(), own.to_owned()))
        );
    }

    #[test]
    fn an_option_goes_before_a_name_and_a_channel_may_be_two_lines() {
        let found = told(
            &["D0", "CONVST", "CLK"],
            &["CONVST=D0", "SCLK0=CLK", "SCLK1=CLK"],
        )
        .unwrap();
        let wanted = [("CONVST", "D0"), ("SCLK0", "CLK"), ("SCLK1", "CLK")];
        assert_eq!(
            found,
            wanted.map(|(line, own)| (line.to_owned(), own.to_owned()))
        );
    }

    #[test]
    fn what_cannot_be_told_apart_is_refused() {
        let refused = |names: &[&str], named: &[&str], wanted: &str| {
            let told = told(names, named).unwrap_err().to_string();
            assert!(told.contains(wanted), "{told}");
        };
        refused(
            &["D0", "D1"],
            &[],
            "found the channels D0, D1, wanted CONVST",
        );
        refused(
            &["CONVST", "PC6"],
            &[],
            "two channels for CONVST, CONVST and PC6",
        );
        refused(
            &["D0"],
            &["CONVST=D9"],
            "--channel D9: found the channels D0",
        );
        assert!(Named::parse("CONVST").is_err());
        assert!(
            Named::parse("LAMP=D0")
                .unwrap_err()
                .contains("wanted one of CONVST")
        );
    }
}
