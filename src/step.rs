//! One sample: raw counts in, corrected frame out. Pure, f32, no allocation, no panic, no loop without a bound.
//!
//! Order of work: pairs to phases, tooth counts, error model (equations 3 and 9 dense, further rows if there are any),
//! pose and parity (equations 4 and 5), electrodes, status. The same bits on host and target.

use crate::frame::{BeaconPose, Coordinate, Frame, Pose, RawFrame, SEGMENTS, Segment, Status};
use crate::model::{Basis, CompiledModel, Unit, lateral_units, mean_angle_turns};
use crate::psd::{self, BeaconLimits, Deflection};
use crate::quadrature::{self, CompiledPair, CounterLimits, Interpolated, ToothCounter};
use crate::settings::{ConfigError, Settings};

/// [`Settings`] in machine units: all the interrupt reads. About 1.3 KiB.
#[derive(Clone, Debug, PartialEq)]
pub struct StepConfig {
    pairs: [CompiledPair; SEGMENTS],
    counter: CounterLimits,
    amplitude_low: f32,
    amplitude_high: f32,
    clip_counts: i32,
    parity_turns: f32,
    frozen_samples: u16,
    beacon: BeaconLimits,
    model: CompiledModel,
    calibrated: bool,
    tan_full_scale: f32,
    pitch_m: f32,
    pitch_over_span: f32,
    lateral_over_span: f32,
    speed_m_s: f32,
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
        Ok(Self {
            pairs: settings.pairs.map(|pair| pair.compile()),
            counter: CounterLimits {
                slip: limits.slip_turns,
                speed_filter: limits.speed_filter,
                dead_band: limits.direction_dead_band_m_s / speed_m_s,
            },
            amplitude_low: limits.amplitude_low_counts,
            amplitude_high: limits.amplitude_high_counts,
            clip_counts: i32::from(limits.clip_counts),
            parity_turns: limits.parity_turns,
            frozen_samples: limits.frozen_samples,
            beacon: limits.beacon,
            model: settings
                .model
                .as_ref()
                .map_or_else(CompiledModel::default, |m| {
                    CompiledModel::new(m, geometry.pitch_m)
                }),
            calibrated: settings.model.is_some(),
            tan_full_scale: geometry.tan_full_scale,
            pitch_m: geometry.pitch_m,
            pitch_over_span: geometry.pitch_m / geometry.span_m,
            lateral_over_span: geometry.lateral_m / geometry.span_m,
            speed_m_s,
        })
    }
}

/// What one sample leaves to the next.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StepState {
    counters: [ToothCounter; SEGMENTS],
    quadrature_counts: [[i16; 2]; SEGMENTS],
    electrode_counts: [i16; 4],
    /// Bits of the counts that have changed since the frozen window began.
    changed: [u32; SEGMENTS],
    frozen: [bool; SEGMENTS],
    /// Samples since the last good one.
    missed: u16,
    sequence: u32,
    slips: u32,
    started: bool,
}

impl StepState {
    /// Before the first sample. That sets the tooth counts: 0 for segments 1 and 2, their neighbours' within half a tooth.
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes back the latched slip bits, once the pose is known again.
    pub fn clear_slips(&mut self) {
        self.slips = 0;
    }

    /// Sets the tooth counts, e.g. to those of a known place, and clears the slip bits.
    pub fn set_teeth(&mut self, teeth: [i32; SEGMENTS]) {
        for (counter, teeth) in self.counters.iter_mut().zip(teeth) {
            counter.teeth = teeth;
        }
        self.slips = 0;
    }

    /// Counts again from the next sample as after start-up; the sequence number goes on.
    pub fn restart_count(&mut self) {
        self.started = false;
        self.slips = 0;
    }
}

/// One sample. Cost: docs/costs.md.
#[inline]
pub fn step(config: &StepConfig, state: &mut StepState, raw: &RawFrame) -> Frame {
    let (mut raw, mut status) = sanitize(state, raw);
    let stale = raw
        .fault
        .intersects(Status::CONVERTER_CRC.union(Status::CONVERTER_TIMEOUT));
    if stale {
        raw.quadrature_counts = state.quadrature_counts;
        raw.electrode_counts = state.electrode_counts;
    }
    let mut pairs = [Interpolated::default(); SEGMENTS];
    let mut bits = 0;
    for i in 0..SEGMENTS {
        pairs[i] = quadrature::interpolate(&config.pairs[i], raw.quadrature_counts[i]);
        bits |= doubts(config, pairs[i].amplitude, raw.quadrature_counts[i]) << i;
    }
    count(config, state, &pairs, stale);
    let seen: [Coordinate; SEGMENTS] = core::array::from_fn(|i| Coordinate {
        teeth: state.counters[i].teeth,
        fraction_turns: pairs[i].turns,
    });
    let errors = errors(config, state, &pairs, &seen, raw.temperature_delta_k);
    let segments: [Segment; SEGMENTS] = core::array::from_fn(|i| {
        segment(
            config,
            &pairs[i],
            &state.counters[i],
            errors[i],
            &mut status,
        )
    });
    let (pose, parity_turns) = pose(config, &segments);
    let deflection = psd::deflection(&config.beacon, config.tan_full_scale, raw.electrode_counts);
    watch_frozen(config, state, &raw.quadrature_counts);
    bits |= state.slips | overall(config, state, &deflection, parity_turns);
    state.quadrature_counts = raw.quadrature_counts;
    state.electrode_counts = raw.electrode_counts;
    let sequence = state.sequence;
    state.sequence = sequence.wrapping_add(1);
    Frame {
        sequence,
        status: status
            .union(raw.fault)
            .union(Status::from_bits_retain(bits)),
        raw,
        segments,
        pose,
        parity_m: parity_turns * config.pitch_m,
        tan_psi: deflection.tan_psi,
        beacon: BeaconPose::default(),
    }
}

