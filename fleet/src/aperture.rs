//! The aperture of the segments: the window of teeth that a reading averages over. It is estimated from fields that were fitted as cubic
//! B-splines.
//!
//! Displacements of teeth are independent of each other, and under an aperture a tooth is a sum of splines, a column of A: those that come
//! nearest to its share in the mean square. P is the precision of the splines' coefficients that the data leave, r the right side of their normal
//! equations, and S the diagonal matrix of the teeth's deviations. With M = 1 + S Aᵀ P A S, the logarithm of an aperture's evidence is
//! ½ rᵀ A S M⁻¹ S Aᵀ r − ½ ln det M (Rasmussen and Williams 2006, section 5.4): the teeth are integrated out, and no pose is looked at again. The
//! couriers of a fit are taken to be of one make, so one aperture is estimated from all of them over all platens.

use crate::cache::Cache;
use crate::field_information::FieldInformation;
use crate::form::{Aperture, EDGE, HALF_PITCHES, spread};
use crate::key::{Key, Platen};
use crate::splines::Splines;
use crate::state::State;
use crate::sums::Sums;
use crate::teeth::{Blocks, OfTeeth, Teeth};
use crate::window::told_most;
use std::collections::BTreeMap;
use std::f64::consts::LN_2;
use tooth_field::{ApertureKernel, Lattice};
use tooth_map::{FIELD, NODE_M};

/// Half widths of the apertures that are compared before the search, pitches, along and across. The evidence may have a maximum at a box and
/// another one at a bell of another width. Derived from the bounds: each a third larger than the one before, as far as [`HALF_PITCHES`] goes.
const HALVES: [f64; 8] = [0.75, 1.0, 1.33, 1.78, 2.37, 3.16, 4.22, 5.62];
/// Edges of the same. Derived from the bounds: three equal steps over [`EDGE`].
const EDGES: [f64; 4] = [0.1, 0.4, 0.7, 1.0];
/// Deviation of the logarithm of a field's size over the tooth map's: a factor of two. A prior, without data.
const SIZE_DEVIATION: f64 = LN_2;
/// First step of the search, of each coordinate. Derived from [`HALVES`] and [`EDGES`]: about half of what two neighbours are apart.
const FIRST_STEP: f64 = 0.16;
/// The last step while the noise is that of splines a pitch apart, and the first by less noise. Derived from [`FIRST_STEP`] and [`LAST_STEP`]: between
/// both, two halvings either way.
const MIDDLE_STEP: f64 = 0.04;
/// The search ends where a step this short has gained nothing. Derived from the neighbours between which a straight line holds
/// (`crate::neighbours`): as far away.
const LAST_STEP: f64 = 0.01;
/// Step of the logarithm of a spread to the apertures that one may be taken for: fields under both are alike at the teeth. Derived from [`HALVES`]: a
/// third more or less.
const ALIAS: f64 = 0.288;
/// Coordinates of the search: logarithms of the aperture's spread along and across (the root of its second moment, pitches, which the data
/// determine whatever the edges are), the edge, and logarithms of the sizes of two fields, that of single teeth and that of whole lines,
/// over the tooth map's priors.
type Guess = [f64; 5];

/// The likeliest aperture, and the maximum that is climbed to from the likeliest of those that it may be taken for; none where independent spline
/// coefficients are at least as likely, or where the sums of a platen make no positive matrix. A courier's unknowns are eliminated for each
/// platen by itself: what its other platens tell of it is not used here. Of fields that are too long to be halved, a part is asked ([`told_most`]).
pub fn likeliest(sums: &BTreeMap<Platen, Sums>, state: &State) -> Vec<Aperture> {
    let Some(told) = told_for_search(sums, state) else {
        return Vec::new();
    };
    let mut evidence = Evidence::of(&told);
    let mut value = |guess: &Guess| evidence.log(guess);
    let independent = told.iter().map(Splines::log_evidence).sum();
    let (best, other) = followed(&mut value);
    if best.1 <= independent {
        return Vec::new();
    }
    vec![told_aperture(&best.0), told_aperture(&other.0)]
}

/// The likeliest guess, and the likeliest that is climbed to from those that it may be taken for.
fn followed(value: &mut dyn FnMut(&Guess) -> f64) -> ((Guess, f64), (Guess, f64)) {
    let best = climbed(compared(value), FIRST_STEP, MIDDLE_STEP, value);
    let ways = [(0, -ALIAS), (0, ALIAS), (1, -ALIAS), (1, ALIAS)];
    let others = ways.map(|(k, by)| {
        let mut guess = best.0;
        guess[k] += by;
        (guess, value(&guess))
    });
    let likelier = |a: (Guess, f64), b: (Guess, f64)| if b.1 > a.1 { b } else { a };
    let other = others.into_iter().reduce(likelier).unwrap_or(best);
    (best, climbed(other, MIDDLE_STEP, MIDDLE_STEP, value))
}

/// An aperture, and the displacements of teeth under it, m.
pub type WithTeeth = (Aperture, Vec<((Platen, Key), f64)>);

