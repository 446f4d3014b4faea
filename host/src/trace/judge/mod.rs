//! Whether the lines are as they should be: levels in, verdicts out. A file a line of the board.

mod bus;
mod busy;
mod convst;
mod reset;
mod select;
mod view;

use self::view::{Check, View};
use super::conversions::{conversions, usual_period_s};
use super::limits::PERIOD_S;
use super::{Line, Lines, Span, megahertz};
use crate::acceptance::Step;

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

#[cfg(test)]
mod tests;
