//! A recording from a board's telemetry.

use crate::board::{Link, motion};
use crate::destination::Destination;
use anyhow::{Result, bail};
use courier_sensor::app::background::SELF_MOTION_M_PER_S;
use courier_sensor::drivers::motion::Target;
use courier_sensor::frame::{Coordinate, SEGMENTS, Status};
use courier_sensor::geometry::Geometry;
use courier_sensor::link::message::{Action, BoardStatus, Reply, Source};
use courier_sensor::link::telemetry::{Channels, Sample, StreamOrder};
use indicatif::ProgressBar;
use recording::{Coordination, Electronics, Meta, Row, Writer};
use serde::Serialize;
use std::f64::consts::TAU;
use std::time::Duration;

/// What to record.
#[derive(Clone, Debug)]
pub struct Order {
    /// Where to.
    pub to: Destination,
    /// One sample in so many.
    pub decimation: u16,
    /// One after the other.
    pub runs: Vec<Run>,
}

/// One motion and its samples.
#[derive(Clone, Debug)]
pub struct Run {
    /// Name of the motion.
    pub name: String,
    /// Where it starts; none: where the courier is.
    pub from: Option<Target>,
    /// Where it goes, and how fast, m/s; none: it stands, or others move it.
    pub to: Option<(Target, f32)>,
    /// How long, s.
    pub seconds: f64,
}

/// What was recorded.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Recorded {
    /// Samples in the recording.
    pub samples: u32,
    /// Samples that should be in it and are not: the link or the board was too slow for them.
    pub lost: u32,
}

/// Time between two looks at the channel: a fifth of what the board's buffer holds at 20 kHz.
const LOOK: Duration = Duration::from_millis(1);
/// Looks without any sample after which the rest is given up.
const PATIENCE_LOOKS: u32 = 2000;
/// Bits of the board's converters.
const ADC_BITS: u32 = 16;

/// Records.
///
/// # Errors
/// The board cannot be reached or refuses; the folder cannot be written, and then nothing is left of it.
pub fn record(link: &mut Link, order: &Order, progress: &ProgressBar) -> Result<Recorded> {
    let Reply::Status(status) = link.ask(Action::Status)? else {
        bail!("the board: wanted a status")
    };
    let rate_hz = f64::from(link.hello().rate_hz);
    let wanted = |run: &Run| {
        (run.seconds * rate_hz / f64::from(order.decimation))
            .ceil()
            .max(2.0) as u32
    };
    let meta = meta(link);
    let mut tape = Tape {
        writer: order.to.create(&meta)?,
        decimation: order.decimation,
        run: String::new(),
        rate_hz,
        status,
        measured: Measured::default(),
        samples: 0,
        first: None,
        temperature_0_k: None,
    };
    let all = order.runs.iter().map(wanted).sum::<u32>();
    progress.set_length(u64::from(all));
    for run in &order.runs {
        tape.run.clone_from(&run.name);
        take_run(link, run, wanted(run), &mut tape, progress)?;
    }
    progress.finish_and_clear();
    let recorded = Recorded {
        samples: tape.samples,
        lost: all - tape.samples.min(all),
    };
    tape.finish()?;
    Ok(recorded)
}

/// Goes to where the run starts, and keeps `wanted` samples from the moment at which its motion begins.
fn take_run(
    link: &mut Link,
    run: &Run,
    wanted: u32,
    tape: &mut Tape,
    progress: &ProgressBar,
) -> Result<()> {
    if let Some(from) = run.from {
        motion::go(link, from, SELF_MOTION_M_PER_S)?;
    }
    link.drop_samples()?;
    let before = tape.samples;
    let channels = Channels::STATUS | Channels::RAW | Channels::UNMODIFIED | Channels::TEMPERATURE;
    ask(
        link,
        Action::Stream(StreamOrder {
            channels: channels.bits(),
            decimation: tape.decimation,
            samples: wanted,
        }),
    )?;
    if let Some((target, speed_m_per_s)) = run.to {
        motion::start(link, target, speed_m_per_s)?;
    }
    let mut silent = 0;
    while tape.samples - before + link.lost() < wanted && silent < PATIENCE_LOOKS {
        let seen = tape.samples;
        link.pass(LOOK)?;
        link.listen(|sample| tape.take(sample))?;
        silent = if tape.samples == seen { silent + 1 } else { 0 };
        progress.set_position(u64::from(tape.samples));
    }
    ask(link, Action::Stream(StreamOrder::default()))
}

