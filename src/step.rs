//! One sample: raw counts in, corrected frame out. Pure, f32, no allocation, no panic, no loop without a bound.
//!
//! Order of work: pairs to phases, tooth counts, error model (equations 3 and 9 dense, further rows if there are any),
//! pose and parity (equations 4 and 5), electrodes, status. The same bits on host and target.

use crate::frame::{Coordinate, Frame, Pose, RawFrame, SEGMENTS, Status};
use crate::lanes::Lanes;
use crate::math;
use crate::model::{
    Basis, CompiledModel, ErrorModel, Further, OwnPolynomial, Unit, lateral_units, mean_angle_turns,
};
use crate::psd::{self, BeaconLimits};
use crate::quadrature::{
    self, CompiledPair, CounterLimits, Counters, Interpolated, PairCorrection, above,
};
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
    /// Window less one; all ones for never.
    frozen_mask: u32,
    beacon: BeaconLimits,
    tan_full_scale: f32,
    pitch_m: f32,
    pitch_over_span: f32,
    lateral_over_span: f32,
    /// Whether the directions of travel are kept.
    directions: bool,
    /// Whether a sample needs more than equation (3).
    beyond: bool,
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
                speed_filter: limits.speed_filter * speed_m_s,
            },
            square_low: square_bits(limits.amplitude_low_counts),
            square_high: square_bits(limits.amplitude_high_counts),
            clip_square: i32::from(limits.clip_counts) * i32::from(limits.clip_counts) - 1,
            dead_band_m_s: limits.direction_dead_band_m_s,
            parity_turns: limits.parity_turns,
            frozen_mask: u32::from(limits.frozen_samples).wrapping_sub(1),
            beacon: limits.beacon,
            standing_bits: standing.bits(),
            directions,
            beyond: directions || model.further.used,
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
    /// Per segment, the counts that it was last looked at with for frozen channels.
    watched: [u32; SEGMENTS],
    /// Bits of the counts that have changed since the frozen window began.
    changed: [u32; SEGMENTS],
    /// Segments of which a channel did not change in the last window, as bits.
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

/// One sample: [`isr_step`] and a copy of its frame.
#[inline]
pub fn step(config: &StepConfig, state: &mut StepState, raw: &RawFrame) -> Frame {
    *isr_step(config, state, raw)
}

/// One sample, the frame written in place. Cost: docs/costs.md.
#[inline]
pub fn isr_step<'s>(config: &StepConfig, state: &'s mut StepState, raw: &RawFrame) -> &'s Frame {
    if !state.started {
        start(config, state, raw);
    }
    if config.beyond {
        sample::<true>(config, state, raw)
    } else {
        sample::<false>(config, state, raw)
    }
    &state.frame
}

/// Sets the tooth counts so that the first sample continues them.
#[cold]
#[inline(never)]
fn start(config: &StepConfig, state: &mut StepState, raw: &RawFrame) {
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
        segment.speed_m_s = 0.0;
        segment.direction = 0.0;
    }
    state.frame.raw = *raw;
    state.missed = 0.0;
    state.changed = [u32::MAX; SEGMENTS];
    state.frozen = 0;
    state.started = true;
}

/// One sample with (`BEYOND`) or without anything beyond equation (3).
#[inline(never)]
fn sample<const BEYOND: bool>(config: &StepConfig, state: &mut StepState, raw: &RawFrame) {
    let stale = raw
        .fault
        .intersects(Status::CONVERTER_CRC.union(Status::CONVERTER_TIMEOUT));
    let elapsed = state.missed + 1.0;
    let (elapsed, missed) = if stale {
        (0.0, elapsed)
    } else {
        (elapsed, 0.0)
    };
    state.missed = missed;
    if stale {
        state.frame.raw.fault = raw.fault;
    } else {
        state.frame.raw = *raw;
    }
    let wrong_temperature = take_temperature(&mut state.frame.raw, raw.temperature_delta_k);
    watch_frozen(config, state);

    let frame = &mut state.frame;
    let x = measure::<0>(config, frame, elapsed);
    let mut pairs = [Corrected::default(); 2];
    if !BEYOND {
        pairs[0] = correct::<0>(frame, x.at.turns, x.error);
    }
    keep_order();
    let y = measure::<1>(config, frame, elapsed);
    if !BEYOND {
        pairs[1] = correct::<1>(frame, y.at.turns, y.error);
    }
    keep_order();
    state.slips |= x.slips | y.slips;
    let mut bits = state.slips
        | x.doubts
        | y.doubts
        | raw.fault.bits()
        | config.standing_bits
        | wrong_temperature;
    if BEYOND {
        let further = beyond(config, frame, &x.at, &y.at, &mut bits);
        pairs = [
            correct::<0>(frame, x.at.turns, x.error + further[0]),
            correct::<1>(frame, y.at.turns, y.error + further[1]),
        ];
    }
    let parity_turns = pose(config, frame, &pairs);
    let deflection = psd::deflection(
        &config.beacon,
        config.tan_full_scale,
        frame.raw.electrode_counts,
    );
    state.frame.tan_psi = deflection.tan_psi;
    bits |= deflection.bits
        | (above(parity_turns.to_bits(), config.parity_turns.to_bits()) & Status::PARITY.bits())
        | if state.frozen == 0 {
            0
        } else {
            Status::FROZEN.bits()
        };
    state.frame.status = Status::from_bits_retain(bits);
    state.frame.sequence = state.sequence;
    state.sequence = state.sequence.wrapping_add(1);
}