/// The likeliest aperture that is climbed to from some, and the likeliest teeth under it.
pub fn likeliest_of(
    apertures: &[Aperture],
    sums: &BTreeMap<Platen, Sums>,
    state: &State,
) -> Option<WithTeeth> {
    let searched = told_for_search(sums, state)?;
    let mut evidence = Evidence::of(&searched);
    let mut value = |guess: &Guess| evidence.log(guess);
    let each = apertures.iter().map(|aperture| {
        let guess = guess_of(aperture);
        let begin = (guess, value(&guess));
        climbed(begin, MIDDLE_STEP, MIDDLE_STEP, &mut value)
    });
    let best = each.max_by(|a, b| a.1.total_cmp(&b.1))?;
    let best = climbed(best, 0.5 * MIDDLE_STEP, LAST_STEP, &mut value);
    let aperture = told_aperture(&best.0);
    let told = told(sums, state, Some)?;
    let mut teeth = Vec::new();
    for (platen, told) in sums.keys().zip(&told) {
        let of_it = Teeth::under(told, &aperture.kernel).likeliest(told, &aperture)?;
        let of_it = of_it.into_iter();
        teeth.extend(of_it.map(|(key, m)| ((platen.clone(), key), m)));
    }
    Some((aperture, teeth))
}

/// What the sums tell of the splines by which apertures are compared.
fn told_for_search(sums: &BTreeMap<Platen, Sums>, state: &State) -> Option<Vec<Splines>> {
    let part = if state.is_halved { Some } else { told_most };
    told(sums, state, part)
}

/// What the sums tell of a part of each platen's splines.
fn told(
    sums: &BTreeMap<Platen, Sums>,
    state: &State,
    part: fn(FieldInformation) -> Option<FieldInformation>,
) -> Option<Vec<Splines>> {
    let each = sums.iter().map(|(platen, sums)| {
        let information = part(FieldInformation::of(platen, sums, state)?)?;
        Some(Splines::of(&information, state.is_halved))
    });
    each.collect()
}

/// The aperture at a guess, and deviations at a place of the fields of single teeth and of whole lines, m.
fn aperture_of(guess: &Guess) -> (ApertureKernel, [f64; 2]) {
    let edge = guess[2];
    let half = |log: f64| (log.exp() / spread(edge)).clamp(HALF_PITCHES[0], HALF_PITCHES[1]);
    let kernel = ApertureKernel {
        half_pitches: [half(guess[0]), half(guess[1])],
        edge,
    };
    let sizes_m = [
        guess[3].exp() * NODE_M * FIELD.deviation_by_nodes(),
        guess[4].exp() * NODE_M * FIELD.deviation_by_lines(),
    ];
    (kernel, sizes_m)
}

/// The aperture at a guess, with the deviations of a tooth and of a line that make fields of those sizes.
fn told_aperture(guess: &Guess) -> Aperture {
    let (kernel, [nodes_m, lines_m]) = aperture_of(guess);
    let lattice = Lattice::of_teeth(kernel);
    Aperture {
        kernel,
        deviations_m: [
            nodes_m / lattice.deviation_by_nodes(),
            lines_m / lattice.deviation_by_lines(),
        ],
    }
}

/// The guess that makes an aperture.
fn guess_of(aperture: &Aperture) -> Guess {
    let kernel = aperture.kernel;
    let lattice = Lattice::of_teeth(kernel);
    let log = |k: usize| (kernel.half_pitches[k] * spread(kernel.edge)).ln();
    let [node_m, line_m] = aperture.deviations_m;
    let of_nodes = lattice.deviation_by_nodes() / FIELD.deviation_by_nodes();
    let of_lines = lattice.deviation_by_lines() / FIELD.deviation_by_lines();
    [
        log(0),
        log(1),
        kernel.edge,
        (node_m / NODE_M * of_nodes).ln(),
        (line_m / NODE_M * of_lines).ln(),
    ]
}

/// The best of the compared apertures: of those as long as they are wide, and then of those about that one with its edge.
fn compared(value: &mut dyn FnMut(&Guess) -> f64) -> (Guess, f64) {
    let mut best = ([0.0; 5], f64::NEG_INFINITY);
    let mut at = [0; 3];
    let mut compare = |along: usize, across: usize, edge: usize| {
        let log = |k: usize| (HALVES[k] * spread(EDGES[edge])).ln();
        let guess = [log(along), log(across), EDGES[edge], 0.0, 0.0];
        let found = value(&guess);
        if found > best.1 {
            best = (guess, found);
            at = [along, across, edge];
        }
        at
    };
    let mut middle = [0; 3];
    for half in 0..HALVES.len() {
        for edge in 0..EDGES.len() {
            middle = compare(half, half, edge);
        }
    }
    let near = |k: usize| k.saturating_sub(1)..(k + 2).min(HALVES.len());
    for along in near(middle[0]) {
        for across in near(middle[1]).filter(|across| *across != along) {
            compare(along, across, middle[2]);
        }
    }
    best
}

