//! A recording from a board's telemetry.

use crate::board::{Link, motion};
use crate::destination::Destination;
use crate::interrupt;
use anyhow::{Context, Result, bail};
use courier_sensor::app::background::SELF_MOTION_M_PER_S;
use courier_sensor::drivers::motion::Target;
use courier_sensor::frame::{Coordinate, Status};
use courier_sensor::geometry::Geometry;
use courier_sensor::link::message::{Action, BoardStatus, Reply, Source};
use courier_sensor::link::telemetry::{Channels, Sample, StreamOrder};
use hal_sim::world::World;
use indicatif::ProgressBar;
use recording::noise::at_rest::{self, CHANNELS, Noise, Reading, Unmeasured};
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
    /// Noise of the channels where it is known; none: measured before the first run, while the courier rests.
    pub noise: Option<Noise>,
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
    /// Noise that the recording states.
    #[serde(skip)]
    pub noise: Noise,
}

/// Time between two looks at the channel: a fifth of what the board's buffer holds at 20 kHz.
const LOOK: Duration = Duration::from_millis(1);
/// Looks without any sample after which the rest is given up.
const PATIENCE_LOOKS: u32 = 2000;
/// Bits of the board's converters.
const ADC_BITS: u32 = 16;
/// Time over which the noise is measured, s: at 20 kHz it is then known to half a percent.
const NOISE_S: f64 = 0.5;
/// One sample in so many for it: the first with which the link keeps up.
const NOISE_DECIMATIONS: [u16; 5] = [1, 2, 4, 8, 16];
/// What a recording and the measurement of its noise need of each sample.
pub const WANTED: Channels = Channels::STATUS
    .union(Channels::RAW)
    .union(Channels::UNMODIFIED)
    .union(Channels::TEMPERATURE);

