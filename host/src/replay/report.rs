//! The figures of a replay.

use super::blocks::{Split, split};
use super::channel::Channel;
use super::fit::{Fit, Phase, Problem};
use super::observe::{Observer, Sample};
use anyhow::{Result, ensure};
use indicatif::ProgressBar;
use recording::Recording;
use serde::Serialize;

/// Root mean squares over the held-out samples, metres.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct HeldOut {
    /// With unmodified outputs, the fitted samples' mean removed: an offset is no error of the sensor.
    pub raw_rms_m: f64,
    /// With equation (3), coefficients by the firmware's incremental estimator in f32.
    pub calibrated_rms_m: f64,
    /// With equation (3), coefficients by a batch solution in f64.
    pub batch_f64_rms_m: f64,
}

/// One channel's figures.
#[derive(Clone, Debug, Serialize)]
pub struct ChannelReport {
    /// `g_p` or `segment_1` to `segment_4`.
    pub channel: Channel,
    /// Samples that were fitted.
    pub fitted: usize,
    /// Samples that were held out.
    pub held_out: usize,
    /// The figures.
    #[serde(flatten)]
    pub rms: HeldOut,
    /// Equation (3)'s orders in the phase of the reference instead of the output's, batch f64: how much of what is left is
    /// due to an error so large that the output's phase no longer stands for the true one. Against a reference only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference_phase_rms_m: Option<f64>,
    /// Unknowns of the fit.
    pub unknowns: usize,
    /// Condition number of the fitted rows.
    pub condition_number: f64,
    /// Offset, then eight coefficients of each segment, metres.
    pub coefficients_m: Vec<f64>,
}

/// Position by four calibrated segments against the reference, which was not fitted; mean removed, rms, metres.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Position {
    /// `x` or `y`.
    pub axis: &'static str,
    /// Samples with a reference.
    pub samples: usize,
    /// Unmodified outputs.
    pub raw_rms_m: f64,
    /// Calibrated by redundancy.
    pub calibrated_rms_m: f64,
}

/// All figures of a replay.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Over all channels.
    pub held_out: HeldOut,
    /// Each channel.
    pub channels: Vec<ChannelReport>,
    /// Against the reference, where four segments have one.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub position: Vec<Position>,
}

/// Calibrates on two thirds of the recording's blocks and judges on the rest.
///
/// # Errors
/// Nothing to compare with, too few samples, or a motion that does not determine equation (3).
pub fn replay(recording: &Recording, progress: &ProgressBar) -> Result<Report> {
    let channels = Channel::of(recording);
    ensure!(
        !channels.is_empty(),
        "samples.csv: found neither four segments nor a reference (ref_x_m for segments 1 and 3, ref_y_m for 2 and 4), \
         wanted one of them"
    );
    let observer = Observer::new(recording)?;
    progress.set_length((recording.samples.len() * channels.len()) as u64);
    let mut judged = Vec::new();
    for channel in channels {
        judged.push(judge(recording, &observer, channel, progress)?);
    }
    progress.finish_and_clear();
    let pooled = |pick: fn(&HeldOut) -> f64| {
        let all: usize = judged.iter().map(|judged| judged.report.held_out).sum();
        let sum: f64 = judged
            .iter()
            .map(|judged| judged.report.held_out as f64 * pick(&judged.report.rms).powi(2))
            .sum();
        (sum / all as f64).sqrt()
    };
    Ok(Report {
        held_out: HeldOut {
            raw_rms_m: pooled(|rms| rms.raw_rms_m),
            calibrated_rms_m: pooled(|rms| rms.calibrated_rms_m),
            batch_f64_rms_m: pooled(|rms| rms.batch_f64_rms_m),
        },
        position: judged.iter().flat_map(Judged::position).collect(),
        channels: judged.into_iter().map(|judged| judged.report).collect(),
    })
}

/// One channel's figures and what they came from.
struct Judged {
    report: ChannelReport,
    problem: Problem,
    incremental: Fit,
    held_out: Vec<Sample>,
}

/// The samples of a channel, and which of them are fitted.
pub(super) struct Seen {
    /// In order of time.
    pub(super) samples: Vec<Sample>,
    /// Their indices.
    pub(super) split: Split,
}

