//! A board's calibration on a recording: the firmware's signal path with it, nothing fitted.

use super::observe::as_count;
use super::report::deviation;
use anyhow::{Result, ensure};
use courier_sensor::calibration::record::Calibration;
use courier_sensor::equations::PARITY_SIGN;
use courier_sensor::frame::{Frame, RawFrame, SEGMENTS};
use courier_sensor::settings::Settings;
use courier_sensor::step::{StepConfig, StepState, step};
use recording::Recording;
use serde::Serialize;
use std::ops::Range;

/// g_p of equation (5) over a recording, mean removed: an offset moves no position.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Applied {
    /// Samples with the counts of all four segments.
    pub samples: usize,
    /// Of unmodified outputs, rms m.
    pub raw_rms_m: f64,
    /// Of the outputs that the calibration corrects, rms m.
    pub calibrated_rms_m: f64,
}

/// Runs the signal path over every stretch of a recording with counts.
///
/// # Errors
/// The recording has no counts of four segments, or another pitch than the calibration; the calibration cannot be used.
pub fn applied(recording: &Recording, calibration: &Calibration) -> Result<Applied> {
    let pitch_m = recording.meta.geometry.pitch_m;
    let of_calibration = f64::from(calibration.geometry.pitch_m);
    ensure!(
        (pitch_m / of_calibration - 1.0).abs() < 1.0e-6,
        "geometry.pitch_m: found {pitch_m} in the recording and {of_calibration} in the calibration, wanted one courier's"
    );
    let rate_hz = recording
        .samples
        .sample_interval_s()
        .map_or(Settings::default().rate_hz, |interval_s| {
            (1.0 / interval_s) as f32
        });
    let config = StepConfig::build(&Settings {
        geometry: calibration.geometry,
        rate_hz,
        pairs: calibration.pairs,
        model: Some(calibration.model.clone()),
        ..Settings::default()
    })?;
    let (mut raw_m, mut calibrated_m) = (Vec::new(), Vec::new());
    for stretch in recording.samples.stretches() {
        follow(recording, &config, stretch, |frame| {
            let unmodified = frame.segments.map(|segment| segment.unmodified);
            let terms = std::array::from_fn::<f64, SEGMENTS, _>(|s| {
                f64::from(PARITY_SIGN[s])
                    * (f64::from(unmodified[s].teeth) + f64::from(unmodified[s].fraction_turns))
            });
            raw_m.push(pitch_m * terms.iter().sum::<f64>());
            calibrated_m.push(f64::from(frame.parity_m));
        });
    }
    ensure!(
        raw_m.len() > 1,
        "samples.csv: found {} samples with the counts of all four segments, wanted 2 or more",
        raw_m.len()
    );
    Ok(Applied {
        samples: raw_m.len(),
        raw_rms_m: deviation(&raw_m),
        calibrated_rms_m: deviation(&calibrated_m),
    })
}

/// Steps through a stretch; the first sample sets the tooth counts to the recorded ones.
fn follow(
    recording: &Recording,
    config: &StepConfig,
    stretch: Range<usize>,
    mut watch: impl FnMut(&Frame),
) {
    let mut state = StepState::new();
    let mut begun = false;
    for index in stretch {
        let Some(raw) = counts(recording, index) else {
            continue;
        };
        let frame = step(config, &mut state, &raw);
        if begun {
            watch(&frame);
            continue;
        }
        state.set_teeth(std::array::from_fn(|segment| {
            let output_m = recording
                .samples
                .unmodified_m(segment, index, recording.meta.geometry.pitch_m)
                .unwrap_or_default();
            let phase = f64::from(frame.segments[segment].unmodified.fraction_turns);
            (output_m / recording.meta.geometry.pitch_m - phase).round() as i32
        }));
        begun = true;
    }
}

fn counts(recording: &Recording, index: usize) -> Option<RawFrame> {
    let mut raw = RawFrame::default();
    for (segment, pair) in raw.quadrature_counts.iter_mut().enumerate() {
        let [sine, cosine] = recording.samples.quadrature_counts(segment, index)?;
        *pair = [as_count(sine)?, as_count(cosine)?];
    }
    Some(raw)
}
