//! Lines of candump: frames of a CAN bus with their times.
//!
//! `(1764248400.000200) can0 18FEF1FE#0000001F40000000 R` by `-l` and `-L`, `##` and a digit of flags before the data of CAN FD; or
//! `(1764248400.000200)  can0  123   [8]  00 11 22 33 44 55 66 77` by `-ta`, the date in place of the number by `-tA`, the time since the first frame by
//! `-tz` or since the last one by `-td`, and `RX - -` behind the bus by `-x`. Lines that begin with `#` are comments.

use super::beside::first_lines;
use recording::{Error, excerpt};
use std::path::Path;
use time::{Date, Month};

/// Bit 31 of an identifier in a DBC file: it is one of 29 bits.
pub const EXTENDED: u32 = 1 << 31;

/// One frame.
pub struct Frame {
    /// When it came, s.
    pub t_s: f64,
    /// The name of its bus.
    pub bus: String,
    /// Its identifier, with [`EXTENDED`] where it has 29 bits.
    pub id: u32,
    /// Its data.
    pub data: Vec<u8>,
    /// The line of the file.
    pub line: u64,
}

/// All frames with data.
pub struct Frames {
    /// In the file's order.
    pub frames: Vec<Frame>,
    /// The last line was cut short.
    pub cut_short: bool,
    /// What was made of the file.
    pub notes: Vec<String>,
}

/// True of a file whose first line is a frame, with its time or without, comments left aside.
pub fn is_it(bytes: &[u8]) -> bool {
    let mut lines = first_lines(bytes).filter(|line| !line.starts_with('#'));
    let first = lines.next();
    let has_time = first.is_some_and(|line| frame(line).is_some());
    has_time || first.into_iter().chain(lines).any(is_without_time)
}

/// The frames of a file for which [`is_it`] holds.
///
/// # Errors
/// Frames without times, or a line that is no frame.
pub fn parse(file: &Path, text: &str) -> Result<Frames, Error> {
    let mut frames = Vec::new();
    let mut cut_short = false;
    let ended = text.ends_with('\n');
    let mut lines = text
        .lines()
        .map(str::trim)
        .enumerate()
        .filter(|(_, line)| !line.is_empty() && !line.starts_with('#'))
        .peekable();
    while let Some((place, line)) = lines.next() {
        let is_last = lines.peek().is_none();
        match frame(line) {
            // The end of a line that is cut off may be missing without a trace.
            Some(_) if is_last && !ended => cut_short = true,
            Some(Some(mut one)) => {
                one.line = place as u64 + 1;
                frames.push(one);
            }
            Some(None) => {}
            None if is_last && !frames.is_empty() => cut_short = true,
            None => {
                let wanted = "a frame with its time, as in (1764248400.000200) can0 123#0011: candump -L or -ta writes it";
                let found = match is_without_time(line) {
                    true => format!("a frame without its time, {}", excerpt(line.as_bytes())),
                    false => excerpt(line.as_bytes()),
                };
                return Err(Error::new(file, found, wanted).row(place as u64 + 1));
            }
        }
    }
    let mut notes = Vec::new();
    if are_intervals(&frames) {
        let mut t_s = 0.0;
        for frame in &mut frames {
            t_s += frame.t_s;
            frame.t_s = t_s;
        }
        notes.push("times are those since the frame before, as candump -td writes them".into());
    }
    Ok(Frames {
        frames,
        cut_short,
        notes,
    })
}

/// True of times since the frame before. Those since the first one begin at zero too, but grow from frame to frame, where of intervals
/// about half grow: two thirds lie between.
fn are_intervals(frames: &[Frame]) -> bool {
    let grow = frames.windows(2).filter(|two| two[0].t_s < two[1].t_s);
    frames.len() > 2 && frames[0].t_s == 0.0 && 3 * grow.count() < 2 * (frames.len() - 1)
}

/// True of a frame as candump prints it without `-t`.
fn is_without_time(line: &str) -> bool {
    frame(&format!("(0) {line}")).is_some() || {
        // `<0x18eeff01> [8] 05 a0` of the programs before can-utils.
        let parts = line
            .strip_prefix("<0x")
            .and_then(|line| line.split_once("> ["));
        parts.is_some_and(|(id, data)| u32::from_str_radix(id, 16).is_ok() && data.contains(']'))
    }
}

/// The frame of a line; the inner one is none of an error of the bus and of a request for data.
fn frame(line: &str) -> Option<Option<Frame>> {
    let (time, rest) = line.trim().strip_prefix('(')?.split_once(')')?;
    let t_s = seconds(time)?;
    let mut words = rest.split_whitespace();
    let bus = words.next()?.to_owned();
    let mut word = words.next()?;
    if matches!(word, "RX" | "TX") {
        // The way of the frame, and two flags: `B` or `-`, `E` or `-`.
        word = words.nth(2)?;
    }
    let (id, data) = match word.split_once('#') {
        Some((id, data)) => {
            // The first digit of CAN FD's are flags.
            let data = data
                .strip_prefix('#')
                .map_or(data, |data| data.get(1..).unwrap_or_default());
            if data.starts_with('R') {
                return Some(None);
            }
            (id, data.replace('.', ""))
        }
        None => {
            // `[8]`, or `[08]` of CAN FD.
            let length: usize = words
                .next()?
                .strip_prefix('[')?
                .strip_suffix(']')?
                .parse()
                .ok()?;
            (word, words.take(length).collect())
        }
    };
    let wide = id.len() > 3;
    let id = u32::from_str_radix(id, 16).ok()?;
    // Bits 29 and 30 are not of identifiers: they mark errors.
    if id >> 29 != 0 || data == "remoterequest" {
        return Some(None);
    }
    let data = (0..data.len())
        .step_by(2)
        .map(|at| u8::from_str_radix(data.get(at..at + 2)?, 16).ok())
        .collect::<Option<Vec<u8>>>()?;
    let id = if wide { id | EXTENDED } else { id };
    Some(Some(Frame {
        t_s,
        bus,
        id,
        data,
        line: 0,
    }))
}

