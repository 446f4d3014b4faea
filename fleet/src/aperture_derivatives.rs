//! How the equations of poses change with the aperture, at the fields of a state: columns of its own beside those of the teeth. Of readings that
//! an unknown aperture averages, no estimate is better than what the sums with these columns leave.

use crate::form::{EDGE, HALF_PITCHES};
use crate::key::Key;
use crate::linearised::AtState;
use crate::member::Member;
use crate::refine::{COORDINATES, neighbours};
use crate::state::State;
use tooth_map::Linear;

/// Length of an even distribution over its deviation, by definition: the root of twelve.
const LENGTH_OVER_DEVIATION: f64 = 3.464_101_615_137_754_6;

/// Deviations of the coordinates before the data: of even distributions between their bounds.
pub fn deviations() -> [f64; COORDINATES] {
    let of_spread = (HALF_PITCHES[1] / HALF_PITCHES[0]).ln() / LENGTH_OVER_DEVIATION;
    let of_edge = (EDGE[1] - EDGE[0]) / LENGTH_OVER_DEVIATION;
    [of_spread, of_spread, of_edge]
}

/// Adds the aperture to the unknowns of a recording's problem, where a state has one, and the derivatives by it to the lines of its poses. Cost:
/// six times that of the lines.
pub fn add(member: &Member, state: &State, at: &mut AtState, lines: &mut [Linear]) {
    let Some(aperture) = &state.aperture else {
        return;
    };
    for (k, (both, apart)) in neighbours(aperture).into_iter().enumerate() {
        let column = at.keys.len();
        at.keys.push(Key::Aperture(k as u8));
        let under = both.map(|aperture| {
            let aperture = Some(aperture);
            AtState::new(
                member,
                &State {
                    aperture,
                    ..state.clone()
                },
            )
        });
        for (pose, line) in member.poses.iter().zip(lines.iter_mut()) {
            let [below, above] = under.each_ref().map(|at| at.linear(pose).g_m);
            let by = std::array::from_fn(|g| (above[g] - below[g]) / apart);
            line.by.push((column, by));
        }
    }
}
