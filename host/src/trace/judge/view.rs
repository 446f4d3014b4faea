//! What the steps look at, and what a step is.

use super::super::conversions::Conversion;
use super::super::limits::{CONVST_HIGH_S, SCLK_HZ};
use super::super::measure::{Measured, Wanted, within};
use super::super::{Line, Lines, Pulse, Signal, Span};
use crate::acceptance::Step;

/// What is recorded, and what belongs together in it.
pub struct View<'a> {
    /// The lines.
    pub lines: &'a Lines,
    /// The time that is recorded.
    pub span: Span,
    /// Time from one conversion to the next, as it is in the recording, seconds.
    pub period_s: f64,
    /// The conversions that are whole.
    pub conversions: Vec<Conversion>,
}

/// A step.
pub struct Check {
    /// Its name.
    pub step: &'static str,
    /// The lines that it needs.
    pub lines: &'static [Line],
    /// The longest step of an instrument with which it can be told, seconds.
    pub coarsest_s: f64,
    /// What is wanted, in words.
    pub wanted: fn() -> String,
    /// Judges it, by its name and what is wanted.
    pub judge: fn(&View<'_>, &'static str, &str) -> Step,
}

/// An instrument must look twice while CONVST is high; BUSY is high for longer.
pub const PULSES_S: f64 = CONVST_HIGH_S / 2.0;
/// And once in each half of a clock.
pub const CLOCKS_S: f64 = 0.5 / SCLK_HZ;

impl View<'_> {
    /// Judges values that must lie in a range, up to what the recording's step leaves open.
    pub fn within(
        &self,
        values: impl Iterator<Item = Measured>,
        range: [f64; 2],
        unit: (f64, &str),
        (step, text): (&'static str, &str),
    ) -> Step {
        let values: Vec<Measured> = values.collect();
        let slack = self.span.step_s;
        within(
            &values,
            Wanted {
                step,
                range,
                slack,
                unit,
                text,
            },
        )
    }

    /// A line that the step needs, so that it is there.
    pub fn line(&self, line: Line) -> &Signal {
        static NONE: std::sync::LazyLock<Signal> = std::sync::LazyLock::new(Signal::default);
        self.lines.get(line).unwrap_or(&NONE)
    }

    /// A pulse's width, seconds; of one that outlasts the recording what is seen of it, if that is longer than `most_s` already.
    pub fn width_s(&self, pulse: &Pulse, most_s: f64) -> Option<f64> {
        let seen_s = self.span.end_s - pulse.begin_s;
        let ended = pulse.end_s.map(|end_s| end_s - pulse.begin_s);
        ended.or((seen_s > most_s + self.span.step_s).then_some(seen_s))
    }
}
