//! BUSY of converter 0: the answer to CONVST.

use super::super::Line;
use super::super::limits::{BUSY_BELOW_S, BUSY_RISES_WITHIN_S};
use super::super::measure::{Measured, NS, US, all_there, told};
use super::view::{Check, PULSES_S, View};
use crate::acceptance::Step;

const LINES: &[Line] = &[Line::Convst, Line::Busy];

/// Its steps.
pub const CHECKS: &[Check] = &[
    Check {
        step: "BUSY pulses",
        lines: LINES,
        coarsest_s: PULSES_S,
        wanted: || "one after each CONVST".into(),
        judge: pulses,
    },
    Check {
        step: "BUSY after CONVST",
        lines: LINES,
        coarsest_s: BUSY_RISES_WITHIN_S,
        wanted: || format!("within {}", told(BUSY_RISES_WITHIN_S, NS)),
        judge: delay,
    },
    Check {
        step: "BUSY width",
        lines: LINES,
        coarsest_s: PULSES_S,
        wanted: || format!("below {}", told(BUSY_BELOW_S, US)),
        judge: width,
    },
];

fn pulses(view: &View<'_>, step: &'static str, wanted: &str) -> Step {
    let wrong = view.conversions.iter().filter(|c| c.busy.len() != 1);
    let wrong: Vec<(f64, String)> = wrong
        .map(|c| match c.busy.len() {
            0 => (c.at_s, "no pulse".to_owned()),
            more => (c.at_s, format!("{more} pulses")),
        })
        .collect();
    all_there(step, view.conversions.len(), &wrong, "pulses", wanted)
}

fn delay(view: &View<'_>, step: &'static str, text: &str) -> Step {
    let delays = view.conversions.iter().filter_map(|c| {
        let value = c.busy.first()?.begin_s - c.at_s;
        Some(Measured {
            at_s: c.at_s,
            value,
        })
    });
    view.within(delays, [0.0, BUSY_RISES_WITHIN_S], NS, (step, text))
}

fn width(view: &View<'_>, step: &'static str, text: &str) -> Step {
    let pulses = view.conversions.iter().filter_map(|c| c.busy.first());
    let widths = pulses.filter_map(|pulse| {
        let value = view.width_s(pulse, BUSY_BELOW_S)?;
        Some(Measured {
            at_s: pulse.begin_s,
            value,
        })
    });
    view.within(widths, [0.0, BUSY_BELOW_S], US, (step, text))
}
