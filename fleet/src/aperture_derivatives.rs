//! How the equations of poses change with the aperture, at the fields of a state. These derivatives are columns beside those of the teeth: where
//! the aperture is unknown, no estimate is better than what the sums with these columns leave.

use crate::form::{EDGE, HALF_PITCHES};
use crate::key::Key;
use crate::linearised::AtState;
use crate::member::Member;
use crate::neighbours::{COORDINATES, neighbours};
use crate::state::State;
use tooth_map::Linear;

/// Deviations of the coordinates before the data: those of even distributions between their bounds, a length over the root of twelve.
pub fn deviations() -> [f64; COORDINATES] {
    let over_length = 12.0_f64.sqrt().recip();
    let of_spread = over_length * (HALF_PITCHES[1] / HALF_PITCHES[0]).ln();
    let of_edge = over_length * (EDGE[1] - EDGE[0]);
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
