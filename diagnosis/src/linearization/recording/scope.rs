//! Which residuals a recording can give.

use crate::data::observations::Observations;
use crate::linearization::baseline::Scope;

/// What the residuals can be formed of.
pub fn scope(o: &Observations) -> Scope {
    let segments: [bool; 4] = std::array::from_fn(|s| o.has_segment(s));
    let all = segments.iter().all(|s| *s);
    let beacon = all && !o.tan_psi[0].is_empty();
    let referenced =
        |s: usize| segments[s] && (0..o.len()).any(|i| o.reference_m(s, i).is_finite());
    let turning_known =
        !o.reference[2].is_empty() || !(segments[0] && segments[2] || segments[1] && segments[3]);
    let reference = !beacon && turning_known && (0..4).any(referenced);
    let in_use = if reference {
        std::array::from_fn(referenced)
    } else {
        segments
    };
    let complete = reference && all && in_use.iter().all(|s| *s);
    Scope {
        segments: in_use,
        beacon,
        reference: reference && (complete || !all),
    }
}
