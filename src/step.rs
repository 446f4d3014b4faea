//! One sample: raw counts in, corrected frame out. Pure, f32, no allocation, no panic, no loop without a bound.
//!
//! Order of work: pairs to phases, tooth counts, error model (equations 3 and 9 dense, further rows if there are any),
//! pose and parity (equations 4 and 5), electrodes, status. The same bits on host and target.

use crate::frame::{Coordinate, Frame, Pose, RawFrame, SEGMENTS, Status};
use crate::lanes::Lanes;
use crate::math;
use crate::model::{
    Basis, CompiledModel, ErrorModel, Further, Observation, OwnPolynomial, Unit, lateral_units,
    mean_angle_turns,
};
use crate::psd::{self, BeaconLimits};
use crate::quadrature::{self, CompiledPair, CounterLimits, Counters, PairCorrection, above};
use crate::settings::{ConfigError, Settings};
use core::sync::atomic::{Ordering, compiler_fence};

/// [`Settings`] in machine units: all the interrupt reads. About 1.3 KiB.
#[derive(Clone, Debug, PartialEq)]
pub struct StepConfig {
    /// Segments 1 and 3, 2 and 4.
    pairs: [(CompiledPair, OwnPolynomial); 2],
    counter: CounterLimits,
    /// Bits of the limits of the squared amplitude.
    square_low: u32,
    square_high: u32,
    /// Largest square of a count that is not clipped.
    clip_square: i32,
    dead_band_m_s: f32,
    parity_turns: f32,
    gap_samples: f32,
    /// Samples in a window less one, and their logarithm; 2^31 for never.
    frozen_mask: u32,
    frozen_shift: u32,
    /// [`Status::FROZEN`], or nothing if that is switched off.
    frozen_bit: u32,
    beacon: BeaconLimits,
    tan_full_scale: f32,
    pitch_m: f32,
    pitch_over_span: f32,
    lateral_over_span: f32,
    /// Whether a sample needs more than equations (3) and (9).
    extended: bool,
    /// Bits that every frame has.
    standing_bits: u32,
    further: Further,
}

impl StepConfig {
    /// Checks settings and converts them.
    ///
    /// # Errors
    /// The first setting that is out of range; nothing the interrupt computes with can then overflow.
    pub fn build(settings: &Settings) -> Result<Self, ConfigError> {
        settings.validate()?;
        let (geometry, limits) = (&settings.geometry, &settings.limits);
        let speed_m_s = geometry.pitch_m * settings.rate_hz;
        let none = ErrorModel::default();
        let model = CompiledModel::new(settings.model.as_ref().unwrap_or(&none), geometry.pitch_m);
        let directions = settings.track_direction || model.further.has_extra();
        let pair = |p: usize| PairCorrection::compile([&settings.pairs[p], &settings.pairs[p + 2]]);
        let frozen_shift = limits
            .frozen_samples
            .checked_ilog2()
            .map_or(31, |log| log - 2);
        let square_bits = |amplitude: f32| (amplitude * amplitude).to_bits();
        let standing = if settings.model.is_some() {
            Status::empty()
        } else {
            Status::UNCALIBRATED
        };
        Ok(Self {
            pairs: [(pair(0), model.own[0]), (pair(1), model.own[1])],
            counter: CounterLimits {
                slip: limits.slip_turns,
                turns_per_m_s: 1.0 / speed_m_s,
                speed_filter: 0.5 * limits.speed_filter * speed_m_s,
            },
            square_low: square_bits(limits.amplitude_low_counts),
            square_high: square_bits(limits.amplitude_high_counts),
            clip_square: i32::from(limits.clip_counts) * i32::from(limits.clip_counts) - 1,
            dead_band_m_s: limits.direction_dead_band_m_s,
            parity_turns: limits.parity_turns,
            gap_samples: f32::from(limits.gap_samples),
            frozen_mask: (1 << frozen_shift) - 1,
            frozen_shift,
            frozen_bit: if limits.frozen_samples == 0 {
                0
            } else {
                Status::FROZEN.bits()
            },
            beacon: limits.beacon,
            standing_bits: standing.bits(),
            extended: directions || model.further.has_extra(),
            further: model.further,
            tan_full_scale: geometry.tan_full_scale,
            pitch_m: geometry.pitch_m,
            pitch_over_span: geometry.pitch_m / geometry.span_m,
            lateral_over_span: geometry.lateral_m / geometry.span_m,
        })
    }
}

