//! CONVST: the timer's pulses.

use super::super::Line;
use super::super::limits::{CLOCK_SHARE, CONVST_HIGH_S, EDGE_S, PERIOD_S};
use super::super::measure::{Measured, NS, US, all_there, told};
use super::view::{Check, PULSES_S, View};
use crate::acceptance::Step;

/// Its steps.
pub const CHECKS: &[Check] = &[
    Check {
        step: "CONVST pulses",
        lines: &[Line::Convst],
        coarsest_s: PULSES_S,
        wanted: || "none missing".into(),
        judge: pulses,
    },
    Check {
        step: "CONVST period",
        lines: &[Line::Convst],
        coarsest_s: PULSES_S,
        wanted: || format!("{} ± {} %", told(PERIOD_S, US), 100.0 * CLOCK_SHARE),
        judge: period,
    },
    Check {
        step: "CONVST jitter",
        lines: &[Line::Convst],
        coarsest_s: PULSES_S,
        wanted: || format!("{} at most", told(EDGE_S, NS)),
        judge: jitter,
    },
    Check {
        step: "CONVST width",
        lines: &[Line::Convst],
        coarsest_s: PULSES_S,
        wanted: || {
            format!(
                "{} ± {} % and {} for its edges",
                told(CONVST_HIGH_S, US),
                100.0 * CLOCK_SHARE,
                told(EDGE_S, NS)
            )
        },
        judge: width,
    },
    Check {
        step: "CONVST edges",
        lines: &[Line::Convst],
        coarsest_s: f64::INFINITY,
        wanted: || format!("below {}", told(EDGE_S, NS)),
        judge: |_, step, wanted| {
            Step::not_measured(
                step,
                "a trace has levels and no slopes: an oscilloscope shows them",
                wanted,
            )
        },
    },
];

/// More than one and a half periods are two: a pulse is missing.
const MISSING: f64 = 1.5;

fn rises_s(view: &View<'_>) -> Vec<f64> {
    view.line(Line::Convst).edges_to(true).collect()
}

fn pulses(view: &View<'_>, step: &'static str, wanted: &str) -> Step {
    let (period_s, span) = (view.period_s, view.span);
    let rises_s = rises_s(view);
    // The board samples before the recording and after it.
    let mut limits_s = rises_s.clone();
    limits_s.insert(0, span.begin_s);
    limits_s.push(span.end_s);
    let gaps = limits_s
        .windows(2)
        .filter(|pair| pair[1] - pair[0] > MISSING * period_s);
    let missing: Vec<(f64, String)> = gaps
        .flat_map(|pair| {
            let count = ((pair[1] - pair[0]) / period_s).round() as usize - 1;
            (1..=count).map(|place| (pair[0] + place as f64 * period_s, "no pulse".to_owned()))
        })
        .collect();
    all_there(
        step,
        rises_s.len() + missing.len(),
        &missing,
        "pulses",
        wanted,
    )
}

/// Times from one pulse to the next, but where one is missing.
fn periods(view: &View<'_>) -> Vec<Measured> {
    let rises_s = rises_s(view);
    let periods = rises_s.windows(2).map(|pair| Measured {
        at_s: pair[0],
        value: pair[1] - pair[0],
    });
    periods
        .filter(|period| period.value <= MISSING * view.period_s)
        .collect()
}

fn period(view: &View<'_>, step: &'static str, text: &str) -> Step {
    let range = [
        PERIOD_S * (1.0 - CLOCK_SHARE),
        PERIOD_S * (1.0 + CLOCK_SHARE),
    ];
    view.within(periods(view).into_iter(), range, US, (step, text))
}

/// The timer makes all periods alike: what they differ by is the instrument's, or another hand's than the timer's.
fn jitter(view: &View<'_>, step: &'static str, text: &str) -> Step {
    let periods = periods(view);
    let mean_s = periods.iter().map(|period| period.value).sum::<f64>() / periods.len() as f64;
    let off = periods.into_iter().map(|period| Measured {
        value: (period.value - mean_s).abs(),
        ..period
    });
    view.within(off, [0.0, EDGE_S], NS, (step, text))
}

fn width(view: &View<'_>, step: &'static str, text: &str) -> Step {
    let off_s = CONVST_HIGH_S * CLOCK_SHARE + EDGE_S;
    let range = [CONVST_HIGH_S - off_s, CONVST_HIGH_S + off_s];
    let pulses = view.line(Line::Convst).pulses(true);
    let widths = pulses.iter().filter_map(|pulse| {
        let value = view.width_s(pulse, range[1])?;
        Some(Measured {
            at_s: pulse.begin_s,
            value,
        })
    });
    view.within(widths, range, US, (step, text))
}
