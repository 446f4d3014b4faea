//! Whole recordings as the signal path's inputs, for the parity check: a simulated courier's, and real ones where they are.

use anyhow::{Context, Result};
use courier_sensor::frame::RawFrame;
use hal_sim::courier::Courier;
use hal_sim::presets::paper;
use hal_sim::record::record;
use hal_sim::trajectory::{OpenLoop, Plan};
use recording::Recording;
use std::f64::consts::TAU;
use std::path::PathBuf;

/// Poses of each kind in the simulated recording, beside some 6500 samples of motion.
const POSES: usize = 200;
/// Where outputs were logged and no counts, the counts are those of this amplitude.
const AMPLITUDE_COUNTS: f64 = 20_000.0;
/// Real recordings, below the folder of shared data.
const REAL: [&str; 2] = ["ess-rotary-normal", "ess-rotary-drive-divided"];

/// A recording's name and frames.
pub struct Frames {
    /// For the report.
    pub name: String,
    /// In order.
    pub frames: Vec<RawFrame>,
}

/// All there are. What is absent is said on standard error.
///
/// # Errors
/// A recording that is there cannot be read.
pub fn all() -> Result<Vec<Frames>> {
    let mut all = vec![of("simulated courier".to_owned(), &simulated()?)];
    let data = data_folder();
    for name in REAL {
        let folder = data.join(name);
        if folder.exists() {
            all.push(of(name.to_owned(), &Recording::read(&folder)?));
        } else {
            eprintln!(
                "SKIPPED: no recording at {}; set COURIER_SHARED to the folder that holds data/",
                folder.display()
            );
        }
    }
    Ok(all)
}

/// Real data are no part of the project: `$COURIER_SHARED/data`, or `../shared/data` beside the checkout.
fn data_folder() -> PathBuf {
    let beside = || crate::arm::root().join("../shared");
    std::env::var_os("COURIER_SHARED")
        .map_or_else(beside, PathBuf::from)
        .join("data")
}

/// Everything that a recording usually holds.
fn simulated() -> Result<Recording> {
    let (spec, seed) = (paper(), 1);
    let plan = Plan::usual(POSES, spec.nominal, &spec.places, OpenLoop::COURIER, seed);
    let mut courier = Courier::new(spec, seed).context("the preset's waveforms")?;
    Ok(record(&mut courier, &plan, false))
}

fn of(name: String, recording: &Recording) -> Frames {
    let samples = &recording.samples;
    let frames = (0..samples.len()).map(|index| RawFrame {
        quadrature_counts: std::array::from_fn(|segment| pair(recording, segment, index)),
        electrode_counts: samples
            .electrode_counts(index)
            .map_or([0; 4], |counts| counts.map(|count| count as i16)),
        ..RawFrame::default()
    });
    Frames {
        name,
        frames: frames.collect(),
    }
}

/// A segment's counts: as logged, else those that its logged output would have given, else of a dead pair.
fn pair(recording: &Recording, segment: usize, index: usize) -> [i16; 2] {
    let (samples, pitch_m) = (&recording.samples, recording.meta.geometry.pitch_m);
    let logged = samples.quadrature_counts(segment, index);
    let output = || samples.unmodified_m(segment, index, pitch_m);
    let made = |output_m: f64| {
        let (sine, cosine) = (TAU * output_m / pitch_m).sin_cos();
        [sine, cosine].map(|part| AMPLITUDE_COUNTS * part)
    };
    let counts = logged.or_else(|| output().map(made));
    counts.map_or([0; 2], |pair| pair.map(|count| count.round() as i16))
}

/// A file for the measuring image: 12 counts of 16 bits, lower byte first, and the temperature difference in f32, a frame.
pub fn bytes(frames: &[RawFrame]) -> Vec<u8> {
    let frame = |raw: &RawFrame| {
        let counts = raw.quadrature_counts.as_flattened().iter();
        let mut bytes: Vec<u8> = counts
            .chain(&raw.electrode_counts)
            .flat_map(|count| count.to_le_bytes())
            .collect();
        bytes.extend(raw.temperature_delta_k.to_le_bytes());
        bytes
    };
    frames.iter().flat_map(frame).collect()
}
