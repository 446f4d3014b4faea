//! Both chip selects: when a converter is read, and for how long.

use super::super::Line;
use super::super::limits::{SELECTED_S, SELECTED_WITHIN_S};
use super::super::measure::{Measured, US, all_there, told};
use super::view::{Check, PULSES_S, View};
use crate::acceptance::Step;

/// Their steps.
pub const CHECKS: &[Check] = &[
    Check {
        step: "CS0 frames",
        lines: &[Line::Convst, Line::Select(0)],
        coarsest_s: PULSES_S,
        wanted: one_each,
        judge: frames::<0>,
    },
    Check {
        step: "CS1 frames",
        lines: &[Line::Convst, Line::Select(1)],
        coarsest_s: PULSES_S,
        wanted: one_each,
        judge: frames::<1>,
    },
    Check {
        step: "CS0 after BUSY",
        lines: &[Line::Convst, Line::Busy, Line::Select(0)],
        coarsest_s: PULSES_S,
        wanted: in_time,
        judge: after_busy::<0>,
    },
    Check {
        step: "CS1 after BUSY",
        lines: &[Line::Convst, Line::Busy, Line::Select(1)],
        coarsest_s: PULSES_S,
        wanted: in_time,
        judge: after_busy::<1>,
    },
    Check {
        step: "CS0 to CS1",
        lines: &[Line::Convst, Line::Select(0), Line::Select(1)],
        coarsest_s: PULSES_S,
        wanted: in_time,
        judge: apart,
    },
    Check {
        step: "CS0 width",
        lines: &[Line::Select(0)],
        coarsest_s: PULSES_S,
        wanted: long_enough,
        judge: width::<0>,
    },
    Check {
        step: "CS1 width",
        lines: &[Line::Select(1)],
        coarsest_s: PULSES_S,
        wanted: long_enough,
        judge: width::<1>,
    },
];

fn one_each() -> String {
    "one after each CONVST".into()
}

fn in_time() -> String {
    format!("within {}", told(SELECTED_WITHIN_S, US))
}

fn long_enough() -> String {
    format!("{} to {}", told(SELECTED_S[0], US), told(SELECTED_S[1], US))
}

fn frames<const CHIP: usize>(view: &View<'_>, step: &'static str, wanted: &str) -> Step {
    let select = view.line(Line::Select(CHIP));
    let wrong = view
        .conversions
        .iter()
        .filter(|c| c.selected[CHIP].len() != 1);
    let wrong: Vec<(f64, String)> = wrong
        .map(|c| {
            let found = match (c.selected[CHIP].len(), select.is_high_at(c.at_s)) {
                (0, true) => "none, it stays high".to_owned(),
                (0, false) => "none, it is low already".to_owned(),
                (more, _) => format!("{more}"),
            };
            (c.at_s, found)
        })
        .collect();
    all_there(step, view.conversions.len(), &wrong, "frames", wanted)
}

fn after_busy<const CHIP: usize>(view: &View<'_>, step: &'static str, text: &str) -> Step {
    let delays = view.conversions.iter().filter_map(|c| {
        let selected = c.selected[CHIP].first()?;
        let value = selected.begin_s - c.busy.first()?.end_s?;
        Some(Measured {
            at_s: selected.begin_s,
            value,
        })
    });
    view.within(delays, [0.0, SELECTED_WITHIN_S], US, (step, text))
}

fn apart(view: &View<'_>, step: &'static str, text: &str) -> Step {
    let times = view.conversions.iter().filter_map(|c| {
        let [first, second] = [c.selected[0].first()?, c.selected[1].first()?];
        let value = (second.begin_s - first.begin_s).abs();
        Some(Measured {
            at_s: first.begin_s,
            value,
        })
    });
    view.within(times, [0.0, SELECTED_WITHIN_S], US, (step, text))
}

fn width<const CHIP: usize>(view: &View<'_>, step: &'static str, text: &str) -> Step {
    let pulses = view.line(Line::Select(CHIP)).pulses(false);
    let widths = pulses.iter().filter_map(|pulse| {
        let value = view.width_s(pulse, SELECTED_S[1])?;
        Some(Measured {
            at_s: pulse.begin_s,
            value,
        })
    });
    view.within(widths, SELECTED_S, US, (step, text))
}
