//! Poses under the beacon from a recording: outputs of the four segments and the deflection of the coordination sensor.

use super::rulings::Rulings;
use anyhow::{Result, ensure};
use courier_sensor::frame::SEGMENTS;
use courier_sensor::geometry::Geometry;
use recording::Recording;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Most poses that are fitted. A bound on the work: of more, every so many are taken; they are enough for the largest map, and a
/// minute of one core.
const MOST: usize = 6000;
/// Samples that follow each other within this place are one pose, pitches: a standstill, whatever its length. Derived from the
/// noise floor of 0.3 µm: 4 µm are thirteen of it.
const STILL_PITCHES: f64 = 4.0e-3;
/// Longest standstill that is one pose, samples. Derived from their mean, which is then known to a twentieth of the noise: the
/// platen's teeth leave more.
const LONGEST: usize = 400;
/// What the firmware calls an electrode at the converter's end. By definition seven below the end of 16 bits.
const CLIPPED: f64 = 32_760.0;

/// One pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TeethPose {
    /// Unmodified outputs from the board's tooth count zero, metres.
    pub outputs_m: [f64; SEGMENTS],
    /// Deflection, 1 at full scale.
    pub deflection: [f64; 2],
}

/// Readings' noise, metres.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Noise {
    /// Of a segment.
    pub segment_m: f64,
    /// Of a displacement under the beacon.
    pub displacement_m: f64,
}

/// Geometry as entered, and the noise of one reading as stated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setup {
    /// Tooth pitch.
    pub pitch_m: f64,
    /// l_s.
    pub span_m: f64,
    /// l_o.
    pub lateral_m: f64,
    /// h.
    pub height_m: f64,
    /// l_x, l_y.
    pub lever_m: [f64; 2],
    /// tan psi at a deflection of 1.
    pub tan_full_scale: f64,
    /// The platen's rulings, where more is known of them than that they are two equal ones at right angles.
    pub rulings: Rulings,
    /// Least noise of a segment that is believed, metres.
    pub segment_noise_m: f64,
    /// Least noise of a displacement that is believed, metres.
    pub displacement_noise_m: f64,
}

impl Setup {
    /// A geometry as entered, and what is known of the noise of a pose's averaged readings, metres.
    #[must_use]
    pub fn entered(geometry: &Geometry, segment_noise_m: f64, displacement_noise_m: f64) -> Self {
        Self {
            pitch_m: f64::from(geometry.pitch_m),
            span_m: f64::from(geometry.span_m),
            lateral_m: f64::from(geometry.lateral_m),
            height_m: f64::from(geometry.height_m),
            lever_m: geometry.lever_m.map(f64::from),
            tan_full_scale: f64::from(geometry.tan_full_scale),
            rulings: Rulings::default(),
            segment_noise_m,
            displacement_noise_m,
        }
    }

    /// The least noise that is believed.
    #[must_use]
    pub fn stated_noise(&self) -> Noise {
        Noise {
            segment_m: self.segment_noise_m,
            displacement_m: self.displacement_noise_m,
        }
    }
}

/// Takes a recording apart: standstills are averaged, samples in motion stand for themselves, every n-th if there are many.
///
/// # Errors
/// A segment, the coordination sensor or a length is missing; no sample sees the beacon.
pub fn poses_of(recording: &Recording) -> Result<(Setup, Vec<TeethPose>)> {
    let setup = setup_of(recording)?;
    let mut poses = Vec::new();
    let mut stand: Vec<TeethPose> = Vec::new();
    for index in 0..recording.samples.len() {
        let Some(pose) = pose_at(recording, &setup, index) else {
            continue;
        };
        let same = stand.first().is_some_and(|first| {
            let moved = |i: usize| (first.outputs_m[i] - pose.outputs_m[i]).abs();
            (0..SEGMENTS).all(|i| moved(i) < STILL_PITCHES * setup.pitch_m)
        });
        if !same || stand.len() >= LONGEST {
            poses.extend(mean(&stand));
            stand.clear();
        }
        stand.push(pose);
    }
    poses.extend(mean(&stand));
    ensure!(
        !poses.is_empty(),
        "samples.csv: found no sample with all four segments under a beacon, wanted a motion under one"
    );
    let step = poses.len().div_ceil(MOST);
    Ok((setup, poses.into_iter().step_by(step).collect()))
}