/// What one sample leaves to the next: the last frame, and what no frame shows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StepState {
    frame: Frame,
    /// Samples since the last good one.
    missed: f32,
    /// The counts of the segment that is watched for frozen channels, at the last sample.
    watched: u32,
    /// Which of their bits have changed since the window began.
    changed: u32,
    /// In which of the last four windows a channel stood still, as bits.
    still: u32,
    /// [`Status::FROZEN`] or nothing.
    frozen: u32,
    /// Latched slip bits.
    slips: u32,
    sequence: u32,
    started: bool,
}

impl StepState {
    /// Before the first sample. That sets the tooth counts: 0 for segments 1 and 2, their neighbours' within half a tooth.
    pub fn new() -> Self {
        Self::default()
    }

    /// The last frame.
    pub fn frame(&self) -> &Frame {
        &self.frame
    }

    /// Where the next sample's counts go before [`isr_step`]: the driver's place to write to.
    pub fn raw_mut(&mut self) -> &mut RawFrame {
        &mut self.frame.raw
    }

    /// Takes back the latched slip bits, once the pose is known again.
    pub fn clear_slips(&mut self) {
        self.slips = 0;
    }

    /// Sets the tooth counts, e.g. to those of a known place, and clears the slip bits.
    pub fn set_teeth(&mut self, teeth: [i32; SEGMENTS]) {
        for (segment, teeth) in self.frame.segments.iter_mut().zip(teeth) {
            segment.unmodified.teeth = teeth;
        }
        self.slips = 0;
    }

    /// Counts again from the next sample as after start-up; the sequence number goes on.
    pub fn restart_count(&mut self) {
        self.started = false;
        self.slips = 0;
    }
}

/// One sample: `raw` into the state, [`isr_step`], and a copy of its frame.
pub fn step(config: &StepConfig, state: &mut StepState, raw: &RawFrame) -> Frame {
    let kept = &mut state.frame.raw;
    if raw.fault.intersects(STALE) && state.started {
        kept.fault = raw.fault;
        kept.temperature_delta_k = raw.temperature_delta_k;
    } else {
        *kept = *raw;
    }
    *isr_step(config, state)
}

/// Faults with which the counts are not this instant's.
const STALE: Status = Status::CONVERTER_CRC.union(Status::CONVERTER_TIMEOUT);

/// One sample from the counts in [`StepState::raw_mut`], the frame written in place. With a converter's fault bit set the
/// counts there must be the previous ones. Cost: docs/costs.md.
pub fn isr_step<'s>(config: &StepConfig, state: &'s mut StepState) -> &'s Frame {
    if !state.started {
        start(config, state);
    }
    if config.further.has_lateral {
        sample::<true>(config, state)
    } else {
        sample::<false>(config, state)
    }
    &state.frame
}

/// Sets the tooth counts so that the first sample continues them.
#[cold]
#[inline(never)]
fn start(config: &StepConfig, state: &mut StepState) {
    let raw = state.frame.raw;
    let first = |i: usize| {
        let counts = [
            raw.quadrature_counts[i & 1],
            raw.quadrature_counts[i & 1 | 2],
        ];
        quadrature::interpolate(&config.pairs[i & 1].0, counts)
            .turns
            .0[i >> 1 & 1]
    };
    for (i, segment) in state.frame.segments.iter_mut().enumerate() {
        let turns = first(i);
        let teeth = math::round(first(i & 1) - turns).1;
        segment.unmodified = Coordinate {
            teeth,
            fraction_turns: turns,
        };
    }
    state.frame.speed_m_s = [0.0; 2];
    state.frame.direction = [0.0; 2];
    state.missed = 0.0;
    state.changed = u32::MAX;
    state.still = 0;
    state.frozen = 0;
    state.started = true;
}

