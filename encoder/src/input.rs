//! What is learned from: one segment of a recording, cut where its motion is interrupted.

use crate::asked::Refusal;
use courier_signal::encoder::{Encoder, EncoderConfig, Harmonics};
use courier_signal::model::Unit;
use courier_signal::quadrature::PairCorrection;
use recording::{INDEX, Recording};
use std::ops::Range;

/// A gap of over this many usual intervals ends a piece. A prior: one or two lost samples do not, a pause of the log does.
const GAP_INTERVALS: f64 = 5.0;
/// Largest change of a step, periods. Derived from the nearest: from half a period on either way round is as near, so the count
/// is not sure, or the place begins anew.
const JUMP_TURNS: f64 = 0.5;
/// Largest count. Derived from the signal path's i16, 32,767 at most: larger ones are scaled to it.
const LARGEST_COUNT: f64 = 32_000.0;
/// What the device's signal path is told beside the pair. By definition without effect: only its count of periods and its speed
/// depend on them, and neither is used here, since the recording has counted already.
const SLIP_TURNS: f32 = 0.4;
/// See [`SLIP_TURNS`].
const SPEED_FILTER: f32 = 0.25;

/// One segment's samples.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Input {
    /// Times, s.
    pub t_s: Vec<f64>,
    /// Unmodified places, periods of the signal.
    pub place: Vec<f64>,
    /// `[sine, cosine]`, counts; empty where only places were logged.
    pub counts: Vec<[f64; 2]>,
    /// Level of the index in any unit, NaN where it was not measured; empty where there is none.
    pub index: Vec<f64>,
    /// Length of a period, m.
    pub pitch_m: f64,
    /// How the counts came from the log's values.
    pub unit: LogUnit,
}

/// `counts = (value - centre) * scale`, of values in the log's own unit.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct LogUnit {
    /// Of sine and cosine.
    pub centre: [f64; 2],
    /// Counts per unit.
    pub scale: f64,
}

impl Default for LogUnit {
    fn default() -> Self {
        Self {
            centre: [0.0; 2],
            scale: 1.0,
        }
    }
}

impl Input {
    /// Segment `segment` (0 to 3) of a recording; samples in which it was not measured are left out. None if it never was.
    #[must_use]
    pub fn of(recording: &Recording, segment: usize) -> Option<Self> {
        let samples = &recording.samples;
        if !samples.has_segment(segment) {
            return None;
        }
        let pitch_m = recording.meta.geometry.pitch_m;
        let by_counts =
            (0..samples.len()).any(|row| samples.quadrature_counts(segment, row).is_some());
        let mut logged = samples.logged().iter();
        let index = logged.find(|logged| logged.name == INDEX);
        let mut input = Self {
            pitch_m,
            ..Self::default()
        };
        for row in 0..samples.len() {
            let counts = samples.quadrature_counts(segment, row);
            if by_counts && counts.is_none() {
                continue;
            }
            if let Some(place_m) = samples.unmodified_m(segment, row, pitch_m) {
                input.t_s.push(samples.t_s()[row]);
                input.place.push(place_m / pitch_m);
                input.counts.extend(counts);
                input.index.extend(index.map(|index| index.values[row]));
            }
        }
        Some(input)
    }

    /// Counts of the recording over those of the signal path: 1 unless they are too large for it.
    #[must_use]
    pub fn scale(&self) -> f64 {
        let counts = self.counts.iter().flatten();
        let largest = counts.fold(0.0_f64, |largest, count| largest.max(count.abs()));
        (largest / LARGEST_COUNT).max(1.0)
    }

    /// Phases and places with a correction of the pair, by the device's own signal path.
    pub(crate) fn phases(&self, pair: Option<&PairCorrection>) -> Result<Phases, Refusal> {
        let pieces = pieces(&self.t_s, &self.place);
        let samples = match pair {
            None => self.place.iter().map(|place| Sample::at(*place)).collect(),
            Some(pair) => self.corrected(pair)?,
        };
        Ok(Phases {
            t_s: self.t_s.clone(),
            samples,
            pieces,
        })
    }

    fn corrected(&self, pair: &PairCorrection) -> Result<Vec<Sample>, Refusal> {
        let config = EncoderConfig::new(pair, &Harmonics::default(), SLIP_TURNS, SPEED_FILTER)
            .map_err(|error| Refusal::Pair(error.to_string()))?;
        let (mut encoder, scale) = (Encoder::new(config), self.scale());
        let sample = |(counts, place): (&[f64; 2], &f64)| {
            let reading = encoder.step(counts.map(|count| (count / scale).round() as i16));
            let turns = f64::from(reading.unmodified_turns);
            // The whole periods are the recording's: the phase moves by less than half a period.
            let moved = turns - place;
            Sample {
                place: place + moved - moved.round(),
                phase: reading.phase,
                amplitude: f64::from(reading.amplitude_counts),
                reading: Some(reading),
            }
        };
        Ok(self.counts.iter().zip(&self.place).map(sample).collect())
    }
}

/// One sample of the pair.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    /// Periods.
    pub place: f64,
    pub phase: Unit,
    /// Counts of the signal path; 0 where only places were logged.
    pub amplitude: f64,
    pub reading: Option<courier_signal::encoder::Reading>,
}

impl Sample {
    fn at(place: f64) -> Self {
        Self {
            place,
            phase: Unit::from_turns((place - place.round()) as f32),
            amplitude: 0.0,
            reading: None,
        }
    }
}

/// The samples with a correction of the pair in force.
#[derive(Clone, Debug)]
pub(crate) struct Phases {
    pub t_s: Vec<f64>,
    pub samples: Vec<Sample>,
    /// Samples that follow each other without a break.
    pub pieces: Vec<Range<usize>>,
}

impl Phases {
    /// With the harmonics added to the places.
    pub fn calibrated(&self, harmonics: &[[f64; 2]]) -> Self {
        let mut calibrated = self.clone();
        for sample in &mut calibrated.samples {
            sample.place += error(harmonics, sample.place);
        }
        calibrated
    }
}

/// The sum of harmonics at a place, periods.
pub(crate) fn error(harmonics: &[[f64; 2]], place: f64) -> f64 {
    let phase = std::f64::consts::TAU * (place - place.round());
    let terms = harmonics.iter().zip(1..);
    terms
        .map(|([a, b], order)| {
            let (sine, cosine) = (phase * f64::from(order)).sin_cos();
            a * sine + b * cosine
        })
        .sum()
}

/// Where samples follow each other: no gap in time, no jump of the place.
fn pieces(t_s: &[f64], place: &[f64]) -> Vec<Range<usize>> {
    let mut steps: Vec<f64> = t_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let middle = steps.len() / 2;
    if steps.is_empty() {
        return Vec::new();
    }
    let usual = *steps.select_nth_unstable_by(middle, f64::total_cmp).1;
    let (mut pieces, mut start) = (Vec::new(), 0);
    let mut last = None::<f64>;
    for row in 1..t_s.len() {
        let step = place[row] - place[row - 1];
        let jumps = (step - last.unwrap_or(step)).abs() > JUMP_TURNS;
        last = Some(step);
        if t_s[row] - t_s[row - 1] > GAP_INTERVALS * usual || jumps {
            pieces.push(start..row);
            (start, last) = (row, None);
        }
    }
    pieces.push(start..t_s.len());
    pieces
}
