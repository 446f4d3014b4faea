//! Horizontal bars in named groups.

use super::Chart;
use crate::html::svg::{Area, Drawn, GRID, INK, Mark, Trouble, short, text, width};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// One bar of a group, from zero to its value.
pub struct Bar {
    /// Where it ends.
    pub value: f64,
    /// Where what it lost of the bar before it ended: drawn pale up to there.
    pub was: Option<f64>,
    /// Interval about the value.
    pub interval: Option<[f64; 2]>,
    /// Colour.
    pub colour: RGBColor,
    /// What stands at its end.
    pub label: String,
    /// What a pointer is told.
    pub told: String,
}

/// A name and its bars.
pub type Group = (String, Vec<Bar>);

/// The axis of bars.
pub struct BarAxis<'a> {
    /// Its title, with the unit.
    pub title: &'a str,
    /// A value that is marked over all groups, and its name.
    pub line: Option<(f64, &'a str)>,
}

/// Heights of bars, for a desk and for a phone: a bar, the name over a group on a phone, and what is above and below.
pub fn heights(groups: usize, bars: usize) -> [u32; 2] {
    let [groups, bars] = [groups, bars].map(|n| n as u32);
    [
        90 + groups * (14 + 24 * bars),
        90 + groups * (30 + 22 * bars),
    ]
}

/// An interval that reaches farther than so many times the longest bar would press all bars flat: it ends there, open.
const WIDEST: f64 = 1.35;

/// Draws them, each with its label at its end.
pub fn bars(area: &Area, narrow: bool, groups: &[Group], axis: &BarAxis) -> Drawn {
    let limit = limit(groups);
    let mut chart = axes(area, narrow, groups, (axis, limit))?;
    let base = area.get_base_pixel();
    let write = |told: &str, (x, y): (i32, i32), side: HPos| {
        let style = text(narrow).pos(Pos::new(side, VPos::Center));
        area.draw(&Text::new(told.to_owned(), (x - base.0, y - base.1), style))
    };
    // On a phone a group's name stands over its bars.
    let head = if narrow { 0.36 } else { 0.06 };
    let mut marks = Vec::new();
    for (g, (name, bars)) in groups.iter().enumerate() {
        let upper = groups.len() as f64 - g as f64;
        let (at, side) = if narrow {
            let (x, y) = chart.backend_coord(&(0.0, upper - 0.2));
            let line = axis.line.map(|l| chart.backend_coord(&(l.0, upper)).0);
            ((beside(line, x, width(name, narrow)), y), HPos::Left)
        } else {
            let (x, y) = chart.backend_coord(&(0.0, upper - 0.5));
            ((x - 8, y), HPos::Right)
        };
        write(name, at, side)?;
        let thick = (0.94 - head) / bars.len().max(1) as f64;
        for (b, bar) in bars.iter().enumerate() {
            let high = upper - head - b as f64 * thick;
            let low = high - 0.84 * thick;
            draw(&mut chart, bar, [low, high], limit)?;
            let (x, y) = chart.backend_coord(&(tip(bar).min(limit), 0.5 * (low + high)));
            let line = axis.line.map(|l| chart.backend_coord(&(l.0, low)).0);
            let x = beside(line, x + 6, width(&bar.label, narrow));
            write(&bar.label, (x, y), HPos::Left)?;
            let (left, above) = chart.backend_coord(&(0.0, high));
            let (right, below) = chart.backend_coord(&(end(bar).min(limit), low));
            marks.push(Mark {
                edges: [left, above, right.max(left + 24), below],
                told: bar.told.clone(),
            });
        }
    }
    if let Some((value, name)) = axis.line {
        let ends = [(value, 0.0), (value, groups.len() as f64)];
        chart.draw_series(LineSeries::new(ends, INK.stroke_width(1)))?;
        let (x, y) = chart.backend_coord(&ends[1]);
        // Centred over its line, but never out of the drawing.
        let least = base.0 + width(name, narrow) / 2;
        write(name, (x.max(least), y - 9), HPos::Center)?;
    }
    Ok(marks)
}

/// Where the axis ends at most.
fn limit(groups: &[Group]) -> f64 {
    let all = groups.iter().flat_map(|g| &g.1);
    WIDEST
        * all
            .map(|b| b.value.max(b.was.unwrap_or(0.0)))
            .fold(0.0, f64::max)
}

/// The axis, and room for names to the left and labels to the right.
fn axes<'a, 'b>(
    area: &'a Area<'b>,
    narrow: bool,
    groups: &[Group],
    (axis, limit): (&BarAxis, f64),
) -> Result<Chart<'a, 'b>, Trouble> {
    let all = || groups.iter().flat_map(|g| &g.1);
    let ends = all().map(|b| end(b).min(limit));
    let top = ends.chain(axis.line.map(|l| l.0)).fold(0.0, f64::max);
    let longest = |texts: Vec<&String>| texts.iter().map(|t| width(t, narrow)).max().unwrap_or(0);
    let names = if narrow {
        4
    } else {
        12 + longest(groups.iter().map(|g| &g.0).collect())
    };
    let mut chart = ChartBuilder::on(area)
        .margin(6)
        .margin_top(if axis.line.is_some() { 24 } else { 6 })
        .margin_right(12 + longest(all().map(|b| &b.label).collect()))
        .x_label_area_size(46)
        .y_label_area_size(names)
        .build_cartesian_2d(0.0..top.max(1e-9) * 1.02, 0.0..groups.len().max(1) as f64)?;
    chart
        .configure_mesh()
        .disable_y_mesh()
        .disable_y_axis()
        .light_line_style(TRANSPARENT)
        .bold_line_style(GRID)
        .axis_style(GRID)
        .label_style(text(narrow))
        .x_desc(axis.title)
        .x_labels(if area.dim_in_pixel().0 < 500 { 4 } else { 8 })
        .x_label_formatter(&|v| short(*v))
        .draw()?;
    Ok(chart)
}

