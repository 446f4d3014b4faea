//! Sums of products of a recording's columns, by the names of the unknowns: sums of several recordings add.

use crate::aperture_derivatives;
use crate::key::Key;
use crate::linearised::AtState;
use crate::member::Member;
use crate::shown::Shown;
use crate::state::{Prior, State, further};
use anyhow::{Result, ensure};
use normal_equations::symmetric::Symmetric;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use tooth_map::{FIRST_NOISE, Linear, Noise, add_rows, places, products};

/// What a field of cubic B-splines a pitch apart cannot follow of independent teeth under a smooth aperture of five to seven, as
/// a share of the field. As was measured by a least-squares fit of drawn fields: 1.6 % along and across each. Under an aperture
/// with steep edges it is more.
const INEXACTNESS: f64 = 0.023;
/// The same of splines half a pitch apart. Derived from the nearest splines to windows (1 - u²)² of five to seven teeth, which lack 0.2 to 0.5 % along
/// and across each.
const INEXACTNESS_OF_HALVES: f64 = 0.006;
/// The same of teeth under the nearest of [`tooth_field::ApertureKernel`]'s forms, where the aperture is of another form, (1 - u²)² of
/// five to seven teeth. As was measured by a least-squares fit of drawn fields: 0.2 to 0.7 % along and across each, 0.5 % for six.
const INEXACTNESS_OF_APERTURE: f64 = 0.007;
/// Pitches over which that error is one. As was measured on the same drawn fields, the sum of its autocorrelation is 0.45 to 0.52
/// of them.
const PLACE_PITCHES: f64 = 0.5;

/// Normal equations of some recordings over one platen, at one state. Columns are counted in the deviations of their priors, which
/// are not in the sums.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sums {
    /// The unknowns, ascending, and what is known of each before the data.
    pub columns: Vec<(Key, Prior)>,
    /// Products of the whitened columns with each other.
    pub gram: Symmetric,
    /// And with what is left.
    pub right: Vec<f64>,
    /// Squares of what is left, those of single poses that stand out counting less.
    pub squares: f64,
    /// Poses in it.
    pub poses: usize,
}

/// Sums of one recording at a state, and what its poses leave there, by which they are to be weighed once the fit has settled with the noise that
/// is in force.
#[must_use]
pub fn sums_of(member: &Member, state: &State) -> (Sums, Shown) {
    let at = AtState::new(member, state);
    let lines: Vec<Linear> = member.poses.iter().map(|pose| at.linear(pose)).collect();
    let weighing = with_inexactness(member, state, &noise_in_force(member, state));
    let sums = weighed(member, state, &at, &lines, &weighing);
    (sums, Shown::of(member, &lines))
}

/// The same sums as if nothing but the noise that the recording states were wrong, and the aperture were to be found as well: no estimate can be
/// better than what they leave (the Cramér-Rao bound).
#[must_use]
pub fn sums_by_noise(member: &Member, state: &State) -> Sums {
    let mut at = AtState::new(member, state);
    let mut lines: Vec<Linear> = member.poses.iter().map(|pose| at.linear(pose)).collect();
    aperture_derivatives::add(member, state, &mut at, &mut lines);
    weighed(member, state, &at, &lines, &member.setup.stated_noise())
}

/// Sums of a recording's poses, in ascending order of the unknowns' keys.
fn weighed(
    member: &Member,
    state: &State,
    at: &AtState,
    lines: &[Linear],
    weighing: &Noise,
) -> Sums {
    let priors = priors(member, state, at);
    let mut order: Vec<usize> = (0..at.keys.len()).collect();
    order.sort_unstable_by_key(|i| &at.keys[*i]);
    let mut column = vec![0; order.len()];
    order.iter().enumerate().for_each(|(k, i)| column[*i] = k);
    let left = order.len();
    let whole = products(at.setup(), &member.poses, left + 1, |pose, rows| {
        let line = &lines[pose];
        let entries = line.by.iter();
        let entries = entries.map(|(i, by)| (column[*i], *by, priors[*i].deviation));
        add_rows(line, weighing, entries, left, rows);
    });
    let mut gram = Symmetric::zeros(left);
    for k in 0..left {
        gram.below_mut(k)
            .copy_from_slice(&whole.below(k)[..left - k]);
    }
    let columns = order.iter().map(|i| (at.keys[*i].clone(), priors[*i]));
    Sums {
        columns: columns.collect(),
        gram,
        right: (0..left).map(|k| whole[(left, k)]).collect(),
        squares: lines.iter().map(|line| line.squares(weighing)).sum(),
        poses: member.poses.len(),
    }
}

