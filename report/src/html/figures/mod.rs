//! The figures of the report, each with a caption and a table that say the same without a picture.

mod gap;
mod map;
mod spectra;
mod telling;
mod waterfall;

pub use gap::gap;
pub use map::map;
pub use spectra::{fractions, frequencies, orders};
pub use telling::telling;
pub use waterfall::waterfall;

use super::plots::MICRO;
use super::svg::{Plot, short};
use diagnosis::verdict::evidence::Trace;

/// What a grey band or bar is.
const FLOOR: (&str, &str) = ("floor", "floor: 95 % of the simulator's own scatter");

/// A figure with its equivalents in text.
pub struct Figure {
    /// Anchor.
    pub id: &'static str,
    /// Heading.
    pub title: String,
    /// What is to be seen, in words.
    pub caption: String,
    /// The plot for both widths.
    pub plots: Vec<Plot>,
    /// Colours (classes of the style sheet) and what they stand for.
    pub legend: Vec<(&'static str, &'static str)>,
    /// Header and rows of the table.
    pub table: (Vec<String>, Vec<Vec<String>>),
}

/// Colours of before, after and what else is drawn. Where nothing is changed by what is named there is no after.
fn legend(
    changed: bool,
    further: (&'static str, &'static str),
) -> Vec<(&'static str, &'static str)> {
    let before = if changed { "before" } else { "recording" };
    let mut list = vec![("before", before)];
    list.extend(changed.then_some(("after", "after")));
    list.push(further);
    list
}

/// True where what is named changes residuals: else a plot of them after would be that of them before.
fn changed(trace: &Trace) -> bool {
    trace.points.iter().any(|p| p.before_m != p.after_m)
}

/// Leaves out the fields about "after" where nothing is changed.
fn without_after(changed: bool, mut row: Vec<String>, after: usize) -> Vec<String> {
    if !changed {
        row.remove(after);
    }
    row
}

fn strings<const N: usize>(list: [&str; N]) -> Vec<String> {
    list.iter().map(|s| (*s).to_owned()).collect()
}

fn micro(value_m: f64) -> String {
    short(MICRO * value_m)
}
