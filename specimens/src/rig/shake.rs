//! A recording under a beacon that vibrates, or of a segment that hums.

use recording::{Recording, Row};
use std::f64::consts::TAU;

/// Every row changed by a wave that turns `turns` from one sample to the next where the courier moves; `change` is told its value
/// and the progress of the recording (0 to 1).
fn waving(recording: &Recording, turns: f64, change: impl Fn(&mut Row, f64, f64)) -> Recording {
    let time = |i: usize| recording.samples.row(i).t_s;
    let last = recording.samples.len() - 1;
    let hz = turns / (time(last) - time(last - 1));
    recording.with_rows(|_, row| {
        let progress = (row.t_s - time(0)) / (time(last) - time(0));
        let wave = (TAU * hz * row.t_s).sin();
        change(row, wave, progress);
        true
    })
}

/// The beacon swings along x by `size` of full scale, which may change with the progress of the recording.
pub fn shaken(recording: &Recording, turns: f64, size: impl Fn(f64) -> f64) -> Recording {
    waving(recording, turns, |row, wave, progress| {
        if let Some([right, left, up, down]) = row.electrode_counts.filter(|e| *e != [0.0; 4]) {
            let by = 0.5 * (right + left) * size(progress) * wave;
            let counts = [right + by, left - by, up, down];
            row.electrode_counts = Some(counts.map(f64::round));
        }
    })
}

/// Segment 1 hums by `size_m`: a recording of positions.
pub fn hummed(recording: &Recording, turns: f64, size_m: f64) -> Recording {
    waving(recording, turns, |row, wave, _| {
        row.position_m[0] = row.position_m[0].map(|p| p + size_m * wave);
    })
}
