//! The plots of the report. Lengths are drawn in micrometres.

use super::spectrum::Line;
use super::svg::{AFTER, Area, BEFORE, Drawn, FLOOR, GRID, GROUND, INK, short, text, widened};
use super::telling::Bin;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Micrometres a metre.
pub const MICRO: f64 = 1.0e6;

/// One bar of a group: value, its interval, colour.
pub struct Bar {
    /// Where it begins; zero but for the steps of a waterfall.
    pub from: f64,
    /// Where it ends.
    pub value: f64,
    /// Interval about it.
    pub interval: Option<[f64; 2]>,
    /// Colour.
    pub colour: RGBColor,
}

/// Horizontal bars in named groups.
pub fn bars(area: &Area, narrow: bool, groups: &[(String, Vec<Bar>)], axis: &str) -> Drawn {
    let top = groups
        .iter()
        .flat_map(|g| &g.1)
        .map(|b| {
            b.interval
                .map_or(b.value.max(b.from), |i| b.value.max(i[1]))
        })
        .fold(0.0, f64::max);
    let count = groups.len().max(1) as f64;
    let longest = groups
        .iter()
        .map(|g| g.0.chars().count())
        .max()
        .unwrap_or(0) as u32;
    let mut chart = ChartBuilder::on(area)
        .margin(8)
        .margin_right(if narrow { 44 } else { 64 })
        .x_label_area_size(38)
        .y_label_area_size(12 + longest * if narrow { 6 } else { 8 })
        .build_cartesian_2d(0.0..top.max(1e-9) * 1.05, 0.0..count)?;
    chart
        .configure_mesh()
        .disable_y_mesh()
        .disable_y_axis()
        .light_line_style(TRANSPARENT)
        .bold_line_style(GRID)
        .axis_style(GRID)
        .label_style(text(narrow))
        .x_desc(axis)
        .x_labels(if narrow { 4 } else { 8 })
        .x_label_formatter(&|v| short(*v))
        .draw()?;
    let end = Pos::new(HPos::Right, VPos::Center);
    let start = Pos::new(HPos::Left, VPos::Center);
    for (g, (name, bars)) in groups.iter().enumerate() {
        let upper = count - g as f64;
        let thick = 0.8 / bars.len().max(1) as f64;
        let middle = chart.backend_coord(&(0.0, upper - 0.5));
        area.draw(&Text::new(
            name.clone(),
            (middle.0 - 8, middle.1),
            text(narrow).pos(end),
        ))?;
        for (b, bar) in bars.iter().enumerate() {
            let high = upper - 0.1 - b as f64 * thick;
            let low = high - 0.86 * thick;
            chart.draw_series(std::iter::once(Rectangle::new(
                [
                    (bar.from.min(bar.value), low),
                    (bar.from.max(bar.value), high),
                ],
                bar.colour.filled(),
            )))?;
            let mut right = bar.value.max(bar.from);
            if let Some([from, to]) = bar.interval {
                let y = 0.5 * (low + high);
                chart.draw_series(LineSeries::new(
                    [(from.max(0.0), y), (to.max(0.0), y)],
                    INK.stroke_width(1),
                ))?;
                right = right.max(to);
            }
            let at = chart.backend_coord(&(right, 0.5 * (low + high)));
            area.draw(&Text::new(
                short(bar.value),
                (at.0 + 5, at.1),
                text(narrow).pos(start),
            ))?;
        }
    }
    Ok(())
}

/// Axes, and what goes on them.
pub struct Axes<'a> {
    /// Horizontal range.
    pub x: std::ops::Range<f64>,
    /// Vertical range.
    pub y: std::ops::Range<f64>,
    /// Horizontal title.
    pub x_title: &'a str,
    /// Vertical title.
    pub y_title: &'a str,
    /// Title of the plot.
    pub title: &'a str,
}