/// A pattern search for the largest value (Hooke and Jeeves 1961), from a guess and its value.
fn climbed(
    mut best: (Guess, f64),
    first_step: f64,
    last_step: f64,
    value: &mut dyn FnMut(&Guess) -> f64,
) -> (Guess, f64) {
    let mut step = first_step;
    while step >= last_step {
        let before = best.1;
        for k in 0..best.0.len() {
            for way in [step, -step] {
                let mut next = best.0;
                next[k] += way;
                let found = value(&next);
                if found > best.1 {
                    best = (next, found);
                    break;
                }
            }
        }
        if best.1 <= before {
            step *= 0.5;
        }
    }
    best
}

/// The evidence of guesses by what the data tell of the splines.
struct Evidence<'a> {
    splines: Vec<(&'a Splines, Blocks)>,
    /// What they tell of each platen's teeth under a kernel: sizes alone change nothing of it.
    told: Cache<ApertureKernel, Vec<OfTeeth>>,
}

impl<'a> Evidence<'a> {
    fn of(splines: &'a [Splines]) -> Self {
        let each = splines.iter();
        Self {
            splines: each.map(|of| (of, Blocks::of(of))).collect(),
            told: Cache::new(),
        }
    }

    /// Logarithm of a guess's evidence and of its prior, but for what all have in common. There is no edge beyond its bounds.
    fn log(&mut self, guess: &Guess) -> f64 {
        if !(EDGE[0]..=EDGE[1]).contains(&guess[2]) {
            return f64::NEG_INFINITY;
        }
        let aperture = told_aperture(guess);
        let kernel = aperture.kernel;
        let splines = &mut self.splines;
        let told = self.told.get(kernel, || {
            let each = splines.iter_mut();
            each.map(|(of, blocks)| Teeth::under(of, &kernel).told(of, blocks, &kernel))
                .collect()
        });
        let of_data: f64 = told.iter().map(|told| told.log_evidence(&aperture)).sum();
        let sizes: f64 = guess[3..]
            .iter()
            .map(|s| (s / SIZE_DEVIATION).powi(2))
            .sum();
        of_data - 0.5 * sizes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DMatrix;

    /// Seven nodes each way of x's field, which teeth under an aperture make: as many platens as unknowns, each with a column of the
    /// covariance's root, so that their mean product is that covariance exactly and the likeliest aperture is that one.
    fn told_under(guess: &Guess) -> Vec<Splines> {
        const PRECISION: f64 = 30.0;
        let mut told = Splines::over([([0; 2], [7; 2]), ([0; 2], [0; 2])], 1);
        let count = told.right.len();
        told.precision = DMatrix::identity(count, count) * PRECISION;
        let root = {
            let aperture = told_aperture(guess);
            Teeth::under(&told, &aperture.kernel).covariance(&told, &aperture)
        };
        let all = root + DMatrix::identity(count, count) / PRECISION;
        let root = all.cholesky().unwrap().unpack() * (count as f64).sqrt();
        let platens = (0..count).map(|k| {
            let mut told = told.clone();
            told.right = root.column(k) * PRECISION;
            told
        });
        platens.collect()
    }

    /// An aperture that is longer across than along and lies between the compared ones is found to twice the last step that the search tries, where coefficients are known to a sixth of their prior deviation.
    #[test]
    fn the_likeliest_aperture_is_that_of_the_field() {
        let half = |half: f64| (half * spread(0.55)).ln();
        let truth: Guess = [half(2.7), half(3.5), 0.55, 0.0, 0.0];
        let told = told_under(&truth);
        let mut evidence = Evidence::of(&told);
        let mut value = |guess: &Guess| evidence.log(guess);
        let begin = compared(&mut value);
        let (found, _) = climbed(begin, FIRST_STEP, LAST_STEP, &mut value);
        for (found, truth) in found.iter().zip(truth) {
            assert!((found - truth).abs() < 2.0 * LAST_STEP, "{found}, {truth}");
        }
    }

    /// Where there are two maxima a third apart along the segments, both are followed, the higher one first.
    #[test]
    fn two_maxima_are_followed() {
        let peak = |guess: &Guess, along: f64, height: f64| {
            let away = [guess[0] - along, guess[1] - 0.1, guess[2] - 0.9];
            let rest = guess[3].hypot(guess[4]);
            height - 300.0 * away.iter().map(|a| a * a).sum::<f64>() - rest * rest
        };
        for heights in [[10.0, 9.0], [9.0, 10.0]] {
            let mut value =
                |guess: &Guess| peak(guess, 0.12, heights[0]).max(peak(guess, 0.4, heights[1]));
            let (best, other) = followed(&mut value);
            let wanted = if heights[0] > heights[1] {
                [0.12, 0.4]
            } else {
                [0.4, 0.12]
            };
            for ((guess, _), along) in [best, other].into_iter().zip(wanted) {
                assert!((guess[0] - along).abs() < MIDDLE_STEP, "{guess:?}, {along}");
            }
        }
    }
}