/// Replaces a temperature that is not within ±1000 K by zero.
#[inline(always)]
fn sanitize(_state: &StepState, raw: &RawFrame) -> (RawFrame, Status) {
    let mut raw = *raw;
    if raw.temperature_delta_k.abs() <= 1000.0 {
        return (raw, Status::empty());
    }
    raw.temperature_delta_k = 0.0;
    (raw, Status::NUMERIC)
}

/// Amplitude and clip bits as for segment 1.
#[inline(always)]
fn doubts(config: &StepConfig, amplitude: f32, counts: [i16; 2]) -> u32 {
    let limit = config.clip_counts;
    let clipped = counts
        .iter()
        .fold(false, |hit, &c| hit | (i32::from(c).abs() >= limit));
    u32::from(amplitude < config.amplitude_low)
        | u32::from(amplitude > config.amplitude_high) << 4
        | u32::from(clipped) << 8
}

/// Advances the tooth counters and latches slips.
#[inline(always)]
fn count(
    config: &StepConfig,
    state: &mut StepState,
    pairs: &[Interpolated; SEGMENTS],
    stale: bool,
) {
    if !state.started {
        start(state, pairs);
        return;
    }
    let elapsed = if stale {
        0.0
    } else {
        f32::from(state.missed) + 1.0
    };
    state.missed = if stale {
        state.missed.saturating_add(1)
    } else {
        0
    };
    for i in 0..SEGMENTS {
        let slip = state.counters[i].advance(&config.counter, pairs[i].turns, elapsed);
        state.slips |= u32::from(slip) << (12 + i);
    }
}

/// First sample: counts 0, a pair's second segment within half a tooth of its first.
#[inline(never)]
fn start(state: &mut StepState, pairs: &[Interpolated; SEGMENTS]) {
    for i in 0..SEGMENTS {
        let apart = pairs[i & 1].turns - pairs[i].turns;
        let teeth = crate::math::round(apart).1;
        state.counters[i] = ToothCounter {
            turns: pairs[i].turns,
            teeth,
            ..ToothCounter::default()
        };
    }
    state.changed = [u32::MAX; SEGMENTS];
    state.started = true;
    state.missed = 0;
}

/// The segments' errors e by the model in force, turns.
#[inline(always)]
fn errors(
    config: &StepConfig,
    state: &StepState,
    pairs: &[Interpolated; SEGMENTS],
    seen: &[Coordinate; SEGMENTS],
    temperature_delta_k: f32,
) -> [f32; SEGMENTS] {
    let model = &config.model;
    let own: [Unit; SEGMENTS] = core::array::from_fn(|i| Unit {
        sine: pairs[i].sine,
        cosine: pairs[i].cosine,
    });
    let mut errors: [f32; SEGMENTS] = core::array::from_fn(|i| model.dense[i].own_error(own[i]));
    if !(model.lateral || model.has_extra()) {
        return errors;
    }
    let angle = mean_angle_turns(seen);
    let lateral = lateral_units(&own, angle * config.lateral_over_span);
    for i in 0..SEGMENTS {
        errors[i] += model.dense[i].lateral_error(lateral[i]);
    }
    if model.has_extra() {
        let basis = Basis {
            own,
            lateral,
            theta_rad: angle * config.pitch_over_span,
            speed_m_s: core::array::from_fn(|i| state.counters[i].speed * config.speed_m_s),
            direction: core::array::from_fn(|i| state.counters[i].direction),
            temperature_delta_k,
        };
        model.add_extra(&basis, &mut errors);
    }
    errors
}

