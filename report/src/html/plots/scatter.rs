//! Points over a coordinate, with the means of its cells.

use super::{Axes, chart};
use crate::html::svg::{Area, Drawn, FLOOR, GROUND, Mark};
use plotters::prelude::*;

/// The mean of a cell.
pub struct Mean {
    /// Middle of the cell.
    pub at: f64,
    /// Mean in it.
    pub value: f64,
    /// What a pointer is told.
    pub told: String,
}

/// Draws points, and means over them as a line. A band about zero reaches as far as `band` to either side.
pub fn scatter(
    area: &Area,
    narrow: bool,
    axes: &Axes,
    points: &[(f64, f64)],
    means: &[Mean],
    (colour, band): (RGBColor, f64),
) -> Drawn {
    let mut chart = chart(area, narrow, axes, 0)?;
    let inside = |y: f64| y.clamp(axes.y.start, axes.y.end);
    if band > 0.0 {
        let corners = [(axes.x.start, inside(-band)), (axes.x.end, inside(band))];
        chart.draw_series([Rectangle::new(corners, FLOOR.mix(0.3).filled())])?;
    }
    let dots = points.iter().map(|&(x, y)| (x, inside(y)));
    chart.draw_series(dots.map(|at| Circle::new(at, 2, colour.mix(0.3).filled())))?;
    let line = || means.iter().map(|m| (m.at, inside(m.value)));
    for style in [GROUND.stroke_width(5), colour.stroke_width(3)] {
        chart.draw_series(LineSeries::new(line(), style))?;
    }
    let half = half_cell(means);
    let mark = |mean: &Mean| {
        let [from, to] = [-half, half].map(|by| (mean.at + by).clamp(axes.x.start, axes.x.end));
        let (left, top) = chart.backend_coord(&(from, axes.y.end));
        let (right, bottom) = chart.backend_coord(&(to, axes.y.start));
        Mark {
            edges: [left, top, right, bottom],
            told: mean.told.clone(),
        }
    };
    Ok(means.iter().map(mark).collect())
}

/// Half the width of a cell: of the closest two.
fn half_cell(means: &[Mean]) -> f64 {
    let steps = means.windows(2).map(|w| w[1].at - w[0].at);
    let least = steps.fold(f64::INFINITY, f64::min);
    if least.is_finite() { 0.5 * least } else { 0.0 }
}
