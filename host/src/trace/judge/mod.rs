//! Whether the lines are as they should be: levels in, verdicts out. A file a line of the board.

mod bus;
mod busy;
mod convst;
mod reset;
mod select;

use super::conversions::{Conversion, conversions, usual_period_s};
use super::limits::{CONVST_HIGH_S, PERIOD_S, SCLK_HZ};
use super::{Line, Lines, Pulse, Signal, Span, megahertz};
use crate::acceptance::Step;

/// What is recorded, and what belongs together in it.
struct View<'a> {
    lines: &'a Lines,
    span: Span,
    /// Time from one conversion to the next, as it is in the recording, seconds.
    period_s: f64,
    conversions: Vec<Conversion>,
}

/// A step.
struct Check {
    /// Its name.
    step: &'static str,
    /// The lines that it needs.
    lines: &'static [Line],
    /// The longest step of an instrument with which it can be told, seconds.
    coarsest_s: f64,
    /// What is wanted, in words.
    wanted: fn() -> String,
    /// Judges it, by its name and what is wanted.
    judge: fn(&View<'_>, &'static str, &str) -> Step,
}

/// An instrument must look twice while CONVST is high; BUSY is high for longer.
const PULSES_S: f64 = CONVST_HIGH_S / 2.0;
/// And once in each half of a clock.
const CLOCKS_S: f64 = 0.5 / SCLK_HZ;

/// All steps, in the order in which they are told. Those of a further line are a file and a line here.
const CHECKS: [&[Check]; 5] = [
    convst::CHECKS,
    busy::CHECKS,
    select::CHECKS,
    bus::CHECKS,
    reset::CHECKS,
];

/// Judges each step. One is not measured if a line that it needs is not recorded, if the instrument looked too seldom to tell, or if nothing
/// of it was seen.
pub fn judge(lines: &Lines, span: Span) -> Vec<Step> {
    let begins_s: Vec<f64> = lines
        .get(Line::Convst)
        .map(|convst| convst.edges_to(true).collect())
        .unwrap_or_default();
    let period_s = usual_period_s(&begins_s).unwrap_or(PERIOD_S);
    let view = View {
        lines,
        span,
        period_s,
        conversions: conversions(lines, span, period_s),
    };
    let checks = CHECKS.into_iter().flatten();
    checks.map(|check| one(&view, check)).collect()
}

fn one(view: &View<'_>, check: &Check) -> Step {
    let wanted = (check.wanted)();
    let missing = check
        .lines
        .iter()
        .find(|line| view.lines.get(**line).is_none());
    if let Some(line) = missing {
        let name = line.name();
        let why = format!("no channel {name} (--channel {name}=NAME names one)");
        return Step::not_measured(check.step, &why, wanted);
    }
    if view.span.step_s > check.coarsest_s {
        let why = format!(
            "{} MS/s are too few, {} tell it",
            megahertz(1.0 / view.span.step_s),
            megahertz(1.0 / check.coarsest_s)
        );
        return Step::not_measured(check.step, &why, wanted);
    }
    (check.judge)(view, check.step, &wanted)
}

impl View<'_> {
    /// A line that the step needs, so that it is there.
    fn line(&self, line: Line) -> &Signal {
        static NONE: std::sync::LazyLock<Signal> = std::sync::LazyLock::new(Signal::default);
        self.lines.get(line).unwrap_or(&NONE)
    }

    /// A pulse's width, seconds; of one that outlasts the recording what is seen of it, if that is longer than `most_s` already.
    fn width_s(&self, pulse: &Pulse, most_s: f64) -> Option<f64> {
        let seen_s = self.span.end_s - pulse.begin_s;
        let ended = pulse.end_s.map(|end_s| end_s - pulse.begin_s);
        ended.or((seen_s > most_s + self.span.step_s).then_some(seen_s))
    }
}

#[cfg(test)]
mod tests;
