//! A board's calibration on a recording: the firmware's signal path with it, nothing fitted.

use super::observe::as_count;
use super::report::deviation;
use anyhow::{Result, ensure};
use courier_sensor::calibration::record::Calibration;
use courier_sensor::equations::PARITY_SIGN;
use courier_sensor::frame::{Frame, RawFrame, SEGMENTS};
use courier_sensor::settings::Settings;
use courier_sensor::step::{StepConfig, StepState, step};
use recording::{Recording, instants_between};
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
    let interval_s = recording.samples.sample_interval_s();
    let interval_s = interval_s.unwrap_or_else(|| 1.0 / f64::from(Settings::default().rate_hz));
    let rate_hz = (1.0 / interval_s) as f32;
    let config = StepConfig::build(&Settings {
        geometry: calibration.geometry,
        rate_hz,
        pairs: calibration.pairs,
        model: Some(calibration.model.clone()),
        ..Settings::default()
    })?;
    let (mut raw_m, mut calibrated_m) = (Vec::new(), Vec::new());
    for stretch in recording.samples.stretches() {
        follow(recording, &config, interval_s, stretch, |frame| {
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

/// Steps through a stretch; the first sample sets the tooth counts to the recorded ones. Instants without a row, or without counts, are time
/// that passes, as on the board.
fn follow(
    recording: &Recording,
    config: &StepConfig,
    interval_s: f64,
    stretch: Range<usize>,
    mut watch: impl FnMut(&Frame),
) {
    let mut state = StepState::new();
    let times = recording.samples.t_s();
    let (mut begun, mut last_s) = (false, None);
    for index in stretch {
        let Some(raw) = counts(recording, index) else {
            continue;
        };
        if let Some(last_s) = last_s.replace(times[index]) {
            state.skip(instants_between(last_s, times[index], interval_s));
        }
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

#[cfg(test)]
mod tests {
    use super::*;
    use courier_sensor::geometry::Geometry;
    use recording::{Electronics, Meta, Row, Samples};

    const INTERVAL_S: f64 = 5.0e-5;
    /// 1.5 m/s at 20 kHz.
    const TURNS_A_SAMPLE: f64 = 1.5 * INTERVAL_S / 1.016e-3;

    fn turns(sample: u32) -> f64 {
        TURNS_A_SAMPLE * f64::from(sample)
    }

    /// Every segment at a constant speed, without the rows that `is_missed` names.
    fn moving(is_missed: fn(u32) -> bool) -> Recording {
        let mut samples = Samples::default();
        for sample in (0..400).filter(|sample| !is_missed(*sample)) {
            let (sine, cosine) = (turns(sample) * std::f64::consts::TAU).sin_cos();
            let pair = Some([(20_000.0 * sine).round(), (20_000.0 * cosine).round()]);
            samples.push(&Row {
                t_s: f64::from(sample) * INTERVAL_S,
                quadrature_counts: [pair; SEGMENTS],
                teeth: [Some(turns(sample).round() as i32); SEGMENTS],
                ..Row::default()
            });
        }
        let geometry = recording::Geometry {
            pitch_m: 1.016e-3,
            span_m: None,
            lateral_m: None,
        };
        let electronics = Electronics::default();
        let meta = Meta {
            geometry,
            electronics,
            ..Meta::default()
        };
        Recording {
            meta,
            samples,
            warnings: vec![],
        }
    }

    #[test]
    fn teeth_that_go_by_in_missed_instants_are_counted() {
        let recording = moving(|sample| sample % 40 == 39 || (100..108).contains(&sample));
        // The last one, 399, is followed by no row.
        assert_eq!(recording.samples.missed_instants(), 17);
        let config = StepConfig::build(&Settings {
            geometry: Geometry::PAPER,
            ..Settings::default()
        });
        let mut numbers = vec![];
        let stretch = 0..recording.samples.len();
        follow(&recording, &config.unwrap(), INTERVAL_S, stretch, |frame| {
            let output = frame.segments[0].unmodified;
            let found = f64::from(output.teeth) + f64::from(output.fraction_turns);
            assert!((found - turns(frame.sequence)).abs() < 1.0e-3, "{frame:?}");
            numbers.push(frame.sequence);
        });
        assert_eq!(numbers.last(), Some(&398));
    }
}
