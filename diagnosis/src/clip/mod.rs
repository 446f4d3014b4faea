//! Clips: in the counts where there are any, else in the shape of the error against a reference.

mod counts;
mod figure;
mod reference;

use crate::scene::Scene;
use effects::sensor::Clip;

/// A rail from here on, of where the wave would end, cuts nothing that could be told.
const WHOLE: f64 = 0.99;

/// The clip of a segment, if it has one.
#[must_use]
pub fn find(scene: &Scene, segment: usize) -> Option<Clip> {
    let o = scene.observations;
    if !o.pair_counts[segment].is_empty() {
        return counts::find(o, segment);
    }
    if scene.scope.reference && scene.scope.segments[segment] {
        reference::find(scene, segment)
    } else {
        None
    }
}

/// Rails with those opened that cut nothing off a pair; `None` if all are.
fn cutting(rails: [[Option<f64>; 2]; 2], pair: &[f64; 4]) -> Option<[[f64; 2]; 2]> {
    let open = [-Clip::OPEN, Clip::OPEN];
    let [sine, cosine, gain, _] = *pair;
    let ends = [(sine, 1.0 + gain), (cosine, 1.0)].map(|(o, a)| [o - a, o + a]);
    let rail = |channel: usize, end: usize| {
        let cuts = |rail: &f64| rail.abs() < WHOLE * ends[channel][end].abs();
        rails[channel][end].filter(cuts).unwrap_or(open[end])
    };
    let rails = [0, 1].map(|channel| [0, 1].map(|end| rail(channel, end)));
    (rails != [open; 2]).then_some(rails)
}
