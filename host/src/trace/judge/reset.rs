//! Both resets, at rest while the board samples.

use super::super::Line;
use super::view::{Check, PULSES_S, View};
use crate::acceptance::Step;

/// Their steps.
pub const CHECKS: &[Check] = &[
    Check {
        step: "RESET",
        lines: &[Line::Reset],
        coarsest_s: PULSES_S,
        wanted: || "low while the board samples".into(),
        judge: |view, step, wanted| rests(view, step, wanted, Line::Reset, false),
    },
    Check {
        step: "NRST",
        lines: &[Line::Nrst],
        coarsest_s: PULSES_S,
        wanted: || "high".into(),
        judge: |view, step, wanted| rests(view, step, wanted, Line::Nrst, true),
    },
];

fn rests(view: &View<'_>, step: &'static str, wanted: &str, line: Line, high: bool) -> Step {
    let name = |high| if high { "high" } else { "low" };
    let signal = view.line(line);
    let left_s = match signal.first() == high {
        true => signal.edges_s().first().copied(),
        false => Some(view.span.begin_s),
    };
    match left_s {
        None => Step::new(step, true, name(high).into(), wanted),
        Some(at_s) => Step::new(step, false, name(!high).into(), wanted).at(at_s),
    }
}
