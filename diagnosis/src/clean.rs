//! Whole teeth and short disturbances, before anything is fitted.

use crate::observe::Observations;
use crate::statistics::{median, median_and_deviation};

/// A tooth count that is off from some moment on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slip {
    /// Segment, 0 to 3; the first of several that would do where nothing tells them apart.
    pub segment: usize,
    /// Teeth.
    pub teeth: i32,
    /// First sample that is off.
    pub sample: usize,
    /// True if a command or reference tells the segment; else only g_p was seen to jump.
    pub sure: bool,
}

/// A slip holds at least this many samples; what is shorter is a disturbance.
const HOLDS: usize = 8;

/// Finds whole-tooth jumps and takes them out of the positions.
pub fn repair_slips(o: &mut Observations) -> Vec<Slip> {
    let mut slips = Vec::new();
    for segment in 0..4 {
        let against: Vec<f64> = (0..o.len()).map(|i| nominal(o, segment, i)).collect();
        slips.extend(repair_segment(o, segment, &against));
    }
    if slips.is_empty() && (0..4).all(|s| o.has_segment(s)) {
        slips.extend(repair_parity(o));
    }
    slips
}

/// Where the segment should be by the reference, else by the command.
fn nominal(o: &Observations, segment: usize, i: usize) -> f64 {
    let reference = o.reference_m(segment, i);
    if reference.is_finite() {
        reference
    } else {
        o.commanded_m(segment, i)
    }
}

fn repair_segment(o: &mut Observations, segment: usize, against: &[f64]) -> Vec<Slip> {
    if !o.has_segment(segment) {
        return Vec::new();
    }
    let difference: Vec<f64> = o.position_m[segment]
        .iter()
        .zip(against)
        .map(|(p, c)| p - c)
        .collect();
    let jumps = whole_teeth(&difference, o.pitch_m);
    // One turn of a rotary rig against a reference wraps often: that is not a slip.
    let often = jumps.changes.len() > 6;
    for (i, teeth) in jumps.level.iter().enumerate() {
        o.position_m[segment][i] -= f64::from(*teeth) * o.pitch_m;
    }
    if often {
        return Vec::new();
    }
    jumps
        .changes
        .iter()
        .map(|&(sample, teeth)| Slip {
            segment,
            teeth,
            sample,
            sure: true,
        })
        .collect()
}

fn repair_parity(o: &mut Observations) -> Vec<Slip> {
    let p = &o.position_m;
    let parity: Vec<f64> = (0..o.len())
        .map(|i| p[0][i] - p[2][i] - p[1][i] + p[3][i])
        .collect();
    let jumps = whole_teeth(&parity, o.pitch_m);
    for (i, teeth) in jumps.level.iter().enumerate() {
        o.position_m[0][i] -= f64::from(*teeth) * o.pitch_m;
    }
    jumps
        .changes
        .iter()
        .map(|&(sample, teeth)| Slip {
            segment: 0,
            teeth,
            sample,
            sure: false,
        })
        .collect()
}

struct Jumps {
    /// Teeth to take out of each sample.
    level: Vec<i32>,
    /// Sample and size of each lasting change.
    changes: Vec<(usize, i32)>,
}

/// Whole teeth relative to the median of the first samples; single samples do not change the level's count of jumps.
fn whole_teeth(difference: &[f64], pitch_m: f64) -> Jumps {
    let mut first: Vec<f64> = difference
        .iter()
        .copied()
        .filter(|d| d.is_finite())
        .take(40)
        .collect();
    let Some(start) = median(&mut first) else {
        return Jumps {
            level: vec![0; difference.len()],
            changes: Vec::new(),
        };
    };
    let mut level: Vec<i32> = difference
        .iter()
        .map(|d| {
            if d.is_finite() {
                ((d - start) / pitch_m).round() as i32
            } else {
                0
            }
        })
        .collect();
    let mut changes = Vec::new();
    let mut now = 0;
    let mut i = 0;
    while i < level.len() {
        if !difference[i].is_finite() {
            level[i] = now;
        } else if level[i] != now {
            let end = (i..level.len())
                .find(|&j| difference[j].is_finite() && level[j] != level[i])
                .unwrap_or(level.len());
            if end - i >= HOLDS || end == level.len() {
                changes.push((i, level[i] - now));
                now = level[i];
            } else {
                // Too short for a slip: a disturbance; the samples are left as they are.
                level[i..end].iter_mut().for_each(|l| *l = now);
                i = end;
                continue;
            }
        }
        i += 1;
    }
    Jumps { level, changes }
}

/// Samples in a piece over which a disturbance must stand out.
const PIECE: usize = 60;
/// By this many robust deviations.
const OUTSIDE: f64 = 7.0;

/// Marks samples that stand out of their neighbourhood. `rows` are (sample, channel, whitened residual) in time order.
pub fn disturbed(rows: &[(usize, usize, f64)], samples: usize, stretch: &[usize]) -> Vec<bool> {
    let mut marked = vec![false; samples];
    for channel in 0..effects::sensor::CHANNELS {
        let list: Vec<(usize, f64)> = rows
            .iter()
            .filter(|r| r.1 == channel)
            .map(|r| (r.0, r.2))
            .collect();
        let mut start = 0;
        while start < list.len() {
            let mut end = start;
            while end < list.len()
                && end - start < PIECE
                && stretch[list[end].0] == stretch[list[start].0]
            {
                end += 1;
            }
            let mut values: Vec<f64> = list[start..end].iter().map(|r| r.1).collect();
            if let Some((centre, deviation)) =
                median_and_deviation(&mut values).filter(|_| end - start >= 20)
            {
                let limit = OUTSIDE * deviation.max(1.0);
                for (i, value) in &list[start..end] {
                    if (value - centre).abs() > limit {
                        marked[*i] = true;
                    }
                }
            }
            start = end;
        }
    }
    marked
}
