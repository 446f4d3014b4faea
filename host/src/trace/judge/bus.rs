//! Both buses: clock and data of a converter's frame.

use super::super::Line;
use super::super::clock::{Frame, astray, frames, frequencies_hz};
use super::super::limits::{CLOCK_SHARE, FRAME_BITS, SCLK_HZ};
use super::super::measure::{MHZ, Wanted, all_there, told, within};
use super::view::{CLOCKS_S, Check, View};
use crate::acceptance::Step;

const CLOCK0: &[Line] = &[Line::Select(0), Line::Clock(0)];
const CLOCK1: &[Line] = &[Line::Select(1), Line::Clock(1)];

/// Their steps.
pub const CHECKS: &[Check] = &[
    Check {
        step: "SCLK0 frequency",
        lines: CLOCK0,
        coarsest_s: CLOCKS_S,
        wanted: frequency_wanted,
        judge: frequency::<0>,
    },
    Check {
        step: "SCLK1 frequency",
        lines: CLOCK1,
        coarsest_s: CLOCKS_S,
        wanted: frequency_wanted,
        judge: frequency::<1>,
    },
    Check {
        step: "SCLK0 bits",
        lines: CLOCK0,
        coarsest_s: CLOCKS_S,
        wanted: bits_wanted,
        judge: bits::<0>,
    },
    Check {
        step: "SCLK1 bits",
        lines: CLOCK1,
        coarsest_s: CLOCKS_S,
        wanted: bits_wanted,
        judge: bits::<1>,
    },
    Check {
        step: "SCLK0 at rest",
        lines: CLOCK0,
        coarsest_s: CLOCKS_S,
        wanted: || "no edge while CS0 is high".into(),
        judge: rest::<0>,
    },
    Check {
        step: "SCLK1 at rest",
        lines: CLOCK1,
        coarsest_s: CLOCKS_S,
        wanted: || "no edge while CS1 is high".into(),
        judge: rest::<1>,
    },
    Check {
        step: "DOUT0",
        lines: &[Line::Select(0), Line::Data(0)],
        coarsest_s: 2.0 * CLOCKS_S,
        wanted: data_wanted,
        judge: data::<0>,
    },
    Check {
        step: "DOUT1",
        lines: &[Line::Select(1), Line::Data(1)],
        coarsest_s: 2.0 * CLOCKS_S,
        wanted: data_wanted,
        judge: data::<1>,
    },
];

fn frequency_wanted() -> String {
    format!("{} ± {} %", told(SCLK_HZ, MHZ), 100.0 * CLOCK_SHARE)
}

fn bits_wanted() -> String {
    format!("{FRAME_BITS} in each frame")
}

fn data_wanted() -> String {
    "changes in each frame".into()
}

fn frames_of<const CHIP: usize>(view: &View<'_>) -> Vec<Frame> {
    let selected = view.line(Line::Select(CHIP)).pulses(false);
    frames(view.line(Line::Clock(CHIP)), &selected, view.span)
}

fn frequency<const CHIP: usize>(view: &View<'_>, step: &'static str, text: &str) -> Step {
    let (values, slack) = frequencies_hz(&frames_of::<CHIP>(view));
    let range = [SCLK_HZ * (1.0 - CLOCK_SHARE), SCLK_HZ * (1.0 + CLOCK_SHARE)];
    within(
        &values,
        Wanted {
            step,
            range,
            slack,
            unit: MHZ,
            text,
        },
    )
}

fn bits<const CHIP: usize>(view: &View<'_>, step: &'static str, wanted: &str) -> Step {
    let frames = frames_of::<CHIP>(view);
    let wrong = frames.iter().filter(|frame| frame.bits != FRAME_BITS);
    let wrong: Vec<(f64, String)> = wrong
        .map(|frame| (frame.at_s, format!("{} bits", frame.bits)))
        .collect();
    all_there(
        step,
        frames.len(),
        &wrong,
        &format!("frames of {FRAME_BITS} bits"),
        wanted,
    )
}

fn rest<const CHIP: usize>(view: &View<'_>, step: &'static str, wanted: &str) -> Step {
    let (clock, select) = (view.line(Line::Clock(CHIP)), view.line(Line::Select(CHIP)));
    let astray = astray(clock, select, view.span);
    match astray.first() {
        None => Step::new(step, true, "no edge".into(), wanted),
        Some(at_s) => Step::new(step, false, format!("{} edges", astray.len()), wanted).at(*at_s),
    }
}

fn data<const CHIP: usize>(view: &View<'_>, step: &'static str, wanted: &str) -> Step {
    let data = view.line(Line::Data(CHIP));
    let selected = view.line(Line::Select(CHIP)).pulses(false);
    let frames: Vec<(f64, f64)> = selected
        .iter()
        .filter_map(|pulse| Some((pulse.begin_s, pulse.end_s?)))
        .collect();
    let flat = frames
        .iter()
        .filter(|(begin_s, end_s)| data.between(*begin_s, *end_s).is_empty());
    let flat: Vec<(f64, String)> = flat
        .map(|(begin_s, _)| (*begin_s, "a frame of one level".to_owned()))
        .collect();
    all_there(step, frames.len(), &flat, "frames with changes", wanted)
}