/// One segment's part of the frame; an error that is not within half a pitch is replaced by zero.
#[inline(always)]
fn segment(
    config: &StepConfig,
    pair: &Interpolated,
    counter: &ToothCounter,
    error: f32,
    status: &mut Status,
) -> Segment {
    let sound = error.abs() <= 0.5;
    let error = if sound { error } else { 0.0 };
    if !sound {
        *status |= Status::NUMERIC;
    }
    let unmodified = Coordinate {
        teeth: counter.teeth,
        fraction_turns: pair.turns,
    };
    Segment {
        unmodified,
        calibrated: Coordinate {
            teeth: counter.teeth,
            fraction_turns: pair.turns + error,
        },
        amplitude_counts: pair.amplitude,
        speed_m_s: counter.speed * config.speed_m_s,
        direction: counter.direction,
    }
}

/// Equations (4) and (5), and the pairs' means.
#[inline(always)]
fn pose(config: &StepConfig, segments: &[Segment; SEGMENTS]) -> (Pose, f32) {
    let [p1, p2, p3, p4] = segments.map(|s| s.calibrated);
    let (across_x, across_y) = (p1.minus_turns(p3), p2.minus_turns(p4));
    let (theta_x_rad, theta_y_rad) = (
        across_x * config.pitch_over_span,
        across_y * config.pitch_over_span,
    );
    let theta_rad = 0.5 * (theta_x_rad + theta_y_rad);
    (
        Pose {
            x: p1.mean(p3),
            y: p2.mean(p4),
            theta_x_rad,
            theta_y_rad,
            theta_rad,
        },
        across_x - across_y,
    )
}

/// Marks what changed; at the window's end a pair of which a channel did not is frozen until the next end.
#[inline(always)]
fn watch_frozen(config: &StepConfig, state: &mut StepState, counts: &[[i16; 2]; SEGMENTS]) {
    for i in 0..SEGMENTS {
        state.changed[i] |= word(counts[i]) ^ word(state.quadrature_counts[i]);
    }
    // One segment a sample, so that no sample pays for all.
    let phase = state.sequence & u32::from(config.frozen_samples).wrapping_sub(1);
    if phase < SEGMENTS as u32 {
        let i = (phase & 3) as usize;
        let changed = state.changed[i];
        state.frozen[i] = changed & 0xFFFF == 0 || changed >> 16 == 0;
        state.changed[i] = 0;
    }
}

#[inline(always)]
fn word(counts: [i16; 2]) -> u32 {
    u32::from(counts[0] as u16) | u32::from(counts[1] as u16) << 16
}

/// Bits that belong to no segment.
#[inline(always)]
fn overall(
    config: &StepConfig,
    state: &StepState,
    deflection: &Deflection,
    parity_turns: f32,
) -> u32 {
    let bit = |flag: Status, on: bool| if on { flag.bits() } else { 0 };
    let frozen = state.frozen.iter().fold(false, |any, &f| any | f);
    bit(Status::BEACON_MISSING, deflection.missing)
        | bit(Status::BEACON_SATURATED, deflection.saturated)
        | bit(Status::UNCALIBRATED, !config.calibrated)
        | bit(Status::FROZEN, frozen)
        | bit(Status::PARITY, parity_turns.abs() > config.parity_turns)
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::f64::consts::TAU;

    fn counts(amplitude: f64, turns: f64) -> [i16; 2] {
        let (s, c) = (turns * TAU).sin_cos();
        [
            (amplitude * s).round() as i16,
            (amplitude * c).round() as i16,
        ]
    }

    fn raw(turns: [f64; 4]) -> RawFrame {
        RawFrame {
            quadrature_counts: turns.map(|t| counts(25_000.0, t)),
            electrode_counts: [6000, 5000, 5500, 5500],
            ..RawFrame::default()
        }
    }

    #[test]
    fn follows_a_pose() {
        let config = StepConfig::build(&Settings::default()).unwrap();
        let mut state = StepState::new();
        let mut last = Frame::default();
        for k in 0..2000 {
            let (x, y, t) = (f64::from(k) * 0.07, -f64::from(k) * 0.03, 0.1);
            last = step(&config, &mut state, &raw([x + t, y + t, x - t, y - t]));
            assert_eq!(last.status, Status::UNCALIBRATED, "sample {k}");
        }
        let pitch = 1.016e-3_f32;
        let (x, y) = (1999.0 * 0.07 * 1.016e-3, -1999.0 * 0.03 * 1.016e-3);
        assert!(
            (last.pose.x.metres(pitch) - x).abs() < 2e-8,
            "{:?}",
            last.pose
        );
        assert!((last.pose.y.metres(pitch) - y).abs() < 2e-8);
        assert!((f64::from(last.pose.theta_rad) - 0.2 * 1.016e-3 / 9.7e-3).abs() < 2e-6);
        assert!((last.tan_psi[0] - 0.1 / 11.0).abs() < 1e-7 && last.tan_psi[1] == 0.0);
    }
}
