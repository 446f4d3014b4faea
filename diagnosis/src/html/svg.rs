//! Plots as inline SVG that follows the page's colours: drawn with stand-in colours, which become CSS variables.

use plotters::coord::Shift;
use plotters::prelude::*;

/// Where a plot is drawn.
pub type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
/// Outcome of drawing.
pub type Drawn = Result<(), Box<dyn std::error::Error + Send + Sync>>;

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

/// Stand-ins and the variables they become.
const VARIABLES: [(&str, &str); 6] = [
    ("#010101", "var(--ink)"),
    ("#010102", "var(--grid)"),
    ("#010103", "var(--before)"),
    ("#010104", "var(--after)"),
    ("#010105", "var(--floor)"),
    ("#010106", "var(--ground)"),
];

/// A plot for one width of screen.
pub struct Plot {
    /// The `svg` element; empty if it could not be drawn.
    pub svg: String,
    /// True for the narrow one.
    pub narrow: bool,
}

/// Draws a plot twice, for a desk and for a phone. `label` is read out in its place. `rows` tells how many plots lie below
/// each other on each.
pub fn plot(label: &str, rows: [u32; 2], draw: impl Fn(&Area, bool) -> Drawn) -> Vec<Plot> {
    [false, true]
        .into_iter()
        .map(|narrow| {
            let (width, height) = if narrow {
                (360, 250 * rows[1])
            } else {
                (900, 330 * rows[0])
            };
            Plot {
                svg: svg((width, height), label, |area| draw(area, narrow)).unwrap_or_default(),
                narrow,
            }
        })
        .collect()
}

fn svg(
    size: (u32, u32),
    label: &str,
    draw: impl Fn(&Area) -> Drawn,
) -> Result<String, Box<dyn std::error::Error + Send + Sync>> {
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, size).into_drawing_area();
        draw(&area)?;
        area.present()?;
    }
    for (colour, variable) in VARIABLES {
        text = text.replace(colour, variable);
    }
    let open = format!("<svg width=\"{}\" height=\"{}\" ", size.0, size.1);
    let label = maud::html! { (label) }.into_string();
    Ok(text.replacen(
        &open,
        &format!(
            "<svg role=\"img\" aria-label=\"{}\" ",
            label.replace('"', "&quot;")
        ),
        1,
    ))
}

/// Style of labels and titles.
pub fn text(narrow: bool) -> TextStyle<'static> {
    ("system-ui, sans-serif", if narrow { 11 } else { 13 })
        .into_font()
        .color(&INK)
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
        _ => 2,
    };
    let text = format!("{value:.digits$}");
    if text.contains('.') {
        text.trim_end_matches('0')
            .trim_end_matches('.')
            .replace('-', "−")
    } else {
        text.replace('-', "−")
    }
}
