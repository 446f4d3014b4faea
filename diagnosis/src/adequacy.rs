//! Whether a recording can answer at all: every limit with what was found.

use crate::Insufficient;
use crate::observe::Observations;

/// Runs that are needed: what is held out must differ from what was fitted.
const RUNS: usize = 2;
/// Sixteenths of the tooth phase that a segment must have seen.
const PHASES: usize = 8;
/// A channel must vary by this share of the largest amplitude.
const ALIVE: f64 = 0.1;
/// A channel that is at its very top over more than this share of the tooth phase is clipped throughout. Cut at a third of the
/// amplitude it would be.
const AT_TOP: f64 = 0.8;
/// Parts of the tooth phase over which that share is counted: a courier that dwells on a top is not clipped.
const TOP_PARTS: usize = 32;

/// A step in time by more than this many sample intervals within a run of even sampling is a jump, not a pause.
const JUMP: f64 = 50.0;
/// Share of a run's intervals that must be alike for its sampling to count as even.
const EVEN: f64 = 0.95;

/// What a reader should know of the recording, though it can be diagnosed.
pub fn remarks(o: &Observations) -> Vec<String> {
    let mut list = Vec::new();
    for (run, name) in o.run_names.iter().enumerate() {
        let mut steps: Vec<(f64, usize)> = (1..o.len())
            .filter(|&i| o.run[i] == run && o.run[i - 1] == run)
            .map(|i| (o.t_s[i] - o.t_s[i - 1], i))
            .collect();
        let mut values: Vec<f64> = steps.iter().map(|s| s.0).collect();
        let Some(typical) = crate::statistics::median(&mut values) else {
            continue;
        };
        let alike = steps
            .iter()
            .filter(|s| (s.0 / typical - 1.0).abs() < 0.5)
            .count();
        if (alike as f64) < EVEN * steps.len() as f64 {
            continue;
        }
        steps.retain(|s| s.0 > JUMP * typical);
        if let Some((step, row)) = steps.first() {
            list.push(format!(
                "t_s: jumps by {step:.3} s before sample {row} of run {name} ({} such jumps), steps of {typical:.4} s wanted; each part is taken for itself",
                steps.len()
            ));
        }
    }
    list
}

/// Checks runs, motion and channels.
///
/// # Errors
/// The first limit that is violated.
pub fn check(o: &Observations) -> Result<(), Insufficient> {
    let parts = runs(o);
    if parts < RUNS {
        return Err(Insufficient::new(
            "runs of motion",
            parts as f64,
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

/// Runs by their labels; under one label, legs of travel that turn back over some teeth: what a run is called tells nothing.
fn runs(o: &Observations) -> usize {
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
const LEG_PITCHES: f64 = 3.0;

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

fn phases(o: &Observations, segment: usize) -> usize {
    let mut seen = [0usize; 16];
    for p in o.position_m[segment].iter().filter(|p| p.is_finite()) {
        let turns = p / o.pitch_m;
        seen[(((turns - turns.floor()) * 16.0) as usize).min(15)] += 1;
    }
    seen.iter().filter(|count| **count > 2).count()
}

/// Share of the tooth phase over which a channel is at its top.
fn at_top(o: &Observations, segment: usize, channel: usize) -> f64 {
    let pairs = &o.pair_counts[segment];
    let known = |i: &usize| pairs[*i][channel].is_finite() && o.position_m[segment][*i].is_finite();
    let list: Vec<usize> = (0..pairs.len()).filter(known).collect();
    let top = list
        .iter()
        .map(|i| pairs[*i][channel].abs())
        .fold(0.0, f64::max);
    let margin = 1.0 + 3.0 * o.pair_noise_counts;
    let mut parts = [(0usize, 0usize); TOP_PARTS];
    for &i in &list {
        let turns = o.position_m[segment][i] / o.pitch_m;
        let part = ((turns - turns.floor()) * TOP_PARTS as f64) as usize;
        let counted = &mut parts[part.min(TOP_PARTS - 1)];
        counted.0 += usize::from(pairs[i][channel].abs() > top - margin);
        counted.1 += 1;
    }
    let seen: Vec<f64> = parts
        .iter()
        .filter(|p| p.1 > 0)
        .map(|p| p.0 as f64 / p.1 as f64)
        .collect();
    seen.iter().sum::<f64>() / seen.len().max(1) as f64
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
        let clipped = at_top(o, segment, channel);
        if clipped > AT_TOP {
            let what = format!("share of samples of {name} that are below its top");
            return Err(Insufficient::new(&what, 1.0 - clipped, 1.0 - AT_TOP, ""));
        }
    }
    Ok(())
}
