//! Whether every channel is alive: dead, frozen or clipped ones are told with what was found and what was wanted.

use crate::Insufficient;
use crate::algebra::statistics::{deviation, spread};
use crate::data::observations::Observations;
use recording::{Column, Recording};
use std::f64::consts::TAU;

/// A channel must vary by this share of the largest amplitude. A prior: of a live channel that has seen three quarters of the
/// phase (`PHASES`) 0.55 or more are left, 0.48 at the largest gain mismatch that is known (13 %, lib_sincos_enc); a dead one
/// shows its noise, some thousandths.
const ALIVE: f64 = 0.1;
/// A channel that is at its very top over more than this share of the tooth phase is clipped throughout. Derived from a sine: cut
/// at 0.31 of its amplitude it stands at its top over `1 - 2/π asin 0.31` of the phase. The deepest cut that is known, at 0.655
/// (ESS resolver), stands there over 0.55.
const AT_TOP: f64 = 0.8;
/// Parts of the tooth phase over which that share is counted: a courier that dwells on a top is not clipped. Derived from the
/// share's own step: one part is 0.03 of the phase, far less than lies between `AT_TOP` and the deepest cut that is known.
const TOP_PARTS: usize = 32;
/// A channel must vary by this many times its noise to tell anything. Derived from what a reading then tells: with a spread of 20
/// noises the amplitude is 28 of them, and a place is told to 1/28 rad, 5.8 µm at the paper's pitch, as much as an uncalibrated
/// segment is off (12.1 µm of parity in a fly-by, paper 3.1.2).
const OVER_NOISE: f64 = 20.0;
/// Of a segment that travels less than this share of a pitch nothing is asked here: its phases are asked for elsewhere. Derived from a sine
/// about its top: over 0.28 of a period it varies by 0.109 of its amplitude, more than a dead one may (`ALIVE`), and over 0.25 by 0.088.
const TRAVEL: f64 = 0.28;

/// Checks sine and cosine of a segment that was moved.
///
/// # Errors
/// A channel that does not vary, or that is at its top for most of the samples.
pub fn pair(o: &Observations, segment: usize) -> Result<(), Insufficient> {
    let pairs: Vec<[f64; 2]> = o.pair_counts[segment]
        .iter()
        .copied()
        .filter(|p| p[0].is_finite())
        .collect();
    if pairs.is_empty() || spread(&o.position_m[segment]) < TRAVEL * o.pitch_m {
        return Ok(());
    }
    let largest = pairs.iter().map(|p| p[0].hypot(p[1])).fold(0.0, f64::max);
    for (channel, letter) in ["s", "c"].into_iter().enumerate() {
        let name = format!("q{}{letter}", segment + 1);
        let values: Vec<f64> = pairs.iter().map(|p| p[channel]).collect();
        varies(
            &name,
            &values,
            (ALIVE * largest).max(OVER_NOISE * o.pair_noise_counts),
        )?;
        below_top(&name, at_top(o, segment, channel))?;
    }
    not_both_at_top(o, segment)
}

/// Both channels of a pair at their tops at once, as only a clip makes them, in more than this share of the samples. What is left
/// tells four places of a tooth. Derived from a cut at `L` of the amplitude, which leaves both at their tops over `1 - 4/π asin
/// L`: half of all phases at 0.38.
const BOTH_AT_TOP: f64 = 0.5;