/// The noise by which a recording's poses are weighed: as it was told last, and until then large, since the teeth are in it.
pub fn noise_in_force(member: &Member, state: &State) -> Noise {
    match state.noise_m.get(&member.recording) {
        Some([segment_m, displacement_m]) => Noise {
            segment_m: *segment_m,
            displacement_m: *displacement_m,
        },
        None => FIRST_NOISE,
    }
}

/// The noise with what the field's form cannot follow. That error is the same for all poses over one place, so it does not average out: where
/// so many of them are within a place, they tell as little as one with that many times its variance.
fn with_inexactness(member: &Member, state: &State, noise: &Noise) -> Noise {
    let mut apart = BTreeSet::new();
    for pose in &member.poses {
        let seen = places(&member.setup, &pose.outputs_m);
        let along = |s: usize| seen[s].map(|place| (place / PLACE_PITCHES).floor() as i32);
        apart.extend((0..seen.len()).map(|s| (s, along(s))));
    }
    // Each pose has a place of each segment.
    let together = (4 * member.poses.len()) as f64 / apart.len().max(1) as f64;
    let share = match state.aperture {
        None if state.is_halved => INEXACTNESS_OF_HALVES,
        None => INEXACTNESS,
        Some(_) => INEXACTNESS_OF_APERTURE,
    };
    let inexact_m = share * state.unknowns(member).field_prior_m();
    Noise {
        segment_m: noise.segment_m.hypot(inexact_m * together.sqrt()),
        displacement_m: noise.displacement_m,
    }
}

/// Priors of a recording's unknowns: those of sensors stand in the state.
fn priors(member: &Member, state: &State, at: &AtState) -> Vec<Prior> {
    let further = further(member).map(|(_, deviation)| deviation);
    let mut deviations = at.unknowns.deviations(&member.setup);
    deviations.extend(further);
    // Of the aperture, where it is among the keys.
    deviations.extend(aperture_derivatives::deviations());
    let of = |(key, deviation): (&Key, f64)| match state.sensors.get(key) {
        Some((_, prior)) => *prior,
        None => Prior {
            mean: 0.0,
            deviation,
        },
    };
    at.keys.iter().zip(deviations).map(of).collect()
}

impl Sums {
    /// Checks sums that were read from a file: as many products as columns, and these ascending.
    ///
    /// # Errors
    /// They are not.
    pub fn check(&self) -> Result<()> {
        let [columns, order, right] = [self.columns.len(), self.gram.order(), self.right.len()];
        ensure!(
            columns == order && columns == right,
            "sums: found {columns} columns, products of {order} and {right} right sides, wanted as many of each"
        );
        ensure!(
            self.columns.is_sorted_by(|a, b| a.0 < b.0),
            "sums: found columns out of order, wanted them ascending"
        );
        Ok(())
    }

    /// Of both, over the same platen and at the same state: in any order, and in any grouping, but for the last digits.
    #[must_use]
    pub fn plus(self, other: &Self) -> Self {
        let mut columns = self.columns.clone();
        columns.extend(other.columns.iter().cloned());
        columns.sort_by(|a, b| a.0.cmp(&b.0));
        columns.dedup_by(|a, b| a.0 == b.0);
        let mut gram = Symmetric::zeros(columns.len());
        let mut right = vec![0.0; columns.len()];
        for part in [&self, other] {
            let place = |key: &Key| columns.binary_search_by(|(k, _)| k.cmp(key)).unwrap_or(0);
            // Both lists ascend, and so do the places.
            let places: Vec<usize> = part.columns.iter().map(|(key, _)| place(key)).collect();
            for (k, at) in places.iter().enumerate() {
                let slots = gram.below_mut(*at);
                let values = part.gram.below(k);
                for (row, value) in places[k..].iter().zip(values) {
                    slots[row - at] += value;
                }
                right[*at] += part.right[k];
            }
        }
        Self {
            columns,
            gram,
            right,
            squares: self.squares + other.squares,
            poses: self.poses + other.poses,
        }
    }
}