/// One sample, with or without the lateral terms of equation (9).
#[inline(never)]
fn sample<const LATERAL: bool>(config: &StepConfig, state: &mut StepState) {
    let fault = state.frame.raw.fault;
    let mut elapsed = state.missed + 1.0;
    let mut missed = 0.0;
    if fault.intersects(STALE) {
        (elapsed, missed) = (0.0, elapsed);
        state.slips |= if missed > config.gap_samples {
            SLIPS
        } else {
            0
        };
    }
    state.missed = missed;
    watch_frozen(config, state);
    let standing = fault.bits() | config.standing_bits | state.slips | state.frozen;
    let frame = &mut state.frame;
    frame.status = Status::from_bits_retain(standing);
    if above(
        frame.raw.temperature_delta_k.to_bits(),
        TEMPERATURE_LIMIT_K.to_bits(),
    ) != 0
    {
        refuse_temperature(frame);
    }
    let x = measure::<0>(config, frame, elapsed);
    let x_corrected = correct::<0>(frame, x.turns + x.error);
    keep_order();
    let y = measure::<1>(config, frame, elapsed);
    let mut pairs = [x_corrected, correct::<1>(frame, y.turns + y.error)];
    keep_order();
    if LATERAL {
        pairs = correct_laterally(config, frame, &x, &y);
    }
    if config.extended {
        pairs = correct_further(config, frame);
    }
    let parity_turns = pose(config, frame, &pairs);
    keep_order();
    let deflection = psd::deflection(
        &config.beacon,
        config.tan_full_scale,
        frame.raw.electrode_counts,
    );
    frame.tan_psi = deflection.tan_psi;
    let parity = above(parity_turns.to_bits(), config.parity_turns.to_bits());
    let bits = frame.status.bits() | deflection.bits | (parity & Status::PARITY.bits());
    frame.status = Status::from_bits_retain(bits);
    frame.sequence = state.sequence;
    state.slips = bits & SLIPS;
    state.sequence = state.sequence.wrapping_add(1);
}

/// All slip bits.
const SLIPS: u32 = 0b1111 * Status::SLIP_1.bits();

/// Largest difference of temperature that is believed.
const TEMPERATURE_LIMIT_K: f32 = 1000.0;

/// Replaces the temperature by zero and says so.
#[cold]
#[inline(never)]
fn refuse_temperature(frame: &mut Frame) {
    frame.raw.temperature_delta_k = 0.0;
    frame.status |= Status::NUMERIC;
}

/// Keeps the compiler from moving loads and stores across: the live values of one part of the work then fit the register
/// file. It is no instruction.
#[inline(always)]
fn keep_order() {
    compiler_fence(Ordering::SeqCst);
}

/// A pair of segments: unit vectors, phases, and equation (3).
#[derive(Clone, Copy)]
struct Measured {
    sine: Lanes,
    cosine: Lanes,
    turns: Lanes,
    error: Lanes,
}

/// Interpolates and counts segments P and P + 2; writes all of their part of the frame but the calibrated outputs.
#[inline(always)]
fn measure<const P: usize>(config: &StepConfig, frame: &mut Frame, elapsed: f32) -> Measured {
    let lanes = [P, P + 2];
    let counts = lanes.map(|i| frame.raw.quadrature_counts[i]);
    let at = quadrature::interpolate(&config.pairs[P].0, counts);
    let doubts = [0, 1].map(|k| doubts(config, at.square[k], counts[k]));
    frame.status |= Status::from_bits_retain((doubts[0] | doubts[1] << 2) << P);
    (0..2).for_each(|k| frame.segments[lanes[k]].amplitude_counts = at.amplitude.0[k]);
    keep_order();
    let error = config.pairs[P].1.errors(at.sine, at.cosine);
    let old = lanes.map(|i| frame.segments[i]);
    let counters = Counters {
        turns: Lanes::new(|k| old[k].unmodified.fraction_turns),
        teeth: [old[0].unmodified.teeth, old[1].unmodified.teeth],
        speed_m_s: frame.speed_m_s[P],
    };
    let (counters, slip) = counters.advance(&config.counter, at.turns, elapsed);
    for (k, i) in lanes.into_iter().enumerate() {
        let segment = &mut frame.segments[i];
        segment.unmodified = Coordinate {
            teeth: counters.teeth[k],
            fraction_turns: at.turns.0[k],
        };
    }
    frame.speed_m_s[P] = counters.speed_m_s;
    let slips = slip[0] & Status::SLIP_1.bits() | slip[1] & Status::SLIP_3.bits();
    frame.status |= Status::from_bits_retain(slips << P);
    Measured {
        sine: at.sine,
        cosine: at.cosine,
        turns: at.turns,
        error,
    }
}

/// Amplitude and clip bits as for segment 1, by the signs of integer differences.
#[inline(always)]
fn doubts(config: &StepConfig, square: u32, counts: [i16; 2]) -> u32 {
    let [s, c] = counts.map(i32::from);
    let low = square.wrapping_sub(config.square_low);
    let high = config.square_high.wrapping_sub(square);
    let clipped = (config.clip_square - s * s) | (config.clip_square - c * c);
    low >> 31 | high >> 31 << 4 | (clipped as u32) >> 31 << 8
}

