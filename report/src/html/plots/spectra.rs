//! Spectra: amplitudes over frequency as a line, over few orders as stems. The floor of each lies beneath.

use super::{Axes, MICRO, chart};
use crate::html::spectrum::Line;
use crate::html::svg::{AFTER, Area, BEFORE, Drawn, FLOOR, Mark, short};
use plotters::prelude::*;

/// What is drawn: lines, the name of their place, and whether before and after differ.
pub struct Spectrum<'a> {
    /// Its lines.
    pub lines: &'a [Line],
    /// Title of the horizontal axis.
    pub axis: &'a str,
    /// What a line is called, by its place.
    pub named: fn(f64) -> String,
    /// Draw what is left as well.
    pub after: bool,
}

/// Amplitude over frequency.
pub fn lines(area: &Area, narrow: bool, spectrum: &Spectrum) -> Drawn {
    let list = spectrum.lines;
    let last = list.last().map_or(1.0, |l| l.at);
    let mut chart = chart(area, narrow, &axes(spectrum, 0.0..last * 1.02), 0)?;
    let of = |pick: fn(&Line) -> f64| list.iter().map(move |l| (l.at, MICRO * pick(l)));
    let floor = AreaSeries::new(of(|l| l.floor_m), 0.0, FLOOR.mix(0.45));
    chart.draw_series(floor)?;
    chart.draw_series(LineSeries::new(of(|l| l.before_m), BEFORE.stroke_width(2)))?;
    if spectrum.after {
        chart.draw_series(LineSeries::new(of(|l| l.after_m), AFTER.stroke_width(2)))?;
    }
    let half = 0.5 * last / list.len().max(1) as f64;
    let top = MICRO * highest(list);
    let mark = |line: &Line| {
        let (left, above) = chart.backend_coord(&((line.at - half).max(0.0), top));
        let (right, below) = chart.backend_coord(&((line.at + half).min(last * 1.02), 0.0));
        Mark {
            edges: [left, above, right, below],
            told: told(spectrum, line),
        }
    };
    Ok(list.iter().map(mark).collect())
}

/// Amplitude of whole orders, each a stem before and a stem after on a bar as high as the floor.
pub fn stems(area: &Area, narrow: bool, spectrum: &Spectrum) -> Drawn {
    let list = spectrum.lines;
    let last = list.last().map_or(1.0, |l| l.at);
    let range = 0.4..last + 0.6;
    let mut chart = chart(area, narrow, &axes(spectrum, range), 0)?;
    let floor = |l: &Line| {
        let corners = [(l.at - 0.42, 0.0), (l.at + 0.42, MICRO * l.floor_m)];
        Rectangle::new(corners, FLOOR.mix(0.45).filled())
    };
    chart.draw_series(list.iter().map(floor))?;
    type Pick = fn(&Line) -> f64;
    let kinds: [(Pick, f64, RGBColor); 2] = [
        (
            |l| l.before_m,
            if spectrum.after { -0.16 } else { 0.0 },
            BEFORE,
        ),
        (|l| l.after_m, 0.16, AFTER),
    ];
    let thick = if narrow { 2 } else { 4 };
    for (pick, aside, colour) in kinds.into_iter().take(1 + usize::from(spectrum.after)) {
        for line in list {
            let (x, y) = (line.at + aside, MICRO * pick(line));
            let stem = [(x, 0.0), (x, y)];
            chart.draw_series(LineSeries::new(stem, colour.stroke_width(thick)))?;
            chart.draw_series([Circle::new((x, y), 1 + thick, colour.filled())])?;
        }
    }
    let top = MICRO * highest(list);
    let mark = |line: &Line| {
        let (left, above) = chart.backend_coord(&(line.at - 0.5, top));
        let (right, below) = chart.backend_coord(&(line.at + 0.5, 0.0));
        Mark {
            edges: [left, above, right, below],
            told: told(spectrum, line),
        }
    };
    Ok(list.iter().map(mark).collect())
}

fn axes<'a>(spectrum: &'a Spectrum, x: std::ops::Range<f64>) -> Axes<'a> {
    Axes {
        x,
        y: 0.0..(MICRO * highest(spectrum.lines) * 1.08).max(1e-9),
        x_title: spectrum.axis,
        y_title: "amplitude, µm",
        title: "",
    }
}

fn highest(list: &[Line]) -> f64 {
    let all = list.iter().flat_map(|l| [l.before_m, l.after_m, l.floor_m]);
    all.fold(0.0, f64::max)
}

fn told(spectrum: &Spectrum, line: &Line) -> String {
    let micro = |v: f64| short(MICRO * v);
    let after = if spectrum.after {
        format!(", {} µm after", micro(line.after_m))
    } else {
        String::new()
    };
    format!(
        "{}: {} µm before{after}; floor {} µm",
        (spectrum.named)(line.at),
        micro(line.before_m),
        micro(line.floor_m)
    )
}
