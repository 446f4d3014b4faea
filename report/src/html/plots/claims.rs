//! How far claims are from what came true.

use super::{Axes, chart_told};
use crate::html::svg::{AFTER, Area, BEFORE, Drawn, FLOOR, INK, Mark, times};
use plotters::prelude::*;

/// One claim.
pub struct Claimed {
    /// What came true, multiples of the floor.
    pub confirmed: f64,
    /// What was claimed over it, less one.
    pub off: f64,
    /// What a pointer is told.
    pub told: String,
}

/// Claims farther off than this are drawn at the edge, as squares.
const EDGE: f64 = 0.5;
/// Least multiple of the floor that is drawn: the axis is logarithmic.
const LEAST: f64 = 0.1;

/// Room to the right, pixels: the last number of the axis is centred over its end, and four digits are 28 wide.
const LAST_LABEL: i32 = 24;

/// Draws claims by what came true; those within `right` of it lie in the band.
pub fn claims(area: &Area, narrow: bool, list: &[Claimed], right: f64) -> Drawn {
    let most = |values: &dyn Fn(&Claimed) -> f64| list.iter().map(values).fold(0.0, f64::max);
    let limit = 110.0 * most(&|c| c.off.abs()).clamp(1.5 * right, EDGE);
    let place = |claim: &Claimed| claim.confirmed.max(LEAST).log2();
    let places = || list.iter().map(place);
    let first = places().fold(0.0, f64::min) - 0.1;
    let last = places().fold(0.3, f64::max) + 0.1;
    let axes = Axes {
        x: first..last,
        y: -limit..limit,
        x_title: "what came true, multiples of the floor",
        y_title: "claim too large by, %",
        title: "",
    };
    let mut chart = chart_told(area, narrow, &axes, LAST_LABEL, |v| times(v.exp2()))?;
    let band = [(first, -100.0 * right), (last, 100.0 * right)];
    chart.draw_series([Rectangle::new(band, FLOOR.mix(0.3).filled())])?;
    let zero = [(first, 0.0), (last, 0.0)];
    chart.draw_series(LineSeries::new(zero, INK.stroke_width(1)))?;
    let mut marks = Vec::new();
    for claim in list {
        let inside = (100.0 * claim.off).clamp(-limit, limit);
        let at = (place(claim), inside);
        let (x, y) = chart.backend_coord(&at);
        if claim.off.abs() > EDGE {
            let corners = [(x - 5, y - 5), (x + 5, y + 5)];
            let base = area.get_base_pixel();
            let corners = corners.map(|(x, y)| (x - base.0, y - base.1));
            area.draw(&Rectangle::new(corners, BEFORE.filled()))?;
        } else {
            let colour = if claim.off.abs() > right {
                BEFORE
            } else {
                AFTER
            };
            chart.draw_series([Circle::new(at, 4, colour.mix(0.8).filled())])?;
        }
        marks.push(Mark {
            edges: [x - 7, y - 7, x + 7, y + 7],
            told: claim.told.clone(),
        });
    }
    Ok(marks)
}