/// Stores the temperature; one that is not within ±1000 K is replaced by zero and reported.
#[inline(always)]
fn take_temperature(kept: &mut RawFrame, delta_k: f32) -> u32 {
    let wrong = above(delta_k.to_bits(), 1000.0_f32.to_bits());
    kept.temperature_delta_k = f32::from_bits(delta_k.to_bits() & !wrong);
    wrong & Status::NUMERIC.bits()
}

/// Keeps the compiler from moving loads and stores across. It costs nothing by itself: it keeps the live values of one
/// part of the work within the register file, and loads next to each other, where the core pipelines them.
#[inline(always)]
fn keep_order() {
    compiler_fence(Ordering::SeqCst);
}

/// A pair of segments after counting: phases, equation (3), and what was noticed.
#[derive(Clone, Copy)]
struct Measured {
    at: Interpolated,
    error: Lanes,
    slips: u32,
    doubts: u32,
}

/// Interpolates and counts segments P and P + 2; writes all of their part of the frame but the calibrated outputs.
#[inline(always)]
fn measure<const P: usize>(config: &StepConfig, frame: &mut Frame, elapsed: f32) -> Measured {
    let lanes = [P, P + 2];
    let counts = lanes.map(|i| frame.raw.quadrature_counts[i]);
    let at = quadrature::interpolate(&config.pairs[P].0, counts);
    keep_order();
    let old = lanes.map(|i| frame.segments[i]);
    let counters = Counters {
        turns: Lanes::new(|k| old[k].unmodified.fraction_turns),
        teeth: [old[0].unmodified.teeth, old[1].unmodified.teeth],
        speed_m_s: Lanes::new(|k| old[k].speed_m_s),
    };
    let (counters, slip) = counters.advance(&config.counter, at.turns, elapsed);
    for (k, i) in lanes.into_iter().enumerate() {
        let segment = &mut frame.segments[i];
        segment.unmodified = Coordinate {
            teeth: counters.teeth[k],
            fraction_turns: at.turns.0[k],
        };
        segment.amplitude_counts = at.amplitude.0[k];
        segment.speed_m_s = counters.speed_m_s.0[k];
    }
    let doubts = [0, 1].map(|k| doubts(config, at.square[k], counts[k]));
    keep_order();
    let own = config.pairs[P].1;
    keep_order();
    Measured {
        error: own.errors(at.sine, at.cosine),
        slips: (slip[0] & Status::SLIP_1.bits() | slip[1] & Status::SLIP_3.bits()) << P,
        doubts: (doubts[0] | doubts[1] << 2) << P,
        at,
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

/// The errors' part by equation (9) and the further rows, turns. A sum that is not within half a pitch is replaced by
/// zero and reported.
#[inline(always)]
fn beyond(
    config: &StepConfig,
    frame: &mut Frame,
    x: &Interpolated,
    y: &Interpolated,
    bits: &mut u32,
) -> [Lanes; 2] {
    if config.directions {
        for segment in &mut frame.segments {
            segment.direction =
                quadrature::direction(segment.direction, segment.speed_m_s, config.dead_band_m_s);
        }
    }
    let further = &config.further;
    let angle = mean_angle_turns(&frame.segments.map(|s| s.unmodified));
    let unit = |at: &Interpolated, k: usize| Unit {
        sine: at.sine.0[k],
        cosine: at.cosine.0[k],
    };
    let own = [unit(x, 0), unit(y, 0), unit(x, 1), unit(y, 1)];
    let lateral = lateral_units(&own, angle * config.lateral_over_span);
    let part = |i: usize| {
        further.lateral[i][0] * lateral[i].sine + further.lateral[i][1] * lateral[i].cosine
    };
    let mut errors = [part(0), part(1), part(2), part(3)];
    if further.has_extra() {
        let basis = Basis {
            own,
            lateral,
            theta_rad: angle * config.pitch_over_span,
            speed_m_s: frame.segments.map(|s| s.speed_m_s),
            direction: frame.segments.map(|s| s.direction),
            temperature_delta_k: frame.raw.temperature_delta_k,
        };
        for (error, extra) in errors.iter_mut().zip(further.extra_errors(&basis)) {
            let wrong = above((*error + extra).to_bits(), 0.5_f32.to_bits());
            *error = f32::from_bits((*error + extra).to_bits() & !wrong);
            *bits |= wrong & Status::NUMERIC.bits();
        }
    }
    [Lanes([errors[0], errors[2]]), Lanes([errors[1], errors[3]])]
}

/// A pair's calibrated outputs: middle and difference.
#[derive(Clone, Copy, Default)]
struct Corrected {
    mean: Coordinate,
    across_turns: f32,
}

/// Writes the calibrated outputs of segments p and p + 2.
#[inline(always)]
fn correct<const P: usize>(frame: &mut Frame, turns: Lanes, error: Lanes) -> Corrected {
    let calibrated = turns + error;
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

/// Looks at one segment a sample, in turn: which bits of its counts have changed since it was last looked at. At a
/// window's end, a segment of which a channel did not change at all is marked frozen until the next end.
#[inline(always)]
fn watch_frozen(config: &StepConfig, state: &mut StepState) {
    let i = (state.sequence & 3) as usize;
    let counts = word(state.frame.raw.quadrature_counts[i]);
    let changed = state.changed[i] | (counts ^ state.watched[i]);
    state.watched[i] = counts;
    state.changed[i] = changed;
    if state.sequence & config.frozen_mask < SEGMENTS as u32 {
        let still = changed & 0xFFFF == 0 || changed >> 16 == 0;
        state.frozen = state.frozen & !(1 << i) | u32::from(still) << i;
        state.changed[i] = 0;
    }
}

#[inline(always)]
fn word(counts: [i16; 2]) -> u32 {
    u32::from(counts[0] as u16) | u32::from(counts[1] as u16) << 16
}