/// Runs the signal path over a recording for one channel.
pub(super) fn seen(
    recording: &Recording,
    observer: &Observer,
    channel: Channel,
    progress: &ProgressBar,
) -> Seen {
    let pitch_m = recording.meta.geometry.pitch_m;
    let mut samples = Vec::new();
    let mut places = Vec::new();
    for index in 0..recording.samples.len() {
        let sample = observer.sample(recording, index);
        if channel.measured(&sample) {
            places.push((
                samples.len(),
                channel.places(&sample).map(|place_m| place_m / pitch_m),
            ));
            samples.push(sample);
        }
        progress.inc(1);
    }
    let split = split(&places);
    Seen { samples, split }
}

/// Refuses a motion too short to hold samples out.
///
/// # Errors
/// There are none.
pub(super) fn enough_held_out(channel: Channel, split: &Split) -> Result<()> {
    ensure!(
        !split.held_out.is_empty(),
        "{}: found no samples to hold out, wanted a longer motion",
        channel.name()
    );
    Ok(())
}

fn judge(
    recording: &Recording,
    observer: &Observer,
    channel: Channel,
    progress: &ProgressBar,
) -> Result<Judged> {
    let pitch_m = recording.meta.geometry.pitch_m;
    let Seen { samples, split } = seen(recording, observer, channel, progress);
    let fitted = &split.fitted;
    let problem = Problem::new(channel, observer.geometry, pitch_m);
    let chosen = || fitted.iter().map(|index| &samples[*index]);
    let incremental = problem.incremental(chosen())?;
    let batch = problem.batch(chosen(), Phase::Output)?;
    enough_held_out(channel, &split)?;
    let held_out: Vec<Sample> = split.held_out.iter().map(|index| samples[*index]).collect();
    let mean_m = chosen().map(|sample| channel.raw_m(sample)).sum::<f64>() / fitted.len() as f64;
    let rms = HeldOut {
        raw_rms_m: rms(held_out.iter().map(|sample| channel.raw_m(sample) - mean_m)),
        calibrated_rms_m: rms(held_out
            .iter()
            .map(|sample| problem.device_residual_m(&incremental, sample))),
        batch_f64_rms_m: rms(held_out
            .iter()
            .map(|sample| problem.batch_residual_m(&batch, sample, Phase::Output))),
    };
    let reference_phase_rms_m = match channel {
        Channel::Parity => None,
        Channel::Segment(_) => {
            let fit = problem.batch(chosen(), Phase::Reference)?;
            let residual = |sample| problem.batch_residual_m(&fit, sample, Phase::Reference);
            Some(self::rms(held_out.iter().map(residual)))
        }
    };
    let report = ChannelReport {
        channel,
        reference_phase_rms_m,
        fitted: fitted.len(),
        held_out: held_out.len(),
        rms,
        unknowns: problem.unknowns(),
        condition_number: incremental.condition_number,
        coefficients_m: incremental.coefficients_m.clone(),
    };
    Ok(Judged {
        report,
        problem,
        incremental,
        held_out,
    })
}

impl Judged {
    /// Position along both axes, where four segments and a reference are there.
    fn position(&self) -> Vec<Position> {
        if self.report.channel != Channel::Parity {
            return Vec::new();
        }
        (0..2)
            .filter_map(|axis| self.position_along(axis))
            .collect()
    }

    fn position_along(&self, axis: usize) -> Option<Position> {
        let (mut raw_m, mut calibrated_m) = (Vec::new(), Vec::new());
        for sample in &self.held_out {
            let (Some(first_m), Some(second_m)) =
                (sample.reference_m[axis], sample.reference_m[axis + 2])
            else {
                continue;
            };
            let error_m = 0.5
                * (sample.unmodified_m[axis] + sample.unmodified_m[axis + 2] - first_m - second_m);
            let corrections_m = self.problem.corrections_m(&self.incremental, sample);
            raw_m.push(error_m);
            calibrated_m.push(error_m + 0.5 * (corrections_m[axis] + corrections_m[axis + 2]));
        }
        (raw_m.len() > 1).then(|| Position {
            axis: ["x", "y"][axis],
            samples: raw_m.len(),
            raw_rms_m: deviation(&raw_m),
            calibrated_rms_m: deviation(&calibrated_m),
        })
    }
}

pub(super) fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (count, sum) = values.fold((0_u64, 0.0), |(count, sum), value| {
        (count + 1, sum + value * value)
    });
    (sum / count as f64).sqrt()
}

/// Root mean square about the mean.
pub(super) fn deviation(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    rms(values.iter().map(|value| value - mean))
}
