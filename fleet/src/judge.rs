//! Poses that no fit has seen.

use crate::linearised::AtState;
use crate::member::Member;
use crate::state::State;

/// Rms of g_p, g_x and g_y at a recording's held-out poses, m.
#[must_use]
pub fn held_out_m(member: &Member, state: &State) -> [f64; 3] {
    let at = AtState::new(member, state);
    let mut squares = [0.0; 3];
    for pose in &member.held_out {
        let g_m = at.linear(pose).g_m;
        squares
            .iter_mut()
            .zip(g_m)
            .for_each(|(sum, g)| *sum += g * g);
    }
    squares.map(|sum| (sum / member.held_out.len().max(1) as f64).sqrt())
}
