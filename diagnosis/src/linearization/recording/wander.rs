//! A pair's flaws that wander: smooth functions of time of which nothing else is known. How much they bend is told by pieces of
//! the recording that a fit has not seen (smoothing splines: Wahba 1978; as bonds between B-splines: Eilers and Marx 1996).

use crate::algebra::penalized::Penalty;
use effects::basis::spline;

/// Offset of sine and cosine, gain and angle. By definition the four by which an ellipse differs from a circle of its size.
pub(super) const FLAWS: usize = 4;
/// Expected size of each. A prior: offsets of 0.3 to 0.5 % of the amplitude and gains of 1.7 to 5.3 % are usual (ESS resolver);
/// they wander by a part of that.
pub(super) const FLAW_SIZE: f64 = 0.01;
/// Knots over the recording: so many that the bonds say what a flaw can follow, and not the mesh. Derived from the finest part
/// that is tried, a sixty-fourth: sixty intervals are as many, and three knots lie beyond the ends.
const WANDER_KNOTS: usize = 63;
/// Columns of a wander.
pub(super) const COLUMNS: usize = FLAWS * WANDER_KNOTS;
/// Parts of the recording that are tried, over which a flaw strays from a straight line by about its size. Derived from halving,
/// down to the finest that the knots hold.
pub(super) const STRAIGHT_PARTS: [f64; 6] = [0.5, 0.25, 0.125, 0.0625, 0.03125, 0.015_625];

/// Weight of one of `knots` at a part of the recording: uniform cubic B-splines that reach one knot past both ends.
pub(super) fn knot_weights(knots: usize, progress: f64) -> impl Iterator<Item = (usize, f64)> {
    let at = progress * (knots as f64 - 3.0);
    let first = at as usize;
    let weight = move |k: usize| (k, spline(at - (k as f64 - 1.0)));
    (first..knots.min(first + 4)).map(weight)
}

/// Columns of the flaws and their entries at a part of the recording, `shapes` being what a unit of each adds.
pub(super) fn entries(progress: f64, shapes: [f64; FLAWS]) -> impl Iterator<Item = (usize, f64)> {
    knot_weights(WANDER_KNOTS, progress).flat_map(move |(knot, weight)| {
        (0..FLAWS).map(move |f| (FLAWS * knot + f, FLAW_SIZE * weight * shapes[f]))
    })
}

/// The flaws at a part of the recording.
pub(super) fn flaws(progress: f64, coefficients: &[f64]) -> [f64; FLAWS] {
    let mut out = [0.0; FLAWS];
    for (knot, weight) in knot_weights(WANDER_KNOTS, progress) {
        for (f, flaw) in out.iter_mut().enumerate() {
            *flaw += FLAW_SIZE * weight * coefficients[FLAWS * knot + f];
        }
    }
    out
}

/// Means of the flaws over the time that the recording took, however many samples it has when.
pub(super) fn mean(coefficients: &[f64]) -> [f64; FLAWS] {
    let mut out = [0.0; FLAWS];
    for k in 0..WANDER_KNOTS {
        let flaws = flaws((k as f64 + 0.5) / WANDER_KNOTS as f64, coefficients);
        out.iter_mut()
            .zip(flaws)
            .for_each(|(o, f)| *o += f / WANDER_KNOTS as f64);
    }
    out
}

/// How far each flaw is held straight, as parts of the recording; `None` where it does not wander.
pub(super) type WanderLengths = [Option<f64>; FLAWS];

/// Keeps a flaw that does not wander at its mean. Derived from its square: it holds as 10^8 readings of the flaw's size do, of
/// which a recording has 10^5.
const HELD_AT_MEAN: f64 = 1e4;

/// What holds a flaw straight over a part of the recording: a slope that walks at random (white noise integrated twice), so that
/// second differences grow with the step to the power of one and a half.
pub(super) fn penalties(straights: WanderLengths) -> Vec<Penalty> {
    let step = 1.0 / (WANDER_KNOTS as f64 - 3.0);
    let of_one = |(flaw, straight): (usize, Option<f64>)| -> Vec<Penalty> {
        let column = |knot: usize| flaw + FLAWS * knot;
        let Some(straight) = straight else {
            return (0..WANDER_KNOTS)
                .map(|k| vec![(column(k), HELD_AT_MEAN)])
                .collect();
        };
        let one = (straight / step).powf(1.5);
        let bond = |k: usize| {
            let knots = [k, k + 1, k + 2].map(column);
            knots.into_iter().zip([one, -2.0 * one, one]).collect()
        };
        (0..WANDER_KNOTS - 2).map(bond).collect()
    };
    straights.into_iter().enumerate().flat_map(of_one).collect()
}
