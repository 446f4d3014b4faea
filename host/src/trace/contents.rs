//! What an instrument's file holds, whatever its format.

/// What a file holds, as it is read.
#[derive(Debug)]
pub struct Contents {
    /// Channels, and what they were told to be, in the order of time: instant in units of the file, level.
    pub channels: Vec<(String, Vec<(u64, bool)>)>,
    /// The first instant and the last, units of the file.
    pub limits: [u64; 2],
    /// A unit, seconds.
    pub unit_s: f64,
    /// Looks at the levels a second, if the file says so.
    pub rate_hz: Option<f64>,
}

/// A frequency as sigrok writes it: `24 MHz`. Hertz.
pub fn frequency_hz(text: &str) -> Option<f64> {
    let (number, unit) = text.trim().split_once(' ')?;
    let factor = match unit.trim() {
        "Hz" => 1.0,
        "kHz" => 1.0e3,
        "MHz" => 1.0e6,
        "GHz" => 1.0e9,
        _ => return None,
    };
    let number: f64 = number.parse().ok()?;
    (number > 0.0).then_some(number * factor)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frequencies_are_read_with_their_units() {
        assert_eq!(frequency_hz("24 MHz"), Some(24.0e6));
        assert_eq!(frequency_hz(" 12.5 kHz\n"), Some(12.5e3));
        for text in ["24", "MHz", "0 Hz", "fast MHz", "24 mHz"] {
            assert_eq!(frequency_hz(text), None, "{text}");
        }
    }
}