/// Records. `world` is what is around a simulated board: what its machine logs beside the readings stands in the recording as well.
///
/// # Errors
/// The board cannot be reached or refuses; the noise cannot be measured; the folder cannot be written. Nothing is left of it then.
pub fn record(
    link: &mut Link,
    world: Option<&World>,
    order: &Order,
    progress: &ProgressBar,
) -> Result<Recorded> {
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
    let logged = world.and_then(Logged::new);
    let names: Vec<&str> = logged.iter().map(|logged| logged.name).collect();
    let mut tape = Tape {
        writer: order.to.create_logging(&meta, &names)?,
        logged,
        decimation: order.decimation,
        run: String::new(),
        rate_hz,
        status,
        measured: Measured::default(),
        noise: Noise::default(),
        samples: 0,
        first: None,
        temperature_0_k: None,
    };
    let all = order.runs.iter().map(wanted).sum::<u32>();
    progress.set_length(u64::from(all));
    tape.noise = match order.noise {
        Some(known) => known,
        None => measure_noise(link, rate_hz)?,
    };
    for run in &order.runs {
        tape.run.clone_from(&run.name);
        take_run(link, run, wanted(run), &mut tape, progress)?;
    }
    progress.finish_and_clear();
    let recorded = Recorded {
        samples: tape.samples,
        lost: all - tape.samples.min(all),
        noise: tape.noise,
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
    let before = tape.samples;
    start(link, tape.decimation, wanted)?;
    if let Some((target, speed_m_per_s)) = run.to {
        motion::start(link, target, speed_m_per_s)?;
    }
    let mut silent = 0;
    while tape.samples - before + link.lost() < wanted && silent < PATIENCE_LOOKS {
        let seen = tape.samples;
        interrupt::check()?;
        link.pass(LOOK)?;
        link.listen(|sample| tape.take(sample))?;
        silent = if tape.samples == seen { silent + 1 } else { 0 };
        progress.set_position(u64::from(tape.samples));
    }
    ask(link, Action::Stream(StreamOrder::default()))
}

/// Starts a stream of so many samples, and forgets those that came before.
fn start(link: &mut Link, decimation: u16, samples: u32) -> Result<()> {
    link.drop_samples()?;
    ask(
        link,
        Action::Stream(StreamOrder {
            channels: WANTED.bits(),
            decimation,
            samples,
        }),
    )
}

/// Noise of the board's channels where the courier stands: at the full rate, or as near to it as the link keeps up.
fn measure_noise(link: &mut Link, rate_hz: f64) -> Result<Noise> {
    motion::rest(link)?;
    let mut found = Err(Unmeasured::Gaps { blocks: 0 });
    for decimation in NOISE_DECIMATIONS {
        let readings = readings(link, decimation, (NOISE_S * rate_hz).ceil() as u32)?;
        found = at_rest::measure(&readings, decimation.into());
        if !matches!(found, Err(Unmeasured::Gaps { .. })) {
            break;
        }
    }
    found.context("noise of the channels (or state it: --noise-counts QUADRATURE,ELECTRODE)")
}

/// So many readings, less those that were lost.
fn readings(link: &mut Link, decimation: u16, wanted: u32) -> Result<Vec<Reading>> {
    start(link, decimation, wanted)?;
    let mut readings = Vec::with_capacity(wanted as usize);
    let mut silent = 0;
    while (readings.len() as u32).saturating_add(link.lost()) < wanted && silent < PATIENCE_LOOKS {
        let seen = readings.len();
        interrupt::check()?;
        link.pass(LOOK)?;
        link.listen(|sample| {
            readings.extend(reading(sample));
            Ok(())
        })?;
        silent = if readings.len() == seen {
            silent + 1
        } else {
            0
        };
    }
    ask(link, Action::Stream(StreamOrder::default()))?;
    Ok(readings)
}

fn reading(sample: &Sample) -> Option<Reading> {
    let ((pairs, electrodes), outputs) = (sample.raw?, sample.unmodified?);
    let mut counts = [0.0; CHANNELS];
    let all = pairs.iter().flatten().chain(&electrodes);
    counts
        .iter_mut()
        .zip(all)
        .for_each(|(place, count)| *place = f64::from(*count));
    Some(Reading {
        sequence: sample.sequence,
        counts,
        position_turns: outputs
            .map(|output| f64::from(output.teeth) + f64::from(output.fraction_turns)),
    })
}

fn ask(link: &mut Link, action: Action) -> Result<()> {
    let Reply::Done = link.ask(action)? else {
        bail!("the board: wanted a plain yes")
    };
    Ok(())
}

/// What a recording of the board states: the geometry of the calibration in force; without one, the firmware's own.
pub fn meta(link: &mut Link) -> Meta {
    let geometry = match link.ask(Action::Read(Source::InForce)) {
        Ok(Reply::Calibration(calibration)) => calibration.geometry,
        _ => Geometry::PAPER,
    };
    let hello = link.hello();
    Meta {
        device: format!("{} board {}", hello.board, hello.device),
        source: format!(
            "courier record, firmware {}; amplitudes measured from the recording, noise at rest before it",
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

/// A quantity that a simulated machine logs beside the readings.
struct Logged {
    name: &'static str,
    world: World,
}

impl Logged {
    fn new(world: &World) -> Option<Self> {
        let [_, last_ns] = world.sampled_ns();
        let (name, _) = world.logged(last_ns)?;
        let world = world.clone();
        Some(Self { name, world })
    }

    /// Its value at a sample of the board.
    fn value(&self, sequence: u32, rate_hz: f64) -> f64 {
        let [first_ns, _] = self.world.sampled_ns();
        let since_ns = f64::from(sequence) / rate_hz * 1.0e9;
        let logged = self.world.logged(first_ns + since_ns as u64);
        logged.map_or(f64::NAN, |(_, value)| value)
    }
}

/// A recording under way.
struct Tape {
    writer: Writer,
    logged: Option<Logged>,
    decimation: u16,
    run: String,
    rate_hz: f64,
    status: BoardStatus,
    measured: Measured,
    noise: Noise,
    samples: u32,
    first: Option<u32>,
    temperature_0_k: Option<f32>,
}

impl Tape {
    fn take(&mut self, sample: &Sample) -> Result<()> {
        let first = *self.first.get_or_insert(sample.sequence);
        let Some(row) = row(sample, first, self.rate_hz) else {
            return Ok(());
        };
        let delta_k = sample.temperature_delta_k.unwrap_or_default();
        let delta_0_k = *self.temperature_0_k.get_or_insert(delta_k);
        let value = |logged: &Logged| logged.value(sample.sequence, self.rate_hz);
        let beside: Vec<f64> = self.logged.iter().map(value).collect();
        let row_of_run = Row {
            run: &self.run,
            temperature_c: self
                .status
                .temperature_c
                .map(|start_c| shortest(start_c + delta_k - delta_0_k)),
            ..row
        };
        self.writer.push_logging(&row_of_run, &beside)?;
        self.measured.add(&row);
        self.samples += 1;
        Ok(())
    }

    fn finish(mut self) -> Result<()> {
        let electronics = self.measured.electronics(&self.noise);
        let meta = self.writer.meta_mut();
        if electronics.psd_sum_counts.is_none() {
            meta.coordination = None;
        }
        meta.electronics = electronics;
        Ok(self.writer.finish()?)
    }
}

/// Raw counts and tooth counts of a sample, without a run's name and temperature; `first` is the sequence number of time zero. None of
/// a sample that holds no raw counts.
pub fn row(sample: &Sample, first: u32, rate_hz: f64) -> Option<Row<'static>> {
    let ((pairs, electrodes), outputs) = (sample.raw?, sample.unmodified?);
    let status = sample.status.unwrap_or_default();
    let beacon = !status.contains(Status::BEACON_MISSING);
    let quadrature = pairs.map(|pair| pair.map(f64::from));
    let counted = |segment: usize| Some(teeth(outputs[segment], quadrature[segment]));
    Some(Row {
        t_s: f64::from(sample.sequence.wrapping_sub(first)) / rate_hz,
        quadrature_counts: quadrature.map(Some),
        teeth: std::array::from_fn(counted),
        electrode_counts: beacon.then(|| electrodes.map(f64::from)),
        ..Row::default()
    })
}

/// Tooth count that belongs to the counts as they are, whatever the firmware corrects in the pair.
fn teeth(output: Coordinate, [sine, cosine]: [f64; 2]) -> i32 {
    let turns = f64::from(output.teeth) + f64::from(output.fraction_turns);
    (turns - sine.atan2(cosine) / TAU).round() as i32
}

/// Amplitudes of what has been recorded.
#[derive(Default)]
struct Measured {
    quadrature: Mean,
    electrodes: Mean,
}

/// A mean under way.
#[derive(Default)]
struct Mean {
    count: u32,
    sum: f64,
}

impl Measured {
    fn add(&mut self, row: &Row) {
        for [sine, cosine] in row.quadrature_counts.into_iter().flatten() {
            self.quadrature.add(sine.hypot(cosine));
        }
        if let Some([xp, xn, yp, yn]) = row.electrode_counts {
            self.electrodes.add(xp + xn);
            self.electrodes.add(yp + yn);
        }
    }

    fn electronics(&self, noise: &Noise) -> Electronics {
        let hundredths = |counts: f64| (counts * 100.0).round() / 100.0;
        let psd_sum_counts = self.electrodes.rounded();
        Electronics {
            adc_bits: Some(ADC_BITS),
            amplitude_counts: self.quadrature.rounded(),
            quadrature_noise_counts: Some(hundredths(noise.quadrature_counts)),
            psd_sum_counts,
            psd_noise_counts: psd_sum_counts.map(|_| hundredths(noise.electrode_counts)),
            position_noise_m: None,
        }
    }
}

impl Mean {
    fn add(&mut self, value: f64) {
        self.sum += value;
        self.count += 1;
    }

    /// To whole counts; none of nothing.
    fn rounded(&self) -> Option<f64> {
        (self.count > 0).then(|| (self.sum / f64::from(self.count)).round())
    }
}