fn ask(link: &mut Link, action: Action) -> Result<()> {
    let Reply::Done = link.ask(action)? else {
        bail!("the board: wanted a plain yes")
    };
    Ok(())
}

/// Geometry of the calibration in force; without one, the firmware's own.
fn meta(link: &mut Link) -> Meta {
    let geometry = match link.ask(Action::Read(Source::InForce)) {
        Ok(Reply::Calibration(calibration)) => calibration.geometry,
        _ => Geometry::PAPER,
    };
    let hello = link.hello();
    Meta {
        device: format!("{} board {}", hello.board, hello.device),
        source: format!(
            "courier record, firmware {}; amplitudes and noise measured from the recording",
            hello.firmware
        ),
        geometry: recording::Geometry {
            pitch_m: shortest(geometry.pitch_m),
            span_m: Some(shortest(geometry.span_m)),
            lateral_m: Some(shortest(geometry.lateral_m)),
        },
        coordination: Some(Coordination {
            height_m: shortest(geometry.height_m),
            lever_x_m: shortest(geometry.lever_m[0]),
            lever_y_m: shortest(geometry.lever_m[1]),
            tan_full_scale: shortest(geometry.tan_full_scale),
        }),
        electronics: Electronics {
            adc_bits: Some(ADC_BITS),
            ..Electronics::default()
        },
    }
}

/// The f64 of the shortest decimal that is this f32: 1.016e-3 and not 1.0160000529140234e-3.
fn shortest(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(f64::from(value))
}

/// A recording under way.
struct Tape {
    writer: Writer,
    decimation: u16,
    run: String,
    rate_hz: f64,
    status: BoardStatus,
    measured: Measured,
    samples: u32,
    first: Option<u32>,
    temperature_0_k: Option<f32>,
}

impl Tape {
    fn take(&mut self, sample: &Sample) -> Result<()> {
        let (Some((pairs, electrodes)), Some(outputs)) = (sample.raw, sample.unmodified) else {
            return Ok(());
        };
        let first = *self.first.get_or_insert(sample.sequence);
        let beacon = !sample
            .status
            .unwrap_or_default()
            .contains(Status::BEACON_MISSING);
        let delta_k = sample.temperature_delta_k.unwrap_or_default();
        let delta_0_k = *self.temperature_0_k.get_or_insert(delta_k);
        let quadrature = pairs.map(|pair| pair.map(f64::from));
        let electrode_counts = beacon.then(|| electrodes.map(f64::from));
        self.writer.push(&Row {
            t_s: f64::from(sample.sequence.wrapping_sub(first)) / self.rate_hz,
            run: &self.run,
            quadrature_counts: quadrature.map(Some),
            teeth: std::array::from_fn(|segment| {
                Some(teeth(outputs[segment], quadrature[segment]))
            }),
            electrode_counts,
            temperature_c: self
                .status
                .temperature_c
                .map(|start_c| f64::from(start_c + delta_k - delta_0_k)),
            ..Row::default()
        })?;
        self.measured.add(
            sample.sequence,
            u32::from(self.decimation),
            &quadrature,
            electrode_counts,
        );
        self.samples += 1;
        Ok(())
    }

    fn finish(mut self) -> Result<()> {
        let electronics = self.measured.electronics();
        let meta = self.writer.meta_mut();
        if electronics.psd_sum_counts.is_none() {
            meta.coordination = None;
        }
        meta.electronics = electronics;
        Ok(self.writer.finish()?)
    }
}

