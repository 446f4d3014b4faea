//! Causes that are in no catalogue and are known all the same: what they do, for a comparison with those that are. A set that holds one
//! explains a gap by what is not named.

use crate::design::nameless::SIZE_M;
use effects::sensor::{BasisInputs, Covariates, Regressor};
use std::f64::consts::TAU;

/// A leak of one segment's signals into another's.
const TWO_SEGMENTS: &str = "own tooth phase of two segments";
/// A reference whose mount creeps with the temperature.
const WARM_REFERENCE: &str = "temperature of the reference";

/// True if a block is of such a cause, by its name: the coordinate that it follows.
pub fn is_unlisted(name: &str) -> bool {
    [TWO_SEGMENTS, WARM_REFERENCE].contains(&name)
}

/// Those that such a recording can show, with their coordinates.
pub fn unlisted(inputs: &BasisInputs) -> Vec<(&'static str, Vec<Regressor>)> {
    let all = [
        (TWO_SEGMENTS, two_segments(inputs)),
        (WARM_REFERENCE, warm_reference(inputs)),
    ];
    let shown = all.into_iter().filter(|(_, columns)| !columns.is_empty());
    shown.collect()
}

/// The columns of one of them.
pub fn regressors(name: &str, inputs: &BasisInputs) -> Option<Vec<Regressor>> {
    unlisted(inputs)
        .into_iter()
        .find(|(own, _)| *own == name)
        .map(|(_, columns)| columns)
}

/// A share `k` of segment `j`'s signals in those of segment `s` turns the phase of `s` by `k sin(φ_j − φ_s)`, and by the cosine where the
/// channels are crossed as well: each pair of segments has these two. Over the platen that is no pattern of the teeth across: the phase of
/// `j` turns with the courier by its own lever arm.
fn two_segments(inputs: &BasisInputs) -> Vec<Regressor> {
    let wavenumber = TAU / inputs.pitch_m;
    let mut regressors = Vec::new();
    let in_use = |s: &usize| inputs.segments[*s];
    for into in (0..4).filter(in_use) {
        for from in (0..4).filter(in_use).filter(|from| *from != into) {
            let phase =
                move |m: &Covariates| wavenumber * (m.place_m[from][0] - m.place_m[into][0]);
            let name = |part| {
                let (from, into) = (from + 1, into + 1);
                format!("{part} of segment {from}'s phase less its own, segment {into}")
            };
            let sine = move |m: &Covariates| phase(m).sin();
            let cosine = move |m: &Covariates| phase(m).cos();
            regressors.push(Regressor::reading(name("sine"), "m", SIZE_M, into, sine));
            regressors.push(Regressor::reading(
                name("cosine"),
                "m",
                SIZE_M,
                into,
                cosine,
            ));
        }
    }
    regressors
}

/// Against a reference the segments then seem to move as one rigid body, by as much a kelvin: along x, along y, and turning (segments 1 and 3
/// tell `x ± l θ / 2`, 2 and 4 tell `y ± l θ / 2`). Only four segments tell that from drifts of their own.
fn warm_reference(inputs: &BasisInputs) -> Vec<Regressor> {
    if !inputs.reference || !inputs.temperature || inputs.segments != [true; 4] {
        return Vec::new();
    }
    const PARTS: [(&str, [f64; 4]); 3] = [
        ("along x", [1.0, 0.0, 1.0, 0.0]),
        ("along y", [0.0, 1.0, 0.0, 1.0]),
        ("turning", [1.0, 1.0, -1.0, -1.0]),
    ];
    let part = |(name, signs): (&str, [f64; 4])| {
        Regressor::readings(String::from(name), "m/K", SIZE_M, move |m, out| {
            for (out, sign) in out.iter_mut().zip(signs) {
                *out += sign * m.warmth_k;
            }
        })
    };
    PARTS.into_iter().map(part).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns(segments: [bool; 4], reference: bool) -> Vec<usize> {
        let inputs = BasisInputs {
            segments,
            reference,
            temperature: true,
            pitch_m: 1.0e-3,
            ..BasisInputs::default()
        };
        let all = unlisted(&inputs);
        assert!(all.iter().all(|(name, _)| is_unlisted(name)));
        all.iter().map(|(_, columns)| columns.len()).collect()
    }

    #[test]
    fn each_is_offered_where_it_can_be_told() {
        assert_eq!(columns([true; 4], false), [24]);
        assert_eq!(columns([true; 4], true), [24, 3]);
        assert_eq!(columns([true, true, true, false], true), [12]);
        assert_eq!(columns([true, false, false, false], true), []);
    }
}
