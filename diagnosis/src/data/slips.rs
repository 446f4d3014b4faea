//! Whole teeth: a count that is off from some moment on, found and taken out before anything is fitted.

use crate::algebra::statistics::median;
use crate::data::observations::Observations;
use crate::linearization::baseline::Baseline;
use crate::linearization::recording::LinearizedRecording;

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

/// A slip holds at least this many samples; what is shorter is a disturbance. A prior: a count that is off stays off, where a
/// burst's noise is drawn anew at each sample: that it is off by the same number of teeth eight times is no chance.
const HOLDS: usize = 8;

/// More steps of whole teeth than these are no slips of a count: one turn of a rotary rig against a reference wraps often.
/// A prior: a counter loses a few teeth in a recording.
pub(crate) const MOST_STEPS: usize = 6;

/// Finds whole-tooth jumps and takes them out of the positions.
pub fn repair_slips(o: &mut Observations) -> Vec<Slip> {
    let mut slips = Vec::new();
    let before = o.position_m.clone();
    for segment in 0..4 {
        let against: Vec<f64> = (0..o.len()).map(|i| nominal(o, segment, i)).collect();
        slips.extend(repair_segment(o, segment, &against));
    }
    // A repair that makes the segments agree less is none: it is the reference or the command that is wrong.
    if disagreement_m(&o.position_m) > disagreement_m(&before) + AS_ITS_NEIGHBOURS * o.pitch_m {
        o.position_m = before;
        slips.clear();
    }
    if slips.is_empty() && (0..4).all(|s| o.has_segment(s)) {
        slips.extend(repair_parity(o));
    }
    slips
}

