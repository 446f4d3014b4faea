//! Where a field over the platen is known: the places that the recording went over. Elsewhere the model says nothing of it, and
//! `check` neither confirms nor refutes a claim.

use crate::linearization::recording::LinearizedRecording;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// Cells to a tooth pitch. A reading averages over several teeth, so that the field hardly changes from a cell to the next.
/// Derived from an aperture of four teeth and more (`APERTURE_PITCHES`): a quarter of a pitch is a sixteenth of it.
const CELLS: f64 = 4.0;
/// Cells to either side among which a place may lie between others, and the quadrants of four that must have been passed for that.
const BETWEEN: i32 = 2;
/// Quadrants of four about a place that must have been passed for it to lie between others. Derived from a triangle about it,
/// whose corners lie in three of them, or in two opposite ones.
const QUADRANTS: usize = 3;
/// Channels, or segments against a reference, that have a field of their own. A definition: the four segments.
const MOST_FIELDS: usize = 4;

/// Cells over the platen that each field was seen in.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TrainingSupport {
    /// Width of a cell, m.
    pub cell_m: f64,
    /// Cells along x and y (along and across a segment against a reference) for g_p, g_x, g_y or for segments 1 to 4.
    pub cells: [BTreeSet<[i32; 2]>; MOST_FIELDS],
}

impl TrainingSupport {
    /// What the samples in use went over.
    pub fn of(linearized: &LinearizedRecording) -> Self {
        let cell_m = linearized.observations.pitch_m / CELLS;
        let mut cells: [BTreeSet<[i32; 2]>; MOST_FIELDS] = Default::default();
        for i in (0..linearized.len()).filter(|&i| linearized.mask[i]) {
            for (field, place_m) in places_m(linearized, i) {
                cells[field].insert(cell(place_m, cell_m));
            }
        }
        Self { cell_m, cells }
    }

    /// True if all fields that a sample shows are known there.
    pub fn knows(&self, linearized: &LinearizedRecording, i: usize) -> bool {
        places_m(linearized, i).all(|(field, place_m)| self.knows_at(field, place_m))
    }

    /// True if the place was passed, or lies between places that were: beside a single lane nothing is known.
    fn knows_at(&self, field: usize, place_m: [f64; 2]) -> bool {
        let [x, y] = cell(place_m, self.cell_m);
        let seen = |dx: i32, dy: i32| self.cells[field].contains(&[x + dx, y + dy]);
        let quadrant = |(sx, sy): &(i32, i32)| {
            let mut near = (1..=BETWEEN).flat_map(|dx| (1..=BETWEEN).map(move |dy| (dx, dy)));
            near.any(|(dx, dy)| seen(sx * dx, sy * dy))
        };
        let quadrants = [(1, 1), (1, -1), (-1, 1), (-1, -1)];
        seen(0, 0) || quadrants.iter().filter(|q| quadrant(q)).count() >= QUADRANTS
    }
}

/// Each field that a sample shows, and the place that it shows it at.
pub fn places_m<'a>(
    linearized: &'a LinearizedRecording,
    i: usize,
) -> impl Iterator<Item = (usize, [f64; 2])> + 'a {
    let covariates = linearized.covariates(i);
    let channels = linearized.channels(i);
    let by_segment = linearized.scope.reference || linearized.inputs.field_by_segment;
    let (forms, pitch_m) = (&linearized.inputs.forms, linearized.observations.pitch_m);
    (0..MOST_FIELDS).filter_map(move |s| match (by_segment, channels.get(s)) {
        (true, _) if linearized.scope.segments[s] => {
            Some((s, forms.field_place_m(covariates.place_m[s], pitch_m)))
        }
        (false, Some(true)) => Some((s, covariates.centre_m)),
        _ => None,
    })
}

fn cell(place_m: [f64; 2], cell_m: f64) -> [i32; 2] {
    place_m.map(|p| (p / cell_m).floor() as i32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lane_tells_of_itself_and_two_of_what_is_between() {
        let lane = |y: i32| (-20..20).map(move |x| [x, y]);
        let at = |lanes: &[i32], y_m: f64| {
            let mut visited = TrainingSupport {
                cell_m: 1.0,
                ..TrainingSupport::default()
            };
            visited.cells[0] = lanes.iter().flat_map(|y| lane(*y)).collect();
            visited.knows_at(0, [0.5, y_m])
        };
        assert!(at(&[0], 0.1) && at(&[0], 0.9));
        assert!(!at(&[0], 1.1) && !at(&[0], -0.1));
        assert!(at(&[0, 3], 1.5) && at(&[0, 3], 2.5));
        assert!(!at(&[0, 3], 4.5) && !at(&[0, 6], 3.5));
    }
}