/// Checks that a pair is not cut so deep that it tells little but four places of a tooth.
fn not_both_at_top(o: &Observations, segment: usize) -> Result<(), Insufficient> {
    let pairs = &o.pair_counts[segment];
    let known = |pair: &&[f64; 2]| pair[0].is_finite() && pair[1].is_finite();
    let margin = 1.0 + 3.0 * o.pair_noise_counts;
    let limits = [0, 1].map(|channel: usize| {
        let values = pairs.iter().filter(known).map(|p| p[channel].abs());
        values.fold(0.0, f64::max) - margin
    });
    // Run by run: a courier that rests on such a place for long is no reason.
    let mut runs = vec![(0usize, 0usize); o.run_names.len().max(1)];
    for (pair, run) in pairs.iter().zip(&o.run).filter(|(p, _)| known(p)) {
        runs[*run].0 += usize::from(pair[0].abs() > limits[0] && pair[1].abs() > limits[1]);
        runs[*run].1 += 1;
    }
    let shares = runs.iter().filter(|r| r.1 > 0);
    let shares: Vec<f64> = shares.map(|r| r.0 as f64 / r.1 as f64).collect();
    let found = shares.iter().sum::<f64>() / shares.len().max(1) as f64;
    if found > BOTH_AT_TOP {
        let what = format!(
            "share of samples of q{0}s and q{0}c that are not both at their tops",
            segment + 1
        );
        return Err(Insufficient::new(&what, 1.0 - found, 1.0 - BOTH_AT_TOP, ""));
    }
    Ok(())
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

fn varies(name: &str, values: &[f64], wanted: f64) -> Result<(), Insufficient> {
    let found = deviation(values);
    if found < wanted {
        let what = format!("spread of {name}");
        return Err(Insufficient::new(
            &what,
            found.round(),
            wanted.round(),
            "counts",
        ));
    }
    Ok(())
}

fn below_top(name: &str, at_top: f64) -> Result<(), Insufficient> {
    if at_top > AT_TOP {
        let what = format!("share of samples of {name} that are below its top");
        return Err(Insufficient::new(&what, 1.0 - at_top, 1.0 - AT_TOP, ""));
    }
    Ok(())
}

/// Tooth changes that are needed to judge a tooth count, and the share of them that it must follow. A live count follows each
/// change but the few that are disturbed, a frozen one none. Derived from the binomial distribution: of eight changes of which
/// one in ten is missed, fewer than half are followed once in 2,300 recordings.
const FEWEST_CHANGES: usize = 8;
/// See [`FEWEST_CHANGES`].
const FOLLOWED_SHARE: f64 = 0.5;

/// Checks that the tooth count changes where the phase passes from one tooth to the next.
///
/// # Errors
/// A count that stands still.
pub fn tooth_count(o: &Observations, segment: usize) -> Result<(), Insufficient> {
    let pairs = &o.pair_counts[segment];
    let (mut changes, mut followed) = (0usize, 0usize);
    for i in 1..pairs.len() {
        let turns = |i: usize| pairs[i][0].atan2(pairs[i][1]) / TAU;
        let count = |i: usize| (o.position_m[segment][i] / o.pitch_m - turns(i)).round();
        let step = turns(i) - turns(i - 1);
        // Across the border of two teeth, and within a quarter of one.
        if o.stretch[i] == o.stretch[i - 1] && step.abs() > 0.75 {
            changes += 1;
            followed += usize::from(count(i) != count(i - 1));
        }
    }
    let share = followed as f64 / changes.max(1) as f64;
    if changes >= FEWEST_CHANGES && share < FOLLOWED_SHARE {
        let what = format!(
            "share of segment {0}'s tooth changes that its count n{0} follows",
            segment + 1
        );
        return Err(Insufficient::new(&what, share, FOLLOWED_SHARE, ""));
    }
    Ok(())
}

/// Steps that are needed to see that a segment is frozen, the share of a pitch that counts as one, and the share of them in
/// which it must have moved too. Priors: a fiftieth of a pitch is a hundred times the resolution of 0.2 µm, a segment that moves does so
/// in nearly every step, and of fifty steps that share is known to 0.065 (binomial).
pub const FEWEST_STEPS: usize = 50;
/// See [`FEWEST_STEPS`].
pub const STEP_PITCHES: f64 = 0.02;
/// See [`FEWEST_STEPS`].
pub const MOVED: f64 = 0.7;

/// Checks that a segment's readings change while the other segment of its axis, or the reference, moves.
///
/// # Errors
/// Readings that repeat themselves.
pub fn fresh(o: &Observations, segment: usize) -> Result<(), Insufficient> {
    let own = &o.position_m[segment];
    let other = (segment + 2) % 4;
    let beside = |i: usize| match o.position_m[other].get(i) {
        Some(p) => *p,
        None => o.reference_m(segment, i),
    };
    let (mut steps, mut moved) = (0usize, 0usize);
    for i in 1..own.len() {
        if o.stretch[i] == o.stretch[i - 1]
            && (beside(i) - beside(i - 1)).abs() > STEP_PITCHES * o.pitch_m
        {
            steps += 1;
            moved += usize::from(own[i] != own[i - 1]);
        }
    }
    let share = moved as f64 / steps.max(1) as f64;
    if steps >= FEWEST_STEPS && share < MOVED {
        let what = format!(
            "share of the steps of what is beside it in which segment {} moves",
            segment + 1
        );
        return Err(Insufficient::new(&what, share, MOVED, ""));
    }
    Ok(())
}

/// Of the two electrodes of an axis, the one that varies less must vary by this share of the other: they mirror one another. A
/// prior: what one gains the other loses, so that only their gains part them, by 13 % at the most that is known of a sensor's
/// channels (lib_sincos_enc); a fifth is far below that.
const MIRRORED: f64 = 0.2;

/// Checks the electrodes of the coordination sensor while a beacon is seen.
///
/// # Errors
/// An electrode that does not vary although the other one of its axis does, that never changes at all, or that is at its top
/// for most of the samples.
pub fn electrodes(recording: &Recording) -> Result<(), Insufficient> {
    const NAMES: [&str; 4] = ["psd_xp", "psd_xn", "psd_yp", "psd_yn"];
    let samples = &recording.samples;
    if !(0..4).all(|e| samples.has(Column::Electrode(e))) {
        return Ok(());
    }
    let noise = recording.meta.electronics.psd_noise_counts.unwrap_or(0.0);
    let seen: Vec<[f64; 4]> = (0..samples.len())
        .filter_map(|i| samples.electrode_counts(i))
        .filter(|e| e.iter().any(|v| *v != 0.0))
        .collect();
    if seen.len() < FEWEST_STEPS {
        return Ok(());
    }
    let of = |e: usize| seen.iter().map(|s| s[e]).collect::<Vec<f64>>();
    let found: [f64; 4] = std::array::from_fn(|e| deviation(&of(e)));
    for e in 0..4 {
        let mirror = found[e ^ 1];
        let wanted = if mirror > OVER_NOISE * noise.max(1.0) {
            MIRRORED * mirror
        } else {
            f64::MIN_POSITIVE
        };
        varies_beside(NAMES[e], found[e], wanted)?;
        if found[e] > OVER_NOISE * noise.max(1.0) {
            let values = of(e);
            let limit = values.iter().copied().fold(0.0, f64::max) - 1.0 - 3.0 * noise;
            let top = values.iter().filter(|v| **v > limit).count();
            below_top(NAMES[e], top as f64 / values.len() as f64)?;
        }
    }
    Ok(())
}

fn varies_beside(name: &str, found: f64, wanted: f64) -> Result<(), Insufficient> {
    if found < wanted {
        let what = format!("spread of {name} while a beacon is seen");
        return Err(Insufficient::new(
            &what,
            found.round(),
            wanted.ceil(),
            "counts",
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A segment that moves by so much of a tooth about the top of its cosine, and reads it with so much of the amplitude.
    fn about_a_top(travel: f64, cosine: f64) -> Result<(), Insufficient> {
        const SAMPLES: usize = 200;
        let pitch_m = 1.0e-3;
        let turns = |i: usize| travel * (i as f64 / (SAMPLES - 1) as f64 - 0.5);
        let read = |i: usize| {
            let (sine, cosine_there) = (TAU * turns(i)).sin_cos();
            [2000.0 * sine, 2000.0 * cosine * cosine_there]
        };
        let mut o = Observations {
            pitch_m,
            pair_noise_counts: 1.0,
            run: vec![0; SAMPLES],
            run_names: vec!["run".into()],
            ..Observations::default()
        };
        o.pair_counts[0] = (0..SAMPLES).map(read).collect();
        o.position_m[0] = (0..SAMPLES).map(|i| pitch_m * turns(i)).collect();
        pair(&o, 0)
    }

    /// Over little of a tooth a channel at its top hardly varies: that is told as phases that are missing, and not as a dead channel.
    #[test]
    fn no_healthy_channel_is_dead_however_little_it_travels() {
        for travel in [0.1, 0.24, 0.26, 0.279, 0.281, 0.3, 0.5, 1.0] {
            assert!(about_a_top(travel, 1.0).is_ok(), "{travel}");
        }
        assert!(about_a_top(0.5, 0.01).is_err());
    }
}
