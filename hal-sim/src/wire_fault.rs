//! Wires that were exchanged between the segments and the converter.

use effects::plant::{Channels, Instant, PlantEffect};

/// Segments, two and two, of which each is wired to the other's inputs.
#[derive(Clone, Copy, Debug)]
pub struct ExchangedSegments(pub &'static [[usize; 2]]);

impl PlantEffect for ExchangedSegments {
    /// A wire has one size.
    fn scale(&mut self, _factor: f64) {}

    fn analog(&mut self, _at: &Instant, channels: &mut Channels) {
        for [a, b] in self.0 {
            channels.quadrature.swap(*a, *b);
        }
    }
}
