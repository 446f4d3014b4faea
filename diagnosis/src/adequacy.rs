//! Whether a recording can answer at all: every limit with what was found.

use crate::Insufficient;
use crate::observe::Observations;

/// Runs that are needed: what is held out must differ from what was fitted.
const RUNS: usize = 2;
/// Sixteenths of the tooth phase that a segment must have seen.
const PHASES: usize = 8;
/// A channel must vary by this share of the largest amplitude.
const ALIVE: f64 = 0.1;
/// More samples than this share at a channel's very top are clipped throughout.
const AT_TOP: f64 = 0.6;

/// Checks runs, motion and channels.
///
/// # Errors
/// The first limit that is violated.
pub fn check(o: &Observations) -> Result<(), Insufficient> {
    let mut runs = o.run.clone();
    runs.sort_unstable();
    runs.dedup();
    if runs.len() < RUNS {
        return Err(Insufficient::new(
            "runs of motion",
            runs.len() as f64,
            RUNS as f64,
            "",
        ));
    }
    for segment in (0..4).filter(|s| o.has_segment(*s)) {
        channels(o, segment)?;
        let seen = phases(o, segment);
        if seen < PHASES {
            let what = format!(
                "sixteenths of the tooth phase that segment {} passed",
                segment + 1
            );
            return Err(Insufficient::new(&what, seen as f64, PHASES as f64, ""));
        }
    }
    Ok(())
}

fn phases(o: &Observations, segment: usize) -> usize {
    let mut seen = [0usize; 16];
    for p in o.position_m[segment].iter().filter(|p| p.is_finite()) {
        let turns = p / o.pitch_m;
        seen[(((turns - turns.floor()) * 16.0) as usize).min(15)] += 1;
    }
    seen.iter().filter(|count| **count > 2).count()
}

fn channels(o: &Observations, segment: usize) -> Result<(), Insufficient> {
    let pairs: Vec<[f64; 2]> = o.pair_counts[segment]
        .iter()
        .copied()
        .filter(|p| p[0].is_finite())
        .collect();
    if pairs.is_empty() {
        return Ok(());
    }
    let largest = pairs.iter().map(|p| p[0].hypot(p[1])).fold(0.0, f64::max);
    for (channel, letter) in ["s", "c"].into_iter().enumerate() {
        let name = format!("q{}{letter}", segment + 1);
        let mean = pairs.iter().map(|p| p[channel]).sum::<f64>() / pairs.len() as f64;
        let spread = crate::statistics::rms(pairs.iter().map(|p| p[channel] - mean));
        let wanted = (ALIVE * largest).max(20.0 * o.pair_noise_counts);
        if spread < wanted {
            return Err(Insufficient::new(
                &format!("spread of {name}"),
                spread.round(),
                wanted.round(),
                "counts",
            ));
        }
        let top = pairs.iter().map(|p| p[channel].abs()).fold(0.0, f64::max);
        let margin = 1.0 + 3.0 * o.pair_noise_counts;
        let clipped = pairs
            .iter()
            .filter(|p| p[channel].abs() > top - margin)
            .count() as f64
            / pairs.len() as f64;
        if clipped > AT_TOP {
            let what = format!("share of samples of {name} that are below its top");
            return Err(Insufficient::new(&what, 1.0 - clipped, 1.0 - AT_TOP, ""));
        }
    }
    Ok(())
}
