//! Rails of a pair: which of them cut anything off.

use effects::rails::saturated;
use effects::sensor::Clip;

/// Lower and upper rail of sine and cosine, counts, where there is one.
pub type Rails = [[Option<f64>; 2]; 2];

/// A rail from here on, of where the wave would end, cuts nothing that could be told. Derived from a sine: where a cut at 0.99
/// takes most off, beside its top, the phase is off by `0.01 x - x³ / 2` at x = 0.08, which is 0.0005 rad, 0.09 µm at the paper's
/// pitch.
pub(super) const WHOLE: f64 = 0.99;

/// Rails with those opened that cut nothing off a pair; `None` if all are.
pub(super) fn cutting(
    rails: [[Option<f64>; 2]; 2],
    pair: &[f64; 4],
    knee: f64,
) -> Option<[[f64; 2]; 2]> {
    let open = [-Clip::OPEN, Clip::OPEN];
    let [sine, cosine, gain, _] = *pair;
    let ends = [(sine, 1.0 + gain), (cosine, 1.0)].map(|(o, a)| [o - a, o + a]);
    let rail = |channel: usize, end: usize| {
        let top = ends[channel][end];
        let cuts =
            |rail: &f64| saturated(top, [-rail.abs(), rail.abs()], knee).abs() < WHOLE * top.abs();
        rails[channel][end].filter(cuts).unwrap_or(open[end])
    };
    let rails = [0, 1].map(|channel| [0, 1].map(|end| rail(channel, end)));
    (rails != [open; 2]).then_some(rails)
}