/// Tooth count that belongs to the counts as they are, whatever the firmware corrects in the pair.
fn teeth(output: Coordinate, [sine, cosine]: [f64; 2]) -> i32 {
    let turns = f64::from(output.teeth) + f64::from(output.fraction_turns);
    (turns - sine.atan2(cosine) / TAU).round() as i32
}

/// Amplitudes and noise of what has been recorded.
#[derive(Default)]
struct Measured {
    /// Last four samples that follow each other: counts of all twelve channels, the newest last.
    window: Vec<[f64; 12]>,
    next: u32,
    quadrature: Channel,
    electrodes: Channel,
}

/// Sizes of one kind of channel.
#[derive(Default)]
struct Channel {
    count: u32,
    sum: f64,
    third_differences: Vec<f64>,
}

/// Third differences that are kept of each kind: the median of these is good to a percent.
const DIFFERENCES_KEPT: usize = 100_000;
/// Third differences 1, -3, 3, -1 of white noise are sqrt(20) times its size.
const THIRD_DIFFERENCE_GAIN: f64 = 4.472_135_954_999_58;
/// Gaussian deviation over median absolute value.
const DEVIATION_OVER_MEDIAN: f64 = 1.482_602_218_505_602;
/// Variance of rounding to whole counts, which the layout's noise leaves out.
const ROUNDING_VARIANCE: f64 = 1.0 / 12.0;

impl Measured {
    fn add(
        &mut self,
        sequence: u32,
        step: u32,
        pairs: &[[f64; 2]; SEGMENTS],
        electrodes: Option<[f64; 4]>,
    ) {
        for [sine, cosine] in pairs {
            self.quadrature.sum += sine.hypot(*cosine);
            self.quadrature.count += 1;
        }
        if let Some([xp, xn, yp, yn]) = electrodes {
            self.electrodes.sum += xp + xn + yp + yn;
            self.electrodes.count += 2;
        }
        if sequence != self.next {
            self.window.clear();
        }
        self.next = sequence.wrapping_add(step);
        let mut counts = [f64::NAN; 12];
        counts
            .iter_mut()
            .zip(pairs.iter().flatten())
            .for_each(|(place, count)| *place = *count);
        counts[8..].copy_from_slice(&electrodes.unwrap_or([f64::NAN; 4]));
        self.window.push(counts);
        if let [a, b, c, d] = self.window[..] {
            for channel in 0..12 {
                let difference = d[channel] - 3.0 * c[channel] + 3.0 * b[channel] - a[channel];
                let kind = if channel < 8 {
                    &mut self.quadrature
                } else {
                    &mut self.electrodes
                };
                if difference.is_finite() && kind.third_differences.len() < DIFFERENCES_KEPT {
                    kind.third_differences.push(difference.abs());
                }
            }
            self.window.remove(0);
        }
    }

    fn electronics(mut self) -> Electronics {
        Electronics {
            adc_bits: Some(ADC_BITS),
            amplitude_counts: self.quadrature.mean(),
            quadrature_noise_counts: Some(self.quadrature.noise()),
            psd_sum_counts: self.electrodes.mean(),
            psd_noise_counts: self.electrodes.mean().map(|_| self.electrodes.noise()),
            position_noise_m: None,
        }
    }
}

impl Channel {
    fn mean(&self) -> Option<f64> {
        (self.count > 0).then(|| (self.sum / f64::from(self.count)).round())
    }

    fn noise(&mut self) -> f64 {
        let middle = self.third_differences.len() / 2;
        if self.third_differences.is_empty() {
            return 0.0;
        }
        let median = *self
            .third_differences
            .select_nth_unstable_by(middle, f64::total_cmp)
            .1;
        let deviation = DEVIATION_OVER_MEDIAN * median / THIRD_DIFFERENCE_GAIN;
        let noise = (deviation * deviation - ROUNDING_VARIANCE).max(0.0).sqrt();
        (noise * 100.0).round() / 100.0
    }
}
