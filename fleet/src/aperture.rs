//! The aperture of the segments: the window of teeth that a reading averages over. It is estimated from fields that were fitted as cubic
//! B-splines.
//!
//! Displacements of teeth are independent of each other, so an aperture determines the covariance K of a field's spline coefficients. With
//! y the coefficients that the data ask for and C their covariance, the logarithm of an aperture's evidence is that of a normal density of
//! y with covariance K + C (Rasmussen and Williams 2006, section 5.4): the field is integrated out, and no pose is looked at again. The
//! couriers of a fit are taken to be of one make, so one aperture is estimated from all of them over all platens.

use crate::field_information::FieldInformation;
use crate::form::{Aperture, EDGE, HALF_PITCHES, spread};
use crate::key::{Key, Platen};
use crate::state::State;
use crate::sums::Sums;
use nalgebra::{DMatrix, DVector};
use normal_equations::cholesky::Factor;
use std::collections::BTreeMap;
use std::f64::consts::{LN_2, TAU};
use tooth_field::{ApertureKernel, Kernel, Lattice, cubic_b_spline};
use tooth_map::{FIELD, NODE_M};

/// Half widths of the apertures that are compared before the search, pitches, along and across. The evidence may have a maximum at a box and
/// another one at a bell of another width, and where fields are well known one at each width whose spectrum has its zeros in places alike;
/// the search climbs only one. Derived from the bounds: each a third larger than
/// the one before, as far as [`HALF_PITCHES`] goes.
const HALVES: [f64; 8] = [0.75, 1.0, 1.33, 1.78, 2.37, 3.16, 4.22, 5.62];
/// Edges of the same. Derived from the bounds: three equal steps over [`EDGE`].
const EDGES: [f64; 4] = [0.1, 0.4, 0.7, 1.0];
/// Deviation of the logarithm of a field's size over the tooth map's: a factor of two. A prior, without data.
const SIZE_DEVIATION: f64 = LN_2;
/// First step of the search, of each coordinate. Derived from [`HALVES`] and [`EDGES`]: about half of what two neighbours are apart, and three
/// halvings above [`LAST_STEP`].
const FIRST_STEP: f64 = 0.16;
/// The search ends where its step is this short, after one of twice this has gained nothing. As was measured with drawn fields, an aperture
/// that is wrong by a fiftieth leaves 0.4 % of the field, less than what no aperture of this form can follow ([`crate::sums`]).
const LAST_STEP: f64 = 0.02;
/// What an edge beyond its bounds costs of the logarithm, by how far it is beyond. Derived from what a search may gain there, which is nothing:
/// the aperture is that at the bound. Any number that keeps the search within a step of the bounds does.
const BEYOND_EDGE: f64 = 1.0e3;
/// Precision that each coefficient has at least, in that of its prior. A prior of thirty deviations of the tooth map's: so wide that a
/// coefficient of which the data say nothing says nothing of the aperture, and narrow enough for a matrix that can be inverted.
const LEAST_PRECISION: f64 = 1.0e-3;

/// Coordinates of the search: logarithms of the aperture's spread along and across (the root of its second moment, pitches, which the data
/// determine whatever the edges are), the edge, and logarithms of the sizes of two fields, that of single teeth and that of whole lines,
/// over the tooth map's priors.
type Guess = [f64; 5];

/// A platen's field as the data ask for it, without a prior: spline coefficients and their covariance, in the tooth map's prior deviations.
struct Told {
    keys: Vec<Key>,
    coefficients: DVector<f64>,
    covariance: DMatrix<f64>,
}

/// The likeliest aperture; none where independent spline coefficients are at least as likely, or where the sums of a platen make no positive
/// matrix. A courier's unknowns are eliminated for each platen by itself: what its other platens tell of it is not used here.
pub fn likeliest(sums: &BTreeMap<Platen, Sums>, state: &State) -> Option<Aperture> {
    let told: Vec<Told> = sums
        .iter()
        .map(|(platen, sums)| {
            let information = FieldInformation::of(platen, sums, state)?;
            let (coefficients, covariance) = information.likeliest(LEAST_PRECISION)?;
            let keys = information.keys().to_vec();
            Some(Told {
                keys,
                coefficients,
                covariance,
            })
        })
        .collect::<Option<_>>()?;
    let value = |guess: &Guess| log_evidence(&told, guess);
    let independent: f64 = told
        .iter()
        .map(|told| density(told, &|_, _| 0.0, 1.0))
        .sum();
    let (guess, found) = searched(&value);
    (found > independent).then(|| told_aperture(&guess))
}

