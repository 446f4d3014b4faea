//! A map of the platen with equal axes and a colour bar.

use super::{Axes, chart};
use crate::html::svg::{Area, Drawn, MINUS, Mark, PLUS, short, text};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// A cell of the map: place in millimetres, mean residual in micrometres.
pub type Cell = ([f64; 2], f64);

/// What all maps of a figure share.
#[derive(Clone, Copy)]
pub struct Scale {
    /// Side of a cell, mm.
    pub cell_mm: f64,
    /// Value at full colour, µm.
    pub full_um: f64,
}

/// Steps of the colour bar.
const STEPS: i32 = 24;
/// Width of the colour bar with its numbers.
const BAR: [i32; 2] = [84, 74];

/// Mean residuals over the platen. A millimetre is as long to the right as upwards.
pub fn map(area: &Area, narrow: bool, title: &str, cells: &[Cell], scale: Scale) -> Drawn {
    let right = BAR[usize::from(narrow)];
    let [x, y] = ranges(cells, scale.cell_mm, room(area, narrow, right));
    let (x_title, y_title) = ("x, mm", "y, mm");
    let axes = Axes {
        x,
        y,
        x_title,
        y_title,
        title,
    };
    let mut chart = chart(area, narrow, &axes, right)?;
    let half = 0.5 * scale.cell_mm;
    let square = |&([x, y], value): &Cell| {
        let corners = [(x - half, y - half), (x + half, y + half)];
        Rectangle::new(corners, style(value / scale.full_um))
    };
    chart.draw_series(cells.iter().map(square))?;
    let mark = |&([x, y], value): &Cell| {
        let (left, top) = chart.backend_coord(&(x - half, y + half));
        let (right, bottom) = chart.backend_coord(&(x + half, y - half));
        let told = format!("x {} mm, y {} mm: {} µm", short(x), short(y), short(value));
        Mark {
            edges: [left, top, right, bottom],
            told,
        }
    };
    let marks = cells.iter().map(mark).collect();
    let corner = chart.backend_coord(&(axes.x.end, axes.y.end));
    let foot = chart.backend_coord(&(axes.x.end, axes.y.start));
    colour_bar(
        area,
        narrow,
        (corner.0 + 14, corner.1 + 18, foot.1),
        scale.full_um,
    )?;
    Ok(marks)
}

/// Colour of a value over the one of full colour: beyond it, that one's.
fn style(share: f64) -> ShapeStyle {
    let colour = if share > 0.0 { PLUS } else { MINUS };
    colour.mix(share.abs().clamp(0.04, 1.0)).filled()
}

/// Colours from the largest value down to the smallest, with numbers.
fn colour_bar(
    area: &Area,
    narrow: bool,
    (x, top, foot): (i32, i32, i32),
    full_um: f64,
) -> Result<(), crate::html::svg::Trouble> {
    let base = area.get_base_pixel();
    let (x, top, foot) = (x - base.0, top - base.1, foot - base.1);
    let at = |step: i32| top + (foot - top) * step / STEPS;
    for step in 0..STEPS {
        let share = 1.0 - 2.0 * (f64::from(step) + 0.5) / f64::from(STEPS);
        area.draw(&Rectangle::new(
            [(x, at(step)), (x + 12, at(step + 1))],
            style(share),
        ))?;
    }
    let write = |told: String, at: (i32, i32)| {
        let middle = Pos::new(HPos::Left, VPos::Center);
        area.draw(&Text::new(told, at, text(narrow).pos(middle)))
    };
    write("µm".into(), (x, top - 12))?;
    for (share, y) in [(1.0, top + 4), (0.0, (top + foot) / 2), (-1.0, foot - 4)] {
        let sign = if share > 0.0 { "+" } else { "" };
        write(format!("{sign}{}", short(share * full_um)), (x + 17, y))?;
    }
    Ok(())
}

/// Width and height that the axes leave, in units of the drawing.
fn room(area: &Area, narrow: bool, right: i32) -> [f64; 2] {
    let (width, height) = area.dim_in_pixel();
    let left = if narrow { 54.0 } else { 62.0 };
    [
        f64::from(width) - left - f64::from(right) - 16.0,
        f64::from(height) - 46.0 - 12.0 - 20.0,
    ]
}

/// Ranges that hold all cells and have the same scale in a room of this size.
fn ranges(cells: &[Cell], side: f64, room: [f64; 2]) -> [std::ops::Range<f64>; 2] {
    let bound = |axis: usize| {
        let values = cells.iter().map(|c| c.0[axis]);
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
            (l.min(v - side), h.max(v + side))
        })
    };
    let bounds = [bound(0), bound(1)];
    let needed = |axis: usize| (bounds[axis].1 - bounds[axis].0) / room[axis].max(1.0);
    let unit = needed(0).max(needed(1));
    [0, 1].map(|axis| {
        let middle = 0.5 * (bounds[axis].0 + bounds[axis].1);
        let half = 0.5 * unit * room[axis].max(1.0);
        middle - half..middle + half
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_millimetre_is_as_long_either_way_and_all_cells_are_inside() {
        let cells = [([0.0, 0.0], 1.0), ([40.0, 2.0], -1.0)];
        for room in [[300.0, 200.0], [200.0, 300.0], [100.0, 1000.0]] {
            let [x, y] = ranges(&cells, 1.0, room);
            let scale = [&x, &y].map(|r| r.end - r.start);
            assert!((scale[0] / room[0] - scale[1] / room[1]).abs() < 1e-12);
            assert!(x.start <= -1.0 && x.end >= 41.0 && y.start <= -1.0 && y.end >= 3.0);
        }
    }
}
