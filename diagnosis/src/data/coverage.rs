//! How much of a motion a recording shows: tooth phases, angles.

use crate::data::observations::Observations;

/// Parts of the tooth phase.
pub const SIXTEENTHS: usize = 16;
/// Sixteenths of the tooth phase that a segment must have seen.
pub const PHASES: usize = 12;
/// Standard deviation of the angle that is needed where nothing but g_p is known, mrad: at one angle the two segments of an axis
/// show the sum of their errors nowhere.
pub const TURNED_MRAD: f64 = 1.0;

/// Sixteenths of the tooth phase that a segment has seen.
pub fn phases(o: &Observations, segment: usize) -> usize {
    let mut seen = [0usize; SIXTEENTHS];
    for p in o.position_m[segment].iter().filter(|p| p.is_finite()) {
        let turns = p / o.pitch_m;
        let part = (turns - turns.floor()) * SIXTEENTHS as f64;
        seen[(part as usize).min(SIXTEENTHS - 1)] += 1;
    }
    seen.iter().filter(|count| **count > 2).count()
}