/// A time: seconds, or `2020-12-16 18:11:48.934470` as seconds since 1970 by the clock on the wall.
fn seconds(text: &str) -> Option<f64> {
    let Some((date, clock)) = text.split_once(' ') else {
        return text.parse().ok().filter(|t_s: &f64| t_s.is_finite());
    };
    let mut date = date.splitn(3, '-');
    let (year, month, day) = (date.next()?, date.next()?, date.next()?);
    let month = Month::try_from(month.parse::<u8>().ok()?).ok()?;
    let date = Date::from_calendar_date(year.parse().ok()?, month, day.parse().ok()?).ok()?;
    let mut clock = clock.splitn(3, ':');
    let [hours, minutes] = [clock.next()?, clock.next()?].map(str::parse::<u8>);
    let seconds: f64 = clock.next()?.parse().ok().filter(|s: &f64| s.is_finite())?;
    let midnight_s = date.midnight().assume_utc().unix_timestamp() as f64;
    Some(midnight_s + f64::from(hours.ok()?) * 3600.0 + f64::from(minutes.ok()?) * 60.0 + seconds)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_each_kind() {
        for (line, id, data) in [
            ("(1.5) can0 123#0011", 0x123, &[0, 0x11][..]),
            ("(1.5) vcan1 00000123#00.11 T", 0x8000_0123, &[0, 0x11]),
            ("(1.5) can0 123##300112233", 0x123, &[0, 0x11, 0x22, 0x33]),
            ("(1.5) can0 123#", 0x123, &[]),
            (
                " (1.5)  can0  18FEF1FE   [2]  00 11   '..'",
                0x98fe_f1fe,
                &[0, 0x11],
            ),
            ("(1.5)  can0  123  [02]  00 11", 0x123, &[0, 0x11]),
            ("(1.5)  can0  RX - -  123   [1]  7F", 0x123, &[0x7f]),
            (
                "(1970-01-01 00:00:01.500000)  can0  123   [1]  7F",
                0x123,
                &[0x7f],
            ),
        ] {
            let frame = frame(line).flatten().unwrap_or_else(|| panic!("{line}"));
            assert_eq!(
                (frame.id, frame.data.as_slice(), frame.t_s),
                (id, data, 1.5),
                "{line}"
            );
        }
        for line in [
            "(1.5) can0 123#R",
            "(1.5) can0 123#R8",
            "(1.5) can0 20000004#0004000000000000",
            "(1.5)  can0  123   [0]  remote request",
        ] {
            assert!(
                frame(line).is_some_and(|frame| frame.is_none_or(|frame| frame.data.is_empty())),
                "{line}"
            );
        }
        for line in [
            "",
            "can0 123#0011",
            "(x) can0 123#0011",
            "(1.5) can0",
            "(1.5) can0 123#001",
            "(1.5) can0 xyz#00",
            "(1.5) can0 123 00",
            "(1970-13-01 00:00:01.5)  can0  123   [1]  7F",
        ] {
            assert!(frame(line).is_none(), "{line}");
        }
        assert_eq!(seconds("2020-12-16 18:11:48.25"), Some(1_608_142_308.25));
    }

    #[test]
    fn times_since_the_frame_before_are_summed() {
        let log = |times: [&str; 4]| {
            let line = |t: &&str| format!(" ({t})  can0  001   [1]  05\n");
            let text: String = times.iter().map(line).collect();
            let Ok(read) = parse(Path::new("a.log"), &text) else {
                panic!("{text}")
            };
            let t_s: Vec<f64> = read.frames.iter().map(|frame| frame.t_s).collect();
            (t_s, read.notes.len())
        };
        let times = |times: [&str; 4]| log(times).0;
        assert_eq!(
            log(["000.0", "000.5", "000.5", "000.25"]),
            (vec![0.0, 0.5, 1.0, 1.25], 1)
        );
        assert_eq!(
            times(["000.0", "000.5", "001.0", "001.25"]),
            [0.0, 0.5, 1.0, 1.25]
        );
        // Two frames of one bus are never as near as the clock's step, of two buses they may be.
        assert_eq!(
            times(["007.0", "007.0", "007.0", "008.0"]),
            [7.0, 7.0, 7.0, 8.0]
        );
    }

    #[test]
    fn frames_without_times_are_told() {
        for text in [
            "  can0  09F8027F   [8]  00 FC FF FF 00 00 FF FF\n",
            "# a note\nvcan0 123#0011\n",
            "interface = can0, family = 29, type = 3, proto = 1\n<0x18eeff01> [8] 05 a0 be 1c 00 a0 a0 c0 \n",
        ] {
            assert!(is_it(text.as_bytes()), "{text}");
            let Err(error) = parse(Path::new("a.log"), &format!("{text}{text}")) else {
                panic!("{text}")
            };
            assert!(
                error.to_string().contains("candump -L or -ta writes it"),
                "{error}"
            );
        }
        assert!(is_it(b"# a note\n\n(1.5) can0 123#0011\n"));
        assert!(!is_it(b"a b [c]\n1 2 3\n"));
    }
}
