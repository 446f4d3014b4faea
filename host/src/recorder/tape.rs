//! A recording under way: what the board sends becomes rows.

use super::measured::{ADC_BITS, Measured};
use crate::board::{Link, geometry};
use anyhow::Result;
use courier_sensor::frame::{Coordinate, Status};
use courier_sensor::geometry::Geometry;
use courier_sensor::link::message::BoardStatus;
use courier_sensor::link::telemetry::Sample;
use hal_sim::world::World;
use recording::noise::at_rest::Noise;
use recording::{Coordination, Electronics, Meta, Names, Recording, Row, Writer};
use std::f64::consts::TAU;

/// What a recording of the board states: the geometry of the calibration in force; without one, the firmware's own.
pub fn meta(link: &mut Link) -> Meta {
    let geometry = geometry::in_force(link).unwrap_or(Geometry::PAPER);
    let hello = link.hello();
    Meta {
        device: format!("{} board {}", hello.board, hello.device),
        source: format!(
            "courier record, firmware {}; amplitudes measured from the recording, noise at rest before it",
            hello.firmware
        ),
        names: Names {
            courier_id: hello.device.to_string(),
            firmware: hello.firmware.to_string(),
            ..Names::default()
        },
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
pub(super) struct Logged {
    pub(super) name: &'static str,
    world: World,
}

impl Logged {
    pub(super) fn new(world: &World) -> Option<Self> {
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
pub(super) struct Tape {
    pub(super) writer: Writer,
    /// The same samples, to be looked at meanwhile; none where nobody does.
    pub(super) seen: Recording,
    pub(super) is_watched: bool,
    /// What the machine logged beside them.
    pub(super) beside: Vec<f64>,
    pub(super) logged: Option<Logged>,
    pub(super) decimation: u16,
    pub(super) run: String,
    pub(super) rate_hz: f64,
    pub(super) status: BoardStatus,
    pub(super) measured: Measured,
    pub(super) noise: Noise,
    pub(super) samples: u32,
    pub(super) first: Option<u32>,
    pub(super) temperature_0_k: Option<f32>,
}

impl Tape {
    pub(super) fn take(&mut self, sample: &Sample) -> Result<()> {
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
        if self.is_watched {
            self.seen.samples.push(&row_of_run);
            self.beside.extend(beside);
        }
        self.measured.add(&row);
        self.samples += 1;
        Ok(())
    }

    /// States what was measured.
    pub(super) fn state(&self, meta: &mut Meta) {
        let electronics = self.measured.electronics(&self.noise);
        if electronics.psd_sum_counts.is_none() {
            meta.coordination = None;
        }
        meta.electronics = electronics;
    }

    pub(super) fn finish(mut self) -> Result<()> {
        let mut meta = self.writer.meta_mut().clone();
        self.state(&mut meta);
        *self.writer.meta_mut() = meta;
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