/// Points with the means of cells over them.
pub fn scatter(
    area: &Area,
    narrow: bool,
    axes: &Axes,
    points: &[(f64, f64)],
    means: &[(f64, f64)],
    colour: RGBColor,
) -> Drawn {
    let mut chart = ChartBuilder::on(area)
        .margin(8)
        .caption(axes.title, text(narrow))
        .x_label_area_size(38)
        .y_label_area_size(if narrow { 44 } else { 52 })
        .build_cartesian_2d(axes.x.clone(), axes.y.clone())?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(GRID)
        .axis_style(GRID)
        .label_style(text(narrow))
        .x_desc(axes.x_title)
        .y_desc(axes.y_title)
        .x_labels(if narrow { 4 } else { 6 })
        .y_labels(6)
        .x_label_formatter(&|v| short(*v))
        .y_label_formatter(&|v| short(*v))
        .draw()?;
    let inside = |y: f64| y.clamp(axes.y.start, axes.y.end);
    chart.draw_series(
        points
            .iter()
            .map(|&(x, y)| Circle::new((x, inside(y)), 1, colour.mix(0.35).filled())),
    )?;
    chart.draw_series(LineSeries::new(
        means.iter().map(|&(x, y)| (x, inside(y))),
        GROUND.stroke_width(5),
    ))?;
    chart.draw_series(LineSeries::new(
        means.iter().map(|&(x, y)| (x, inside(y))),
        colour.stroke_width(3),
    ))?;
    Ok(())
}

/// Means of cells as points, µm.
pub fn curve(bins: &[Bin], pick: fn(&Bin) -> f64) -> Vec<(f64, f64)> {
    bins.iter().map(|bin| (bin.at, MICRO * pick(bin))).collect()
}

/// Amplitude over order or frequency, before and after.
pub fn lines(area: &Area, narrow: bool, title: &str, axis: &str, spectrum: &[Line]) -> Drawn {
    let top = spectrum
        .iter()
        .map(|l| l.before_m.max(l.after_m))
        .fold(0.0, f64::max)
        * MICRO;
    let last = spectrum.last().map_or(1.0, |l| l.at);
    let mut chart = ChartBuilder::on(area)
        .margin(8)
        .caption(title, text(narrow))
        .x_label_area_size(38)
        .y_label_area_size(if narrow { 44 } else { 52 })
        .build_cartesian_2d(0.0..last * 1.02, 0.0..(top * 1.08).max(1e-9))?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(GRID)
        .axis_style(GRID)
        .label_style(text(narrow))
        .x_desc(axis)
        .y_desc("amplitude, µm")
        .x_labels(if narrow { 5 } else { 9 })
        .y_labels(5)
        .x_label_formatter(&|v| short(*v))
        .y_label_formatter(&|v| short(*v))
        .draw()?;
    chart.draw_series(
        AreaSeries::new(
            spectrum.iter().map(|l| (l.at, MICRO * l.before_m)),
            0.0,
            BEFORE.mix(0.25),
        )
        .border_style(BEFORE.stroke_width(2)),
    )?;
    chart.draw_series(LineSeries::new(
        spectrum.iter().map(|l| (l.at, MICRO * l.after_m)),
        AFTER.stroke_width(2),
    ))?;
    Ok(())
}

/// A cell of the map: place in millimetres, mean residual in micrometres.
pub type Cell = ([f64; 2], f64);

/// Mean residuals over the platen; `size` is a cell's side, mm, `full` the value at full colour.
pub fn map(area: &Area, narrow: bool, title: &str, cells: &[Cell], size: f64, full: f64) -> Drawn {
    let bound = |axis: usize| {
        let values = cells.iter().map(|c| c.0[axis]);
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
            (l.min(v - 0.5 * size), h.max(v + 0.5 * size))
        })
    };
    let mut chart = ChartBuilder::on(area)
        .margin(8)
        .caption(title, text(narrow))
        .x_label_area_size(38)
        .y_label_area_size(if narrow { 44 } else { 52 })
        .build_cartesian_2d(widened(bound(0), 0.03), widened(bound(1), 0.03))?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(GRID)
        .axis_style(GRID)
        .label_style(text(narrow))
        .x_desc("x, mm")
        .y_desc("y, mm")
        .x_labels(if narrow { 4 } else { 6 })
        .y_labels(5)
        .x_label_formatter(&|v| short(*v))
        .y_label_formatter(&|v| short(*v))
        .draw()?;
    chart.draw_series(cells.iter().map(|&([x, y], value)| {
        let colour = if value > 0.0 { BEFORE } else { AFTER };
        let half = 0.5 * size;
        Rectangle::new(
            [(x - half, y - half), (x + half, y + half)],
            colour.mix((value.abs() / full).clamp(0.06, 1.0)).filled(),
        )
    }))?;
    Ok(())
}

/// Colour of a waterfall's step.
pub fn step_colour(first: bool, last: bool) -> RGBColor {
    if first {
        BEFORE
    } else if last {
        FLOOR
    } else {
        AFTER
    }
}