/// Adds the lateral terms of equation (9).
#[inline(always)]
fn correct_laterally(
    config: &StepConfig,
    frame: &mut Frame,
    x: &Measured,
    y: &Measured,
) -> [Corrected; 2] {
    let unit = |at: &Measured, k: usize| Unit {
        sine: at.sine.0[k],
        cosine: at.cosine.0[k],
    };
    let own = [unit(x, 0), unit(y, 0), unit(x, 1), unit(y, 1)];
    let angle = mean_angle_turns(&frame.segments.map(|s| s.unmodified));
    let lateral = lateral_units(&own, angle * config.lateral_over_span);
    let coefficients = &config.further.lateral;
    let error =
        |i: usize| coefficients[i][0] * lateral[i].sine + coefficients[i][1] * lateral[i].cosine;
    let sum = |i: usize| frame.segments[i].calibrated.fraction_turns + error(i);
    let sums = [Lanes([sum(0), sum(2)]), Lanes([sum(1), sum(3)])];
    [correct::<0>(frame, sums[0]), correct::<1>(frame, sums[1])]
}

/// Keeps the directions of travel and adds the model's further rows. A sum of these that is not within half a pitch is
/// left out and reported.
#[inline(never)]
fn correct_further(config: &StepConfig, frame: &mut Frame) -> [Corrected; 2] {
    for (direction, speed_m_s) in frame.direction.iter_mut().zip(frame.speed_m_s) {
        *direction = quadrature::direction(*direction, speed_m_s, config.dead_band_m_s);
    }
    let seen = Observation::from(&*frame);
    let basis = Basis::with_ratios(config.pitch_over_span, config.lateral_over_span, &seen);
    let errors = config.further.extra_errors(&basis);
    let mut sums = [0.0; SEGMENTS];
    for i in 0..SEGMENTS {
        let wrong = above(errors[i].to_bits(), 0.5_f32.to_bits());
        frame.status |= Status::from_bits_retain(wrong & Status::NUMERIC.bits());
        sums[i] = frame.segments[i].calibrated.fraction_turns
            + f32::from_bits(errors[i].to_bits() & !wrong);
    }
    [
        correct::<0>(frame, Lanes([sums[0], sums[2]])),
        correct::<1>(frame, Lanes([sums[1], sums[3]])),
    ]
}

/// A pair's calibrated outputs: middle and difference.
#[derive(Clone, Copy, Default)]
struct Corrected {
    mean: Coordinate,
    across_turns: f32,
}

/// Writes the calibrated outputs of segments p and p + 2.
#[inline(always)]
fn correct<const P: usize>(frame: &mut Frame, calibrated: Lanes) -> Corrected {
    let [a, b] = [0, 1].map(|k| {
        let segment = &mut frame.segments[P + 2 * k];
        segment.calibrated = Coordinate {
            teeth: segment.unmodified.teeth,
            fraction_turns: calibrated.0[k],
        };
        segment.calibrated
    });
    Corrected {
        mean: a.mean(b),
        across_turns: a.minus_turns(b),
    }
}

/// Equations (4) and (5); returns g_p in turns.
#[inline(always)]
fn pose(config: &StepConfig, frame: &mut Frame, [x, y]: &[Corrected; 2]) -> f32 {
    let theta = Lanes([x.across_turns, y.across_turns]) * config.pitch_over_span;
    let parity_turns = x.across_turns - y.across_turns;
    frame.pose = Pose {
        x: x.mean,
        y: y.mean,
        theta_x_rad: theta.0[0],
        theta_y_rad: theta.0[1],
        theta_rad: 0.5 * (theta.0[0] + theta.0[1]),
    };
    frame.parity_m = parity_turns * config.pitch_m;
    parity_turns
}

/// Watches one segment for a window of samples, then the next: which bits of its counts change.
#[inline(always)]
fn watch_frozen(config: &StepConfig, state: &mut StepState) {
    let i = (state.sequence >> config.frozen_shift & 3) as usize;
    let counts = word(state.frame.raw.quadrature_counts[i]);
    let changed = state.changed | (counts ^ state.watched);
    state.watched = counts;
    if state.sequence & config.frozen_mask == 0 {
        judge_frozen(config, state);
    } else {
        state.changed = changed;
    }
}

/// At a window's first sample: judges the last one. The converter is frozen while in any of the last four windows a
/// channel did not change at all.
#[inline(always)]
fn judge_frozen(config: &StepConfig, state: &mut StepState) {
    let still = state.changed & 0xFFFF == 0 || state.changed >> 16 == 0;
    state.still = (state.still << 1 | u32::from(still)) & 0b1111;
    state.frozen = if state.still == 0 {
        0
    } else {
        config.frozen_bit
    };
    state.changed = 0;
}

#[inline(always)]
fn word(counts: [i16; 2]) -> u32 {
    u32::from(counts[0] as u16) | u32::from(counts[1] as u16) << 16
}