/// Mean distance of g_p from its median, m; zero where it cannot be formed.
fn disagreement_m(position_m: &[Vec<f64>; 4]) -> f64 {
    let length = position_m.iter().map(Vec::len).min().unwrap_or(0);
    let parity = |i: usize| PARITY.map(|(s, sign)| f64::from(sign) * position_m[s][i]);
    let sums = (0..length).map(|i| parity(i).iter().sum::<f64>());
    let mut list: Vec<f64> = sums.filter(|g| g.is_finite()).collect();
    let middle = median(&mut list).unwrap_or(0.0);
    list.iter().map(|g| (g - middle).abs()).sum::<f64>() / list.len().max(1) as f64
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
    let often = jumps.changes.len() > MOST_STEPS;
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

/// Segment and sign of what each adds to g_p. By definition those of equation (5).
const PARITY: [(usize, i32); 4] = [(0, 1), (2, -1), (1, -1), (3, 1)];

/// A jump of g_p is a tooth of any of the four segments: told by the step of its own output, else by the beacon.
fn repair_parity(o: &mut Observations) -> Vec<Slip> {
    let p = &o.position_m;
    let parity: Vec<f64> = (0..o.len())
        .map(|i| p[0][i] - p[2][i] - p[1][i] + p[3][i])
        .collect();
    let changes = whole_teeth(&parity, o.pitch_m).changes;
    let mut slips = Vec::new();
    for (sample, jump) in changes {
        let estimate = by_own_step(o, sample, jump).or_else(|| by_beacon(o, sample, jump));
        let (segment, sign) = estimate.unwrap_or(PARITY[0]);
        let slip = Slip {
            segment,
            teeth: sign * jump,
            sample,
            sure: estimate.is_some(),
        };
        take_out(o, &slip);
        slips.push(slip);
    }
    slips
}

fn take_out(o: &mut Observations, slip: &Slip) {
    let step_m = f64::from(slip.teeth) * o.pitch_m;
    for position in &mut o.position_m[slip.segment][slip.sample..] {
        *position -= step_m;
    }
}

/// Steps before and after a slip that tell how a segment moves. Derived from the median of ten steps, of which less than half may
/// be disturbed.
const AROUND: usize = 5;
/// A step is as its neighbours, or a slip more than they, to within this share of a pitch. Derived from the halves between whole
/// teeth: a quarter leaves as much for the motion as for the next number.
const AS_ITS_NEIGHBOURS: f64 = 0.25;

/// The one segment whose output steps by whole teeth from one sample to the next, where all others go on as they went.
fn by_own_step(o: &Observations, sample: usize, jump: i32) -> Option<(usize, i32)> {
    let beyond = PARITY.map(|(s, sign)| {
        let step = |i: usize| {
            let together = i > 0 && i < o.len() && o.stretch[i] == o.stretch[i - 1];
            together.then(|| o.position_m[s][i] - o.position_m[s][i - 1])
        };
        let around = (1..=AROUND).flat_map(|k| [sample.saturating_sub(k), sample + k]);
        let mut steps: Vec<f64> = around.filter_map(step).filter(|v| v.is_finite()).collect();
        let usual = median(&mut steps).filter(|_| steps.len() >= AROUND);
        let own = step(sample).zip(usual).map(|(step, usual)| step - usual);
        own.map(|own| (own / o.pitch_m, f64::from(sign * jump)))
    });
    let [Some(_), Some(_), Some(_), Some(_)] = beyond else {
        return None;
    };
    let near = |value: f64| value.abs() < AS_ITS_NEIGHBOURS;
    let stepped = |k: usize| beyond[k].is_some_and(|(own, teeth)| near(own - teeth));
    let still = |k: usize| beyond[k].is_some_and(|(own, _)| near(own));
    (0..4)
        .find(|&k| stepped(k) && (0..4).all(|j| j == k || still(j)))
        .map(|k| PARITY[k])
}

/// Samples with a beacon on either side of a slip that g_x and g_y are compared over. Derived from a median of fifty, which is
/// known to 0.18 of the noise: some tenths of a micrometre beside a jump of a tooth.
const COMPARED: usize = 50;
/// The segment must leave so much less of a jump in them than the next best. A derivation: with the right segment g_x and g_y go
/// on but for noise, with its partner of the pair the place jumps by a whole tooth, and a third of that is either's farthest.
const CLEARLY: f64 = 0.3;

/// The segment with which g_x and g_y go on across the slip, by the nominal lever arms.
fn by_beacon(o: &Observations, sample: usize, jump: i32) -> Option<(usize, i32)> {
    let seen = |i: &usize| o.sees_beacon(*i);
    let before: Vec<usize> = (0..sample).rev().filter(seen).take(COMPARED).collect();
    let after: Vec<usize> = (sample..o.len()).filter(seen).take(COMPARED).collect();
    let mut left: Vec<(f64, (usize, i32))> = Vec::new();
    for (segment, sign) in PARITY {
        let mut repaired = o.clone();
        let slip = Slip {
            segment,
            teeth: sign * jump,
            sample,
            sure: true,
        };
        take_out(&mut repaired, &slip);
        let linearized =
            LinearizedRecording::new(&repaired, Baseline::nominal(&repaired), vec![true; o.len()]);
        let level = |list: &[usize], row: usize| {
            let residual = |i: &usize| Some(linearized.rows(*i)).filter(|r| r.count > 2);
            let rows = list.iter().filter_map(residual);
            median(&mut rows.map(|r| r.residual_m[row]).collect::<Vec<f64>>())
        };
        let jump_m = |row: usize| Some(level(&after, row)? - level(&before, row)?);
        left.push((jump_m(1)?.hypot(jump_m(2)?), (segment, sign)));
    }
    left.sort_by(|a, b| a.0.total_cmp(&b.0));
    (left[0].0 < CLEARLY * left[1].0).then_some(left[0].1)
}

/// Whole teeth that positions are off by.
pub(crate) struct ToothJumps {
    /// Teeth to take out of each sample.
    level: Vec<i32>,
    /// Sample and size of each lasting change.
    pub(crate) changes: Vec<(usize, i32)>,
}

/// Teeth that are told apart: of two such numbers the difference is still a whole number of 32 bits, as a count is. Derived from
/// the count's 32 bits: two such differ by 2.0e9 at the most, and 2^31 is 2.1e9.
const MOST_COUNTED_TEETH: f64 = 1.0e9;

/// Whole teeth relative to the median of the first samples; single samples do not change the level's count of jumps.
pub(crate) fn whole_teeth(difference: &[f64], pitch_m: f64) -> ToothJumps {
    let mut first: Vec<f64> = difference
        .iter()
        .copied()
        .filter(|d| d.is_finite())
        .take(40)
        .collect();
    let Some(start) = median(&mut first) else {
        return ToothJumps {
            level: vec![0; difference.len()],
            changes: Vec::new(),
        };
    };
    let mut level: Vec<i32> = difference
        .iter()
        .map(|d| {
            if d.is_finite() {
                ((d - start) / pitch_m)
                    .round()
                    .clamp(-MOST_COUNTED_TEETH, MOST_COUNTED_TEETH) as i32
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
    ToothJumps { level, changes }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Positions in another unit than the command are off by more teeth than a count holds.
    #[test]
    fn jumps_beyond_any_count_are_bounded() {
        let difference: Vec<f64> = (0..60)
            .map(|i| if i < 30 { -1.0e15 } else { 1.0e15 })
            .collect();
        let jumps = whole_teeth(&difference, 1.0e-3);
        assert_eq!(jumps.changes, [(30, MOST_COUNTED_TEETH as i32)]);
        let swings = [vec![0.0; 41], vec![1.0e15; 30], vec![-1.0e15; 30]].concat();
        let changes = whole_teeth(&swings, 1.0e-3).changes;
        assert_eq!(changes[1], (71, -2 * MOST_COUNTED_TEETH as i32));
    }
}
