//! The figures of the report, each with a caption and a table that say the same without a picture.

mod gap;
mod map;
mod spectra;
mod telling;
mod waterfall;

pub use gap::gap;
pub use map::map;
pub use spectra::{frequencies, orders};
pub use telling::telling;
pub use waterfall::waterfall;

use super::plots::MICRO;
use super::svg::{Plot, short};

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
    /// Header and rows of the table.
    pub table: (Vec<String>, Vec<Vec<String>>),
}

fn strings<const N: usize>(list: [&str; N]) -> Vec<String> {
    list.iter().map(|s| (*s).to_owned()).collect()
}

fn micro(value_m: f64) -> String {
    short(MICRO * value_m)
}