/// The aperture at a guess, and deviations at a place of the fields of single teeth and of whole lines, m.
fn aperture_of(guess: &Guess) -> (ApertureKernel, [f64; 2]) {
    let edge = guess[2].clamp(EDGE[0], EDGE[1]);
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

/// A pattern search for the largest value (Hooke and Jeeves 1961), from the best of the compared apertures.
fn searched(value: &dyn Fn(&Guess) -> f64) -> (Guess, f64) {
    let mut best = ([0.0; 5], f64::NEG_INFINITY);
    for along in HALVES {
        for across in HALVES {
            for edge in EDGES {
                let log = |half: f64| (half * spread(edge)).ln();
                let guess = [log(along), log(across), edge, 0.0, 0.0];
                let found = value(&guess);
                if found > best.1 {
                    best = (guess, found);
                }
            }
        }
    }
    let mut step = FIRST_STEP;
    while step > LAST_STEP {
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

/// Covariance of two spline coefficients that are up to so many teeth apart, before the data, in the tooth map's prior deviations.
fn coefficients_under(guess: &Guess, longest: usize) -> impl Fn(&Key, &Key) -> f64 {
    let aperture = told_aperture(guess);
    let [along, across] = [0, 1].map(|d| covariances(&aperture.kernel, d, longest + 1));
    let squares = aperture.deviations_m.map(|m| (m / NODE_M).powi(2));
    move |a, b| match (a, b) {
        (Key::Node(d, [i, j]), Key::Node(e, [k, l])) if d == e => {
            squares[0] * along[i.abs_diff(*k) as usize] * across[j.abs_diff(*l) as usize]
        }
        (Key::Line(d, i), Key::Line(e, k)) if d == e => squares[1] * along[i.abs_diff(*k) as usize],
        _ => 0.0,
    }
}

/// Logarithm of a guess's evidence and of its prior, but for what all have in common.
fn log_evidence(told: &[Told], guess: &Guess) -> f64 {
    let longest = told.iter().map(longest).max().unwrap_or(0);
    let together = coefficients_under(guess, longest);
    let sizes: f64 = guess[3..]
        .iter()
        .map(|s| (s / SIZE_DEVIATION).powi(2))
        .sum();
    let of_edge = (guess[2] - guess[2].clamp(EDGE[0], EDGE[1])).abs();
    told.iter()
        .map(|told| density(told, &together, 0.0))
        .sum::<f64>()
        - 0.5 * sizes
        - BEYOND_EDGE * of_edge
}

/// Most teeth between two of the coefficients along an axis.
fn longest(told: &Told) -> usize {
    let [mut low, mut high] = [i32::MAX, i32::MIN];
    for key in &told.keys {
        let teeth = match key {
            Key::Node(_, node) => *node,
            Key::Line(_, line) => [*line; 2],
            _ => continue,
        };
        low = low.min(teeth[0]).min(teeth[1]);
        high = high.max(teeth[0]).max(teeth[1]);
    }
    high.abs_diff(low.min(high)) as usize
}

/// Logarithm of the density of a platen's coefficients, where they have a covariance besides that of the data, and `own` more each.
fn density(told: &Told, together: &dyn Fn(&Key, &Key) -> f64, own: f64) -> f64 {
    let mut covariance = told.covariance.clone();
    for (column, a) in told.keys.iter().enumerate() {
        for (row, b) in told.keys.iter().enumerate().skip(column) {
            covariance[(row, column)] += together(a, b);
        }
        covariance[(column, column)] += own;
    }
    Factor::new(covariance).map_or(f64::NEG_INFINITY, |factor| {
        let solved = factor.solve(&told.coefficients);
        -0.5 * told.coefficients.dot(&solved) - factor.half_log_determinant()
    })
}

/// Covariance of two spline coefficients 0, 1, 2 … pitches apart along a direction, of the field that teeth of unit variance make under an
/// aperture: the coefficients are those that come nearest to the field in the mean square.
///
/// With q the aperture's product with a spline by the distance of both and g that of two splines, the spectrum is (q / g)².
fn covariances(kernel: &ApertureKernel, direction: usize, count: usize) -> Vec<f64> {
    /// Places of a pitch at which products are summed. As was measured against the variance of the teeth's readings, 32 leave less than 1e-3
    /// of the covariance.
    const PLACES: i32 = 32;
    /// Frequencies of the spectrum. Derived from the longest lattice, 255 teeth: twice as many, so that the ends do not meet.
    const FREQUENCIES: i32 = 512;
    let reach = 2 + kernel.half_pitches(direction).ceil() as i32;
    let at = |k: i32| (f64::from(k) + 0.5) / f64::from(PLACES);
    let product = |lag: i32, other: &dyn Fn(f64) -> f64| -> f64 {
        let places = -2 * PLACES..2 * PLACES;
        let each = places.map(|k| cubic_b_spline(at(k)) * other(at(k) - f64::from(lag)));
        each.sum::<f64>() / f64::from(PLACES)
    };
    let with_teeth: Vec<f64> = (0..=reach)
        .map(|lag| product(lag, &|x| kernel.weight(direction, x)))
        .collect();
    let with_splines: Vec<f64> = (0..4).map(|lag| product(lag, &cubic_b_spline)).collect();
    let transform = |values: &[f64], turns: f64| -> f64 {
        let waves = values.iter().enumerate().skip(1);
        values[0]
            + 2.0
                * waves
                    .map(|(lag, v)| v * (TAU * turns * lag as f64).cos())
                    .sum::<f64>()
    };
    let spectrum: Vec<f64> = (0..FREQUENCIES)
        .map(|m| {
            let turns = f64::from(m) / f64::from(FREQUENCIES);
            (transform(&with_teeth, turns) / transform(&with_splines, turns)).powi(2)
        })
        .collect();
    (0..count)
        .map(|lag| {
            let waves = spectrum.iter().enumerate();
            let turns = |m: usize| (m * lag) as f64 / f64::from(FREQUENCIES);
            waves.map(|(m, s)| s * (TAU * turns(m)).cos()).sum::<f64>() / f64::from(FREQUENCIES)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Seven nodes each way of x's field, whose coefficients are under an aperture: as many platens as coefficients, each with a column of
    /// the covariance's root, so that their mean product is that covariance exactly and the likeliest aperture is that one.
    fn told_under(guess: &Guess) -> Vec<Told> {
        let nodes = (0..7).flat_map(|i| (0..7).map(move |j| [i, j]));
        let keys: Vec<Key> = nodes.map(|node| Key::Node(0, node)).collect();
        let together = coefficients_under(guess, 6);
        let count = keys.len();
        let covariance = DMatrix::identity(count, count) * 0.03;
        let all = &covariance + DMatrix::from_fn(count, count, |i, j| together(&keys[i], &keys[j]));
        let root = all.cholesky().unwrap().unpack() * (count as f64).sqrt();
        let platens = (0..count).map(|k| Told {
            keys: keys.clone(),
            coefficients: root.column(k).into_owned(),
            covariance: covariance.clone(),
        });
        platens.collect()
    }

    /// An aperture that is longer across than along and lies between the compared ones is found to the last step that the search tries, twice
    /// [`LAST_STEP`], where coefficients are known to a sixth of their prior deviation.
    #[test]
    fn the_likeliest_aperture_is_that_of_the_field() {
        let half = |half: f64| (half * spread(0.55)).ln();
        let truth: Guess = [half(2.7), half(3.5), 0.55, 0.0, 0.0];
        let told = told_under(&truth);
        let (found, _) = searched(&|guess| log_evidence(&told, guess));
        for (found, truth) in found.iter().zip(truth) {
            assert!((found - truth).abs() < 2.0 * LAST_STEP, "{found}, {truth}");
        }
    }

    /// A spline's own coefficients are independent, and the variance of a field by its coefficients is that of the teeth's readings.
    #[test]
    fn covariances_are_those_of_the_coefficients() {
        let kernel = ApertureKernel {
            half_pitches: [3.0; 2],
            edge: 0.9,
        };
        let found = covariances(&kernel, 0, 40);
        // Mean over the places between two coefficients: products of splines by their distance, as in the tables (2416, 1191, 120 and 1 of 5040).
        let splines = [2416.0, 1191.0, 120.0, 1.0].map(|v| v / 5040.0);
        let others = (1..4).map(|lag| 2.0 * splines[lag] * found[lag]);
        let by_coefficients = splines[0] * found[0] + others.sum::<f64>();
        let by_teeth = Lattice::of_teeth(kernel).deviation_by_lines().powi(2);
        // What splines cannot follow is 1.7 % of the field.
        assert!((by_coefficients / by_teeth - 1.0).abs() < 1.0e-3);
        assert!(found[39].abs() < 1.0e-3 * found[0]);
    }
}
