//! Tooth counts that begin anew in each run: the recorder was started again, and each segment's zero is where it stood then.
//!
//! Each run is laid upon the first by whole teeth: as the command has it where there is one, else so that the pairs tell the same
//! angle to half a tooth (52 mrad at a span of ten pitches: no courier turns so far between runs), and so that the coordination
//! sensor sees one beacon.

use crate::algebra::statistics::median;
use crate::data::commanded::pieces;
use crate::data::observations::Observations;
use crate::linearization::baseline::Baseline;
use crate::linearization::recording::LinearizedRecording;
use recording::{Column, Recording};
use std::ops::Range;

/// Teeth by which the first counts of two runs may differ where both begin at zero. Derived from rounding: a courier that stands
/// between two teeth may begin at either.
const NEAR_PITCHES: f64 = 1.0;

/// Lays runs upon each other whose counts begin anew; what was done, where any moved.
pub fn join(o: &mut Observations, recording: &Recording) -> Option<String> {
    let runs = pieces(&o.run);
    if runs.len() < 2 || !begin_anew(recording, &runs) {
        return None;
    }
    let mut moved = false;
    for run in runs.iter().skip(1) {
        moved |= by_command(o, &runs[0], run) || by_angle(o, &runs[0], run);
    }
    moved |= by_beacon(o, &runs);
    moved.then(|| {
        format!(
            "n1 to n4: begin anew in each of {} runs: laid upon each other by whole teeth, as commands, the pairs' angles and the beacon have it",
            runs.len()
        )
    })
}

/// True if every run begins at the counts that the first one begins at, though some run ended elsewhere.
fn begin_anew(recording: &Recording, runs: &[Range<usize>]) -> bool {
    let counts = |segment: usize| recording.samples.column(Column::Teeth(segment));
    let counted = (0..4).filter(|s| !counts(*s).is_empty());
    let mut elsewhere = false;
    let mut any = false;
    for segment in counted {
        let teeth = counts(segment);
        let start = teeth[runs[0].start];
        let near = |i: usize| (teeth[i] - start).abs() <= NEAR_PITCHES;
        if !runs.iter().all(|run| near(run.start)) {
            return false;
        }
        let ends = runs[..runs.len() - 1].iter();
        elsewhere |= ends
            .clone()
            .any(|run| !near(run.end - 1) && teeth[run.end - 1].is_finite());
        any = true;
    }
    any && elsewhere
}

fn middle(run: &Range<usize>, value: impl Fn(usize) -> f64) -> Option<f64> {
    let known = run.clone().map(value).filter(|v| v.is_finite());
    median(&mut known.collect::<Vec<f64>>())
}

/// Moves a segment in a run by whole teeth; true if it is not none.
fn shift(o: &mut Observations, segment: usize, run: &Range<usize>, by_m: f64) -> bool {
    let teeth = (by_m / o.pitch_m).round();
    if teeth == 0.0 {
        return false;
    }
    let by_m = teeth * o.pitch_m;
    o.position_m[segment][run.clone()]
        .iter_mut()
        .for_each(|p| *p -= by_m);
    true
}

fn by_command(o: &mut Observations, first: &Range<usize>, run: &Range<usize>) -> bool {
    let mut moved = false;
    for segment in (0..4)
        .filter(|s| o.position_m[*s].len() == o.len())
        .collect::<Vec<_>>()
    {
        let off = |i: usize| o.position_m[segment][i] - o.commanded_m(segment, i);
        if let (Some(there), Some(here)) = (middle(first, off), middle(run, off)) {
            moved |= shift(o, segment, run, here - there);
        }
    }
    moved
}

fn by_angle(o: &mut Observations, first: &Range<usize>, run: &Range<usize>) -> bool {
    let mut moved = false;
    for segment in 0..2 {
        if !(o.has_segment(segment) && o.has_segment(segment + 2)) {
            continue;
        }
        let apart = |i: usize| o.position_m[segment + 2][i] - o.position_m[segment][i];
        if let (Some(there), Some(here)) = (middle(first, apart), middle(run, apart)) {
            moved |= shift(o, segment + 2, run, here - there);
        }
    }
    moved
}

/// By the beacon, which stands in one place: the first run that sees it tells where.
fn by_beacon(o: &mut Observations, runs: &[Range<usize>]) -> bool {
    let linearized = LinearizedRecording::new(o, Baseline::nominal(o), vec![true; o.len()]);
    if linearized.scope.reference || !linearized.scope.beacon {
        return false;
    }
    let at = |axis: usize, i: usize| {
        let rows = linearized.rows(i);
        let row = (0..rows.count).find(|r| rows.channel[*r] == 1 + axis);
        row.map_or(f64::NAN, |r| rows.residual_m[r])
    };
    let levels: Vec<[Option<f64>; 2]> = runs
        .iter()
        .map(|run| [0, 1].map(|axis| middle(run, |i| at(axis, i))))
        .collect();
    drop(linearized);
    let mut moved = false;
    for axis in 0..2 {
        let Some(there) = levels.iter().find_map(|level| level[axis]) else {
            continue;
        };
        for (run, level) in runs.iter().zip(&levels) {
            let Some(here) = level[axis] else { continue };
            // A place further on is a residual less by as much (equation 11).
            for segment in [axis, axis + 2] {
                moved |= shift(o, segment, run, there - here);
            }
        }
    }
    moved
}
