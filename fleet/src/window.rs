//! The part of a long field that tells the aperture. What an aperture's evidence costs grows with the cube of a field's teeth, and all of them
//! are under one aperture.

use crate::field_information::FieldInformation;
use crate::key::Key;
use std::collections::BTreeMap;

/// Longest side of the part, teeth. A bound on the work: over a strip ten teeth wide, the search among apertures takes a minute of processor time.
const LONGEST: usize = 64;

/// What is told about the nodes of a square, the one of which the data tell most. All others are integrated out. None where their precision is no
/// positive matrix.
pub fn told_most(mut information: FieldInformation) -> Option<FieldInformation> {
    for axis in 0..2 {
        let first = first_of_most(&information, axis);
        let is_kept = |key: &Key| place(key, axis).is_none_or(|at| is_within(first, at));
        information = information.of_those(is_kept)?;
    }
    Some(information)
}

/// Where a node or a line is along an axis; none of a line that runs along it.
fn place(key: &Key, axis: usize) -> Option<i32> {
    match key {
        Key::Node(direction, places) => Some(places[usize::from(usize::from(*direction) != axis)]),
        Key::Line(direction, along) => (usize::from(*direction) == axis).then_some(*along),
        _ => None,
    }
}

fn is_within(first: i32, at: i32) -> bool {
    at >= first && (at.abs_diff(first) as usize) < LONGEST
}

/// The first place along an axis of the window whose nodes have the largest sum of precisions.
fn first_of_most(information: &FieldInformation, axis: usize) -> i32 {
    let mut told: BTreeMap<i32, f64> = BTreeMap::new();
    for (k, key) in information.keys().iter().enumerate() {
        if let (Key::Node(..), Some(at)) = (key, place(key, axis)) {
            *told.entry(at).or_default() += information.precision()[(k, k)];
        }
    }
    let of_window = |first: i32| -> f64 {
        let from_first = told.range(first..);
        let within = from_first.take_while(|(at, _)| is_within(first, **at));
        within.map(|(_, precision)| precision).sum()
    };
    let firsts = told.keys().copied();
    let best = firsts.max_by(|a, b| of_window(*a).total_cmp(&of_window(*b)));
    best.unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};

    /// Of a strip of 100 teeth, of which the later ones are told better, the last 64 are left, and the evidence is that of the whole strip: the others
    /// are integrated out.
    #[test]
    fn the_rest_is_integrated_out() {
        let keys: Vec<Key> = (0..100).map(|along| Key::Node(0, [along, 3])).collect();
        let count = keys.len();
        let precision = DMatrix::from_fn(count, count, |i, j| match i.abs_diff(j) {
            0 => 5.0 + 0.05 * i as f64,
            1 => 1.5,
            _ => 0.0,
        });
        let right = DVector::from_fn(count, |i, _| (1.3 * i as f64).sin());
        let whole = FieldInformation::of_products(keys, precision, right);
        let part = told_most(whole.clone()).unwrap();
        let last: Vec<Key> = (36..100).map(|along| Key::Node(0, [along, 3])).collect();
        assert_eq!(part.keys(), last);
        let (wanted, found) = (whole.log_evidence(), part.log_evidence());
        assert!((wanted - found).abs() < 1e-9, "{wanted} {found}");
    }
}
