//! A reference that is no instrument of its own.

use crate::fault::Fault;
use recording::{Column, Recording};

/// Two instruments never agree to this share of the pitch. A prior: the best interpolation of a period shows noise of a hundred
/// thousandth, ten times that.
const IDENTITY_TOLERANCE: f64 = 1.0e-6;
/// Fewer rows are no evidence.
const FEWEST_ROWS: usize = 30;

/// Segments whose readings a reference column holds.
pub(crate) fn copied(recording: &Recording) -> Vec<Fault> {
    let mut list = Vec::new();
    for segment in 0..4 {
        let axis = segment % 2;
        if same(recording, segment, axis) {
            list.push(Fault::ReferenceIsReading(segment, axis));
        }
    }
    list
}

fn same(recording: &Recording, segment: usize, axis: usize) -> bool {
    let samples = &recording.samples;
    let pitch_m = recording.meta.geometry.pitch_m;
    if !samples.has(Column::Reference(axis)) || !samples.has_segment(segment) {
        return false;
    }
    let pairs: Vec<[f64; 2]> = (0..samples.len())
        .filter_map(|i| {
            let reference_m = samples.get(Column::Reference(axis), i)?;
            let output_m = samples.unmodified_m(segment, i, pitch_m)?;
            Some([output_m - reference_m, output_m])
        })
        .collect();
    let deviation = |k: usize| {
        let count = pairs.len().max(1) as f64;
        let mean = pairs.iter().map(|p| p[k]).sum::<f64>() / count;
        let squares = pairs.iter().map(|p| (p[k] - mean).powi(2)).sum::<f64>();
        (squares / count).sqrt()
    };
    pairs.len() >= FEWEST_ROWS
        && deviation(1) > pitch_m
        && deviation(0) < IDENTITY_TOLERANCE * pitch_m
}