/// One bar between two heights, with its interval.
fn draw(chart: &mut Chart, bar: &Bar, [low, high]: [f64; 2], limit: f64) -> Result<(), Trouble> {
    let filled =
        |from: f64, to: f64, style: ShapeStyle| Rectangle::new([(from, low), (to, high)], style);
    if let Some(was) = bar.was.filter(|was| *was > bar.value) {
        let pale = bar.colour.mix(0.22).filled();
        chart.draw_series([filled(bar.value, was, pale)])?;
    }
    chart.draw_series([filled(0.0, bar.value, bar.colour.filled())])?;
    let Some(interval) = bar.interval else {
        return Ok(());
    };
    let (middle, cap) = (0.5 * (low + high), 0.25 * (high - low));
    let ends = interval.map(|x| x.clamp(0.0, limit));
    let ink = INK.stroke_width(2);
    chart.draw_series(LineSeries::new(ends.map(|x| (x, middle)), ink))?;
    for x in ends.into_iter().filter(|x| *x < limit) {
        let line = [(x, middle - cap), (x, middle + cap)];
        chart.draw_series(LineSeries::new(line, ink))?;
    }
    Ok(())
}

/// Where a label begins: to the right of a line that would go through it.
fn beside(line: Option<i32>, x: i32, wide: i32) -> i32 {
    match line {
        Some(line) if (x - 3..x + wide).contains(&line) => line + 5,
        _ => x,
    }
}

/// Where a bar's label stands: at its value, beyond the interval about it.
fn tip(bar: &Bar) -> f64 {
    bar.value.max(bar.interval.map_or(0.0, |i| i[1]))
}

/// The farthest that a bar and what belongs to it reach.
fn end(bar: &Bar) -> f64 {
    tip(bar).max(bar.was.unwrap_or(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::html::svg::{AFTER, plot};

    fn bar(value: f64, was: Option<f64>, interval: Option<[f64; 2]>) -> Bar {
        Bar {
            value,
            was,
            interval,
            colour: AFTER,
            label: "here".into(),
            told: String::new(),
        }
    }

    /// Left edge of a text in a drawing.
    fn left_edge(svg: &str, told: &str) -> i32 {
        let label = svg.rfind(told).expect("a label");
        let text = &svg[svg[..label].rfind("<text").expect("an element")..label];
        let x = text
            .split(" x=\"")
            .nth(1)
            .and_then(|rest| rest.split('"').next());
        x.and_then(|x| x.parse().ok()).expect("a place")
    }

    /// Left edge of the label of a bar that is alone beside a bar of ten.
    fn label_at(value: f64, was: Option<f64>) -> i32 {
        let groups = [(
            "of ten".to_owned(),
            vec![bar(10.0, None, None), bar(value, was, None)],
        )];
        let axis = BarAxis {
            title: "",
            line: None,
        };
        let plots = plot("", [200, 200], |area, narrow| {
            bars(area, narrow, &groups, &axis)
        });
        left_edge(&plots[0].svg, "here")
    }

    /// Left edge of the name of a group on a phone, where a line is marked.
    fn name_at(line: Option<f64>) -> i32 {
        let groups = [("of ten".to_owned(), vec![bar(10.0, None, None)])];
        let axis = BarAxis {
            title: "",
            line: line.map(|value| (value, "line")),
        };
        let plots = plot("", [200, 200], |area, narrow| {
            bars(area, narrow, &groups, &axis)
        });
        left_edge(&plots[1].svg, "of ten")
    }

    #[test]
    fn no_line_goes_through_a_name_on_a_phone() {
        assert!(name_at(Some(0.5)) > name_at(None));
        assert_eq!(name_at(Some(9.0)), name_at(None));
    }

    #[test]
    fn a_label_stands_at_its_value_and_not_where_the_bar_was_before() {
        assert_eq!(label_at(2.0, Some(9.0)), label_at(2.0, None));
        assert!(label_at(9.0, None) > label_at(2.0, None) + 300);
    }

    #[test]
    fn an_interval_far_beyond_all_bars_does_not_press_them_flat() {
        let groups = [("one".to_owned(), vec![bar(10.0, None, Some([9.0, 700.0]))])];
        assert!((limit(&groups) - 13.5).abs() < 1e-9);
    }

    #[test]
    fn no_line_goes_through_a_label() {
        assert_eq!(beside(Some(110), 100, 40), 115);
        assert_eq!(beside(Some(90), 100, 40), 100);
        assert_eq!(beside(None, 100, 40), 100);
    }
}
