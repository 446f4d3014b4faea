//! Whole teeth between the two segments of a pair: each tooth count begins where it was switched on.
//!
//! A tooth that one segment counts more than its partner is an angle of a pitch over the span, some degrees, in every sample. It is
//! no angle of the courier, and it is another one after each start and after each slip: left in, it would turn the courier under the
//! beacon and lay the lateral phases elsewhere.

use crate::algebra::statistics::median;
use crate::data::observations::Observations;

/// A courier without a command does not rest at more than this, rad: its motors lose their grip at a few degrees. A prior: "a
/// rotation capability of a few degrees" (paper, section 1); five are taken, and a tooth over a span of 9.7 mm is six.
const TURNED_RAD: f64 = 0.087;

/// Lays the counts of each pair on one zero: as the command's angle has it, else so that a courier that would be turned too far is not.
pub fn align_pairs(o: &mut Observations) {
    for first in 0..2 {
        let second = first + 2;
        if !o.has_segment(first) || !o.has_segment(second) {
            continue;
        }
        let teeth = teeth_apart(o, first, second);
        if teeth == 0.0 {
            continue;
        }
        let (segment, by) = if nearer_if_first_moves(o, first, second, teeth) {
            (first, -teeth)
        } else {
            (second, teeth)
        };
        for position in &mut o.position_m[segment] {
            *position += by * o.pitch_m;
        }
    }
}

/// Teeth that `first` counts more than `second`.
fn teeth_apart(o: &Observations, first: usize, second: usize) -> f64 {
    let difference = |i: usize| o.position_m[first][i] - o.position_m[second][i];
    let beyond = |i: usize| difference(i) - (o.commanded_m(first, i) - o.commanded_m(second, i));
    if let Some(middle) = middle(o.len(), beyond) {
        return (middle / o.pitch_m).round();
    }
    match middle(o.len(), difference) {
        Some(apart) if apart.abs() > TURNED_RAD * o.span_m => (apart / o.pitch_m).round(),
        _ => 0.0,
    }
}

/// True if the pair's mean comes nearer to the command when `first` gives up its teeth than when `second` takes them.
fn nearer_if_first_moves(o: &Observations, first: usize, second: usize, teeth: f64) -> bool {
    let mean = |i: usize| {
        let off = |s: usize| o.position_m[s][i] - o.commanded_m(s, i);
        0.5 * (off(first) + off(second))
    };
    let half_m = 0.5 * teeth * o.pitch_m;
    middle(o.len(), mean).is_some_and(|off| (off - half_m).abs() < (off + half_m).abs())
}

fn middle(samples: usize, value: impl Fn(usize) -> f64) -> Option<f64> {
    let finite = (0..samples).map(value).filter(|v| v.is_finite());
    median(&mut finite.collect::<Vec<f64>>())
}
