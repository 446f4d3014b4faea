//! A recording under a beacon that vibrates, or of a segment that hums.

use recording::{Recording, Samples};
use std::f64::consts::TAU;

/// Swings along x by `size` of full scale, which may change with the progress of the recording (0 to 1), and turns `turns` from one
/// sample to the next where the courier moves.
pub fn shaken(recording: &Recording, turns: f64, size: impl Fn(f64) -> f64) -> Recording {
    let mut out = recording.clone();
    out.samples = Samples::default();
    let time = |i: usize| recording.samples.row(i).t_s;
    let last = recording.samples.len() - 1;
    let hz = turns / (time(last) - time(last - 1));
    for i in 0..=last {
        let mut row = recording.samples.row(i);
        if let Some([right, left, up, down]) = row.electrode_counts.filter(|e| *e != [0.0; 4]) {
            let progress = (row.t_s - time(0)) / (time(last) - time(0));
            let by = 0.5 * (right + left) * size(progress) * (TAU * hz * row.t_s).sin();
            let counts = [right + by, left - by, up, down];
            row.electrode_counts = Some(counts.map(f64::round));
        }
        out.samples.push(&row);
    }
    out
}

/// Segment 1 hums by `size_m`, `turns` from one sample to the next where the courier moves: a recording of positions.
pub fn hummed(recording: &Recording, turns: f64, size_m: f64) -> Recording {
    let mut out = recording.clone();
    out.samples = Samples::default();
    let time = |i: usize| recording.samples.row(i).t_s;
    let last = recording.samples.len() - 1;
    let hz = turns / (time(last) - time(last - 1));
    for i in 0..=last {
        let mut row = recording.samples.row(i);
        let by = size_m * (TAU * hz * row.t_s).sin();
        row.position_m[0] = row.position_m[0].map(|p| p + by);
        out.samples.push(&row);
    }
    out
}
