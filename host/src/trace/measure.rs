//! From values that were measured to a step that has passed or not.

use crate::acceptance::Step;

/// A value, and when it was measured, seconds of the recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// When.
    pub at_s: f64,
    /// The value, in its own unit.
    pub value: f64,
}

/// What is wanted of a value, and how it is told.
#[derive(Clone, Copy, Debug)]
pub struct Wanted<'a> {
    /// The step's name.
    pub step: &'static str,
    /// Least and most that it may be.
    pub range: [f64; 2],
    /// What the recording may be off: so much outside the range is no failure.
    pub slack: f64,
    /// Factor to the unit in which it is told, and that unit.
    pub unit: (f64, &'a str),
    /// What is wanted, in words.
    pub text: &'a str,
}

/// Nanoseconds, from seconds.
pub const NS: (f64, &str) = (1.0e9, "ns");
/// Microseconds, from seconds.
pub const US: (f64, &str) = (1.0e6, "µs");
/// Megahertz, from hertz.
pub const MHZ: (f64, &str) = (1.0e-6, "MHz");

/// Every value must lie in its range. The first that does not is told with its instant.
pub fn within(values: &[Measured], wanted: Wanted<'_>) -> Step {
    let Wanted {
        step,
        range,
        slack,
        unit,
        text,
    } = wanted;
    if values.is_empty() {
        return Step::not_measured(step, "the trace shows none", text);
    }
    let is_outside = |value: f64| !(value >= range[0] - slack && value <= range[1] + slack);
    let outside: Vec<&Measured> = values.iter().filter(|m| is_outside(m.value)).collect();
    match outside.first() {
        None => {
            let least = values.iter().map(|m| m.value).fold(f64::INFINITY, f64::min);
            let most = values
                .iter()
                .map(|m| m.value)
                .fold(f64::NEG_INFINITY, f64::max);
            let (least, most) = (figure(least * unit.0), told(most, unit));
            let found = match most.split(' ').next() == Some(&least) {
                true => most,
                false => format!("{least} to {most}"),
            };
            Step::new(step, true, found, text)
        }
        Some(first) => {
            let found = format!(
                "{}, {} of {}",
                told(first.value, unit),
                outside.len(),
                values.len()
            );
            Step::new(step, false, found, text).at(first.at_s)
        }
    }
}

/// Everything that was looked for was there, or the first instant at which it was not and what was found then.
pub fn all_there(
    step: &'static str,
    looked_for: usize,
    missing: &[(f64, String)],
    what: &str,
    wanted: &str,
) -> Step {
    match missing.first() {
        _ if looked_for == 0 => Step::not_measured(step, "the trace shows none", wanted),
        None => Step::new(step, true, format!("{looked_for} {what}"), wanted),
        Some((at_s, found)) => {
            let found = format!("{found}, {} of {looked_for}", missing.len());
            Step::new(step, false, found, wanted).at(*at_s)
        }
    }
}

/// A value with its unit.
pub fn told(value: f64, unit: (f64, &str)) -> String {
    format!("{} {}", figure(value * unit.0), unit.1)
}

/// A frequency in megahertz, without the unit.
pub fn megahertz(frequency_hz: f64) -> String {
    figure(1.0e-6 * frequency_hz)
}

/// A number with three digits behind the point at most: nanoseconds of microseconds, kilohertz of megahertz.
fn figure(value: f64) -> String {
    let text = format!("{value:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_value_outside_is_told_with_its_instant() {
        let wanted = Wanted {
            step: "width",
            range: [1.0e-6, 2.0e-6],
            slack: 1.0e-8,
            unit: US,
            text: "1 to 2 µs",
        };
        let value = |at_s, value| Measured { at_s, value };
        let good = [value(0.0, 0.995e-6), value(1.0, 2.005e-6)];
        let step = within(&good, wanted);
        assert_eq!(
            (step.passed, step.found.as_str()),
            (Some(true), "0.995 to 2.005 µs")
        );
        let step = within(&[good[0], value(3.0, 2.5e-6), value(4.0, f64::NAN)], wanted);
        assert_eq!((step.passed, step.at_s), (Some(false), Some(3.0)));
        assert_eq!(step.found, "2.5 µs, 2 of 3");
        assert_eq!(within(&[], wanted).passed, None);
    }

    #[test]
    fn nothing_that_is_missing_goes_unsaid() {
        let step = |looked_for, missing: &[(f64, String)]| {
            all_there("pulses", looked_for, missing, "pulses", "one each")
        };
        assert_eq!(step(3, &[]).passed, Some(true));
        assert_eq!(step(0, &[]).passed, None);
        let told = step(3, &[(2.0, "none".to_owned())]);
        assert_eq!(
            (told.passed, told.at_s, told.found.as_str()),
            (Some(false), Some(2.0), "none, 1 of 3")
        );
    }
}
