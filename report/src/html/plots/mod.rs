//! The plots of the report: from numbers to a drawing, and to what a pointer may ask about. Lengths are drawn in micrometres.

mod bars;
mod claims;
mod map;
mod scatter;
mod spectra;

pub use bars::{Bar, BarAxis, Group, bars, heights};
pub use claims::{Claimed, claims};
pub use map::{Cell, Scale, map};
pub use scatter::{Mean, scatter};
pub use spectra::{Spectrum, lines, stems};

use super::svg::{Area, GRID, Trouble, short, text};
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

/// Micrometres a metre.
pub const MICRO: f64 = 1.0e6;

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
    /// Title of the plot; may be empty.
    pub title: &'a str,
}

/// A chart with two axes of numbers.
type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// A chart with axes, their titles and a grid. `right` is what is kept free to its right.
fn chart<'a, 'b>(
    area: &'a Area<'b>,
    narrow: bool,
    axes: &Axes,
    right: i32,
) -> Result<Chart<'a, 'b>, Trouble> {
    chart_told(area, narrow, axes, right, short)
}

/// The same with the numbers of the horizontal axis told otherwise.
fn chart_told<'a, 'b>(
    area: &'a Area<'b>,
    narrow: bool,
    axes: &Axes,
    right: i32,
    told: fn(f64) -> String,
) -> Result<Chart<'a, 'b>, Trouble> {
    let mut builder = ChartBuilder::on(area);
    if !axes.title.is_empty() {
        builder.caption(axes.title, text(narrow));
    }
    let mut chart = builder
        .margin(6)
        .margin_right(10 + right)
        .x_label_area_size(46)
        .y_label_area_size(if narrow { 54 } else { 62 })
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
        .y_labels(5)
        .x_label_formatter(&|v| told(*v))
        .y_label_formatter(&|v| short(*v))
        .draw()?;
    Ok(chart)
}
