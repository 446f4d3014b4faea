//! How much of a motion a recording shows: runs, tooth phases.

use crate::data::observations::Observations;

/// Runs that are needed: what is held out must differ from what was fitted.
pub const RUNS: usize = 2;
/// Parts of the tooth phase.
pub const SIXTEENTHS: usize = 16;
/// Sixteenths of the tooth phase that a segment must have seen.
pub const PHASES: usize = 12;
/// Standard deviation of the angle that is needed where nothing but g_p is known, mrad: at one angle the two segments of an axis
/// show the sum of their errors nowhere.
pub const TURNED_MRAD: f64 = 1.0;

/// Runs by their labels; under one label, legs of travel that turn back over some teeth: what a run is called tells nothing.
pub fn runs(o: &Observations) -> usize {
    let mut labels = o.run.clone();
    labels.sort_unstable();
    labels.dedup();
    if labels.len() > 1 {
        return labels.len();
    }
    (0..4)
        .filter(|s| o.has_segment(*s))
        .map(|s| legs(&o.position_m[s], LEG_PITCHES * o.pitch_m))
        .max()
        .unwrap_or(1)
        .max(1)
}

/// Steps of more than this share of a leg are jumps between poses, not travel.
const LEG_STEP: f64 = 0.3;
/// Teeth that a leg of travel passes.
pub const LEG_PITCHES: f64 = 3.0;

/// Legs of steady travel one way, each longer than `length`.
fn legs(position_m: &[f64], length: f64) -> usize {
    let known: Vec<f64> = position_m
        .iter()
        .copied()
        .filter(|p| p.is_finite())
        .collect();
    let (mut count, mut way, mut turn) = (0, 0.0, known.first().copied().unwrap_or(0.0));
    for pair in known.windows(2) {
        let (before, here) = (pair[0], pair[1]);
        if (here - before).abs() > LEG_STEP * length {
            (way, turn) = (0.0, here);
            continue;
        }
        let travelled = here - turn;
        if way * travelled > 0.0 {
            turn = here;
        } else if travelled.abs() > length {
            count += 1;
            way = travelled.signum();
            turn = here;
        }
    }
    count
}

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