fn setup_of(recording: &Recording) -> Result<Setup> {
    let meta = &recording.meta;
    let (Some(span_m), Some(lateral_m)) = (meta.geometry.span_m, meta.geometry.lateral_m) else {
        anyhow::bail!("recording.toml: [geometry] span_m or lateral_m: found none, wanted both");
    };
    let Some(coordination) = &meta.coordination else {
        anyhow::bail!(
            "recording.toml: [coordination]: found none, wanted a recording under a beacon"
        );
    };
    for segment in 0..SEGMENTS {
        ensure!(
            recording.samples.has_segment(segment),
            "samples.csv: segment {}: found no output, wanted all four segments",
            segment + 1
        );
    }
    let pitch_m = meta.geometry.pitch_m;
    let electronics = &meta.electronics;
    let by_counts = electronics
        .quadrature_noise_counts
        .zip(electronics.amplitude_counts);
    let one_reading = by_counts.map(|(noise, amplitude)| noise / amplitude * pitch_m / TAU);
    let deflection_noise = electronics
        .psd_noise_counts
        .zip(electronics.psd_sum_counts)
        .map(|(noise, sum)| 2.0_f64.sqrt() * noise / sum);
    let scale_m = coordination.height_m * coordination.tan_full_scale;
    Ok(Setup {
        pitch_m,
        span_m,
        lateral_m,
        height_m: coordination.height_m,
        lever_m: [coordination.lever_x_m, coordination.lever_y_m],
        tan_full_scale: coordination.tan_full_scale,
        rulings: Rulings::default(),
        // A standstill's mean is better than one reading: a quarter, for sixteen of them.
        segment_noise_m: 0.25
            * one_reading
                .or(electronics.position_noise_m)
                .unwrap_or(0.2e-6),
        displacement_noise_m: 0.25 * deflection_noise.map_or(0.5e-6, |noise| noise * scale_m),
    })
}

fn pose_at(recording: &Recording, setup: &Setup, index: usize) -> Option<TeethPose> {
    let samples = &recording.samples;
    let mut outputs_m = [0.0; SEGMENTS];
    for (segment, output_m) in outputs_m.iter_mut().enumerate() {
        *output_m = samples.unmodified_m(segment, index, setup.pitch_m)?;
    }
    let counts = samples.electrode_counts(index)?;
    if counts.iter().any(|count| *count >= CLIPPED) {
        return None;
    }
    let [xp, xn, yp, yn] = counts;
    let ratio = |p: f64, n: f64| (p + n > 0.0).then(|| (p - n) / (p + n));
    Some(TeethPose {
        outputs_m,
        deflection: [ratio(xp, xn)?, ratio(yp, yn)?],
    })
}

fn mean(stand: &[TeethPose]) -> Option<TeethPose> {
    let share = 1.0 / stand.len() as f64;
    let first = stand.first()?;
    let mut mean = *first;
    for pose in &stand[1..] {
        for i in 0..SEGMENTS {
            mean.outputs_m[i] += share * (pose.outputs_m[i] - first.outputs_m[i]);
        }
        for i in 0..2 {
            mean.deflection[i] += share * (pose.deflection[i] - first.deflection[i]);
        }
    }
    Some(mean)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_standstill_is_one_pose() {
        let at = |x: f64| TeethPose {
            outputs_m: [x; 4],
            deflection: [x, 0.0],
        };
        let both = mean(&[at(1.0), at(1.5), at(2.0)]).unwrap();
        assert!(
            (both.outputs_m[0] - 1.5).abs() < 1e-12 && (both.deflection[0] - 1.5).abs() < 1e-12
        );
        assert!(mean(&[]).is_none());
    }
}
