//! How much of a motion a recording shows: tooth phases, angles.

use crate::data::observations::Observations;

/// Parts of the tooth phase. Derived from equation (3)'s highest order, 6: a period of it has 2.7 of them.
pub const SIXTEENTHS: usize = 16;
/// Sixteenths of the tooth phase that a segment must have seen. Derived from equation (3)'s design over a part of the turn, its
/// columns equally long: its condition number is 3.1 over twelve sixteenths, 8 over ten and 71 over eight.
pub const PHASES: usize = 12;
/// Standard deviation of the angle that is needed where nothing but g_p is known, mrad: at one angle the two segments of an axis
/// show the sum of their errors nowhere. A derivation: a milliradian over the span of 9.7 mm is 9.7 µm of difference between both
/// segments, 3.4° of order 1 and 21° of order 6; with less the lowest order is told apart no better than to 17 times the noise.
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
