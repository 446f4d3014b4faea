//! Plots as inline SVG that follows the page's colours: drawn with stand-in colours, which become CSS variables.

use plotters::coord::Shift;
use plotters::prelude::*;

/// Where a plot is drawn.
pub type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
/// What drawing may fail with.
pub type Trouble = Box<dyn std::error::Error + Send + Sync>;
/// Outcome of drawing: what a pointer may ask about.
pub type Drawn = Result<Vec<Mark>, Trouble>;

/// A part of a plot that tells its numbers when a pointer is over it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mark {
    /// Left, top, right and bottom edge, in units of the drawing.
    pub edges: [i32; 4],
    /// What it tells.
    pub told: String,
}

/// Text and axes.
pub const INK: RGBColor = RGBColor(1, 1, 1);
/// Grid.
pub const GRID: RGBColor = RGBColor(1, 1, 2);
/// Before: the baseline alone.
pub const BEFORE: RGBColor = RGBColor(1, 1, 3);
/// After: with what is named.
pub const AFTER: RGBColor = RGBColor(1, 1, 4);
/// The simulator's own scatter.
pub const FLOOR: RGBColor = RGBColor(1, 1, 5);
/// The page's ground.
pub const GROUND: RGBColor = RGBColor(1, 1, 6);
/// Positive values of a map.
pub const PLUS: RGBColor = RGBColor(1, 1, 7);
/// Negative values of a map.
pub const MINUS: RGBColor = RGBColor(1, 1, 8);

/// Stand-ins and the variables they become.
const VARIABLES: [(&str, &str); 8] = [
    ("#010101", "var(--ink)"),
    ("#010102", "var(--grid)"),
    ("#010103", "var(--before)"),
    ("#010104", "var(--after)"),
    ("#010105", "var(--floor)"),
    ("#010106", "var(--card)"),
    ("#010107", "var(--plus)"),
    ("#010108", "var(--minus)"),
];

/// Width of a plot for a desk and for a phone: close to what the page gives it there, so that text keeps its size.
const WIDTHS: [u32; 2] = [900, 340];
/// Height of letters for a desk and for a phone, CSS pixels at those widths.
const LETTERS_PX: [f64; 2] = [13.0, 12.0];
/// The backend divides a font's size by this (plotters-svg, `draw_text`).
const FONT_UNIT: f64 = 1.24;

/// A plot for one width of screen.
pub struct Plot {
    /// The `svg` element; empty if it could not be drawn.
    pub svg: String,
    /// True for the narrow one.
    pub narrow: bool,
}

/// Draws a plot twice, for a desk and for a phone. `label` is read out in its place; `heights` are those of the two.
pub fn plot(label: &str, heights: [u32; 2], draw: impl Fn(&Area, bool) -> Drawn) -> Vec<Plot> {
    let sizes = WIDTHS.into_iter().zip(heights).zip([false, true]);
    sizes
        .map(|(size, narrow)| Plot {
            svg: svg(size, label, |area| draw(area, narrow)).unwrap_or_default(),
            narrow,
        })
        .collect()
}

fn svg(size: (u32, u32), label: &str, draw: impl Fn(&Area) -> Drawn) -> Result<String, Trouble> {
    let mut text = String::new();
    let marks = {
        let area = SVGBackend::with_string(&mut text, size).into_drawing_area();
        let marks = draw(&area)?;
        area.present()?;
        marks
    };
    for (colour, variable) in VARIABLES {
        text = text.replace(colour, variable);
    }
    let open = format!("<svg width=\"{}\" height=\"{}\" ", size.0, size.1);
    let label = maud::html! { (label) }.into_string();
    let labelled = format!(
        "<svg role=\"img\" aria-label=\"{}\" ",
        label.replace('"', "&quot;")
    );
    let close = format!("{}</svg>", elements(&marks));
    Ok(text.replacen(&open, &labelled, 1).replace("</svg>", &close))
}

/// Marks as rectangles without colour, over what was drawn.
fn elements(marks: &[Mark]) -> String {
    let element = |mark: &Mark| {
        let [left, top, right, bottom] = mark.edges;
        maud::html! {
            rect class="mark" x=(left) y=(top) width=((right - left).max(1)) height=((bottom - top).max(1)) data-told=(mark.told) {}
        }
        .into_string()
    };
    marks.iter().map(element).collect()
}

/// Style of labels and titles.
pub fn text(narrow: bool) -> TextStyle<'static> {
    let size = FONT_UNIT * LETTERS_PX[usize::from(narrow)];
    ("system-ui, sans-serif", size).into_font().color(&INK)
}

/// Width of a text, at most: letters are half as wide as they are high, and a little.
pub fn width(text: &str, narrow: bool) -> i32 {
    (0.6 * LETTERS_PX[usize::from(narrow)] * text.chars().count() as f64).ceil() as i32
}

/// A range with a margin on both sides; never empty.
pub fn widened((low, high): (f64, f64), share: f64) -> std::ops::Range<f64> {
    let margin = ((high - low) * share).max(1e-9);
    low - margin..high + margin
}

/// A number with as many digits as tell something.
pub fn short(value: f64) -> String {
    let digits = match value.abs() {
        v if v >= 100.0 => 0,
        v if v >= 10.0 => 1,
        v if v >= 0.1 || v == 0.0 => 2,
        v => (1.0 - v.log10().floor()).min(9.0) as usize,
    };
    let text = format!("{value:.digits$}");
    let text = if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.')
    } else {
        &text
    };
    if text == "-0" {
        "0".into()
    } else {
        text.replace('-', "−")
    }
}

/// A multiple, with two decimals where it is near one: there they tell something.
pub fn times(value: f64) -> String {
    if value < 10.0 {
        format!("{value:.2}")
    } else {
        short(value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_two_digits_that_tell_something() {
        let told = [25.46, 1234.0, 0.333, 0.012_34, -0.5, -0.0, 1.0e-12, 2.0].map(short);
        assert_eq!(
            told,
            ["25.5", "1234", "0.33", "0.012", "−0.5", "0", "0", "2"]
        );
    }

    #[test]
    fn a_mark_lies_over_its_plot_and_tells_its_text() {
        let plots = plot("a \"plot\"", [100, 80], |area, _| {
            area.fill(&GROUND)?;
            let told = "1 < 2".to_owned();
            Ok(vec![Mark {
                edges: [1, 2, 11, 22],
                told,
            }])
        });
        for plot in plots {
            assert!(
                plot.svg.contains("aria-label=\"a &quot;plot&quot;\""),
                "{}",
                plot.svg
            );
            assert!(plot.svg.contains("fill=\"var(--card)\""), "{}", plot.svg);
            let mark =
                "x=\"1\" y=\"2\" width=\"10\" height=\"20\" data-told=\"1 &lt; 2\"></rect></svg>";
            assert!(plot.svg.trim_end().ends_with(mark), "{}", plot.svg);
        }
    }
}
