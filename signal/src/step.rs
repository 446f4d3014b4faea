//! One sample: raw counts in, corrected frame out. Pure, f32, no allocation, no panic, no loop without a bound.
//!
//! Order of work: pairs to phases, tooth counts, error model (equations 3 and 9 dense, further rows if there are any),
//! pose and parity (equations 4 and 5), electrodes, status. The same bits on host and target.

mod config;
mod state;

pub use config::StepConfig;
pub use state::StepState;

use config::Reach;
use state::{NEVER, SLIPS, WATCHED, Watch};

use crate::beacon::CompiledBeaconPose;
use crate::frame::{BeaconPose, Coordinate, Frame, Pose, RawFrame, Status};
use crate::lanes::Lanes;
use crate::math::Constants;
use crate::model::{Phases, Unit, lateral_units, mean_angle_turns};
use crate::psd;
use crate::quadrature::{self, Counters, above};
use crate::teeth::ToothMap;
use core::sync::atomic::{Ordering, compiler_fence};

/// One sample: `raw` into the state, [`isr_step`], and a copy of its frame.
pub fn step(config: &StepConfig, state: &mut StepState, raw: &RawFrame) -> Frame {
    let kept = &mut state.frame.raw;
    if raw.fault.intersects(STALE) && state.missed != NEVER {
        kept.fault = raw.fault;
        kept.temperature_delta_k = raw.temperature_delta_k;
    } else {
        *kept = *raw;
    }
    if !believable(kept.temperature_delta_k) {
        kept.temperature_delta_k = 0.0;
        kept.fault |= Status::NUMERIC;
    }
    *isr_step(config, state)
}

/// Faults with which the counts are not this instant's.
const STALE: Status = Status::CONVERTER_CRC.union(Status::CONVERTER_TIMEOUT);

/// One sample from the counts in [`StepState::raw_mut`], the frame written in place. With a converter's fault bit set the
/// counts there must be the previous ones. A temperature not within ±1000 K counts for nothing. Cost: `cargo xtask bench`.
#[inline(never)] // one copy, 7 KiB of flash, for the steps with and without a map
pub fn isr_step<'s>(config: &StepConfig, state: &'s mut StepState) -> &'s Frame {
    if config.beyond_own {
        sample::<true>(config, state);
        match &config.beacon_pose {
            Some(beacon) => relate_to_beacon(beacon, &mut state.frame),
            None => forget_beacon(&mut state.frame),
        }
    } else {
        sample::<false>(config, state);
        forget_beacon(&mut state.frame);
    }
    &state.frame
}

/// The same with a tooth map: its errors are added to the calibrated outputs before the pose.
#[inline(never)]
pub fn isr_step_mapped<'s>(
    config: &StepConfig,
    state: &'s mut StepState,
    map: &ToothMap,
) -> &'s Frame {
    isr_step(config, state);
    let frame = &mut state.frame;
    let (errors, inside) = map.errors_turns(frame);
    let sum = |i: usize| frame.segments[i].calibrated.fraction_turns + errors[i];
    let sums = [Lanes([sum(0), sum(2)]), Lanes([sum(1), sum(3)])];
    let pairs = [correct::<0>(frame, sums[0]), correct::<1>(frame, sums[1])];
    pose(config, frame, &pairs);
    frame.status.set(Status::OUTSIDE_MAP, !inside);
    match &config.beacon_pose {
        Some(beacon) => relate_to_beacon(beacon, frame),
        None => forget_beacon(frame),
    }
    &state.frame
}

/// No pose relative to a beacon: all zeros, which it is already where none is seen.
#[inline(always)]
fn forget_beacon(frame: &mut Frame) {
    if frame.beacon.seen {
        frame.beacon = BeaconPose::default();
    }
}

/// The pose relative to the beacon, where one is seen.
#[inline(never)]
fn relate_to_beacon(beacon: &CompiledBeaconPose, frame: &mut Frame) {
    let blind = Status::BEACON_MISSING.union(Status::BEACON_SATURATED);
    frame.beacon = if frame.status.intersects(blind) {
        BeaconPose::default()
    } else {
        beacon.pose(&frame.pose, frame.tan_psi)
    };
}

/// One sample, with or without (`BEYOND`) what goes beyond equation (3).
#[inline(always)]
fn sample<const BEYOND: bool>(config: &StepConfig, state: &mut StepState) {
    let fault = state.frame.raw.fault;
    let interrupted = fault.intersection(STALE).bits() | state.missed;
    let sequence = state.frame.sequence.wrapping_add(1);
    state.frame.sequence = sequence;
    let reach = if interrupted == 0 {
        watch_frozen(config, state, sequence);
        config.reach
    } else if state.missed == NEVER {
        state.missed = u32::from(fault.intersects(STALE));
        Reach::FIRST
    } else {
        bridge(config, state)
    };
    let frame = &mut state.frame;
    let bits = frame.status.bits() & state.latched | fault.bits() | config.standing_bits;

    let constants = config.constants;
    keep_order();
    let (x, bits) = measure::<0>(config, &constants, frame, reach, bits);
    let x_corrected = correct::<0>(frame, x.turns + x.error);
    keep_order();
    let (y, bits) = measure::<1>(config, &constants, frame, reach, bits);
    let mut pairs = [x_corrected, correct::<1>(frame, y.turns + y.error)];
    let mut bits = bits;
    if BEYOND {
        let phases = phases(config, frame, &x, &y);
        pairs = correct_laterally(config, frame, &phases);
        if config.extended {
            // A copy: without further rows the phases then stay in registers.
            pairs = correct_further(config, frame, &{ phases }, &mut bits);
        }
    }
    let parity_turns = pose(config, frame, &pairs);
    let electrodes = frame.raw.electrode_counts;
    let deflection = psd::deflection(&config.beacon, electrodes);
    frame.tan_psi = deflection.tan_psi;
    let parity = above(parity_turns.to_bits(), config.parity_turns.to_bits());
    bits |= deflection.bits | (parity & Status::PARITY.bits());
    frame.status = Status::from_bits_retain(bits);
}

/// What a sample must know that is a failed conversion (no time has passed: the same instant again), or the first good one
/// after instants without one. After too many of these the tooth counts are not sure, whatever the phases say; if sampling
/// instants were missed as well, that bit stays with the slips.
#[cold]
#[inline(never)]
fn bridge(config: &StepConfig, state: &mut StepState) -> Reach {
    let fault = state.frame.raw.fault.bits();
    if fault & STALE.bits() == 0 {
        let without_sample = core::mem::take(&mut state.missed);
        doubt_teeth(config, state, without_sample, fault);
        return Reach::new((without_sample + 1) as f32 * config.reach.turns_per_m_s());
    }
    let without_sample = (state.missed + 1).min(NEVER - 1);
    state.missed = without_sample;
    doubt_teeth(config, state, without_sample, fault);
    Reach::new(0.0)
}

/// Latches what so many instants without a sample make of the tooth counts.
#[inline(always)]
fn doubt_teeth(config: &StepConfig, state: &mut StepState, without_sample: u32, fault: u32) {
    if without_sample > config.gap_samples {
        state.frame.status |= SLIPS;
        state.latched |= fault & Status::OVERRUN.bits();
    }
}

/// Whether a difference of temperature can be one, kelvin.
fn believable(delta_k: f32) -> bool {
    delta_k.abs() <= 1000.0
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

/// Interpolates and counts segments P and P + 2; writes all of their part of the frame but the calibrated outputs, and
/// adds their status bits.
#[inline(always)]
fn measure<const P: usize>(
    config: &StepConfig,
    constants: &Constants,
    frame: &mut Frame,
    reach: Reach,
    mut bits: u32,
) -> (Measured, u32) {
    let lanes = [P, P + 2];
    let counts = lanes.map(|i| frame.raw.quadrature_counts[i]);
    let clipped = counts.map(|counts| clipped(config, counts));
    bits |= (clipped[0] | clipped[1] << 2) << P;
    let pair = config.pairs[P].0;
    keep_order();
    let at = quadrature::interpolate(constants, &config.octants, &pair, counts);
    let doubts = at.square.map(|square| doubts(config, square));
    bits |= (doubts[0] | doubts[1] << 2) << P;
    // Stored at once, so that what the bits are made of need not be kept.
    frame.status = Status::from_bits_retain(bits);
    (0..2).for_each(|k| frame.segments[lanes[k]].amplitude_counts = at.amplitude.0[k]);
    let old = lanes.map(|i| frame.segments[i].unmodified);
    let mut counters = Counters {
        turns: Lanes::new(|k| old[k].fraction_turns),
        teeth: [old[0].teeth, old[1].teeth],
        speed_m_s: frame.speed_m_s[P],
    };
    let limits = &config.counter[reach.is_first() as usize];
    if reach.is_first() {
        // No teeth for the first segment, for the second as many as make it the nearest to the first.
        counters.turns.0[1] = at.turns.0[0];
    }
    let (counters, slip) = counters.advance(constants, limits, at.turns, reach.turns_per_m_s());
    for (k, i) in lanes.into_iter().enumerate() {
        frame.segments[i].unmodified = Coordinate {
            teeth: counters.teeth[k],
            fraction_turns: at.turns.0[k],
        };
    }
    frame.speed_m_s[P] = counters.speed_m_s;
    let error = config.pairs[P].1.errors(at.sine, at.cosine);
    let slips = slip[0] & Status::SLIP_1.bits() | slip[1] & Status::SLIP_3.bits();
    bits |= slips << P;
    frame.status = Status::from_bits_retain(bits);
    let measured = Measured {
        sine: at.sine,
        cosine: at.cosine,
        turns: at.turns,
        error,
    };
    (measured, bits)
}

/// Amplitude bits as for segment 1, by the signs of integer differences.
#[inline(always)]
fn doubts(config: &StepConfig, square: u32) -> u32 {
    let low = square.wrapping_sub(config.square_low);
    let high = config.square_high.wrapping_sub(square);
    low >> 31 | high >> 31 << 4
}

/// Clip bit as for segment 1.
#[inline(always)]
fn clipped(config: &StepConfig, counts: [i16; 2]) -> u32 {
    let [s, c] = counts.map(i32::from);
    let clipped = (config.clip_square - s * s) | (config.clip_square - c * c);
    (clipped as u32) >> 31 << 8
}

/// What the terms beyond equation (3) depend on.
#[inline(always)]
fn phases(config: &StepConfig, frame: &Frame, x: &Measured, y: &Measured) -> Phases {
    let unit = |at: &Measured, k: usize| Unit {
        sine: at.sine.0[k],
        cosine: at.cosine.0[k],
    };
    let own = [unit(x, 0), unit(y, 0), unit(x, 1), unit(y, 1)];
    let angle_turns = mean_angle_turns(&frame.segments.map(|s| s.unmodified));
    Phases {
        lateral: lateral_units(&own, angle_turns * config.lateral_over_span),
        own,
        theta_rad: angle_turns * config.pitch_over_span,
    }
}

/// Adds the lateral terms of equation (9).
#[inline(always)]
fn correct_laterally(config: &StepConfig, frame: &mut Frame, phases: &Phases) -> [Corrected; 2] {
    let (lateral, coefficients) = (&phases.lateral, &config.further.lateral);
    let error =
        |i: usize| coefficients[i][0] * lateral[i].sine + coefficients[i][1] * lateral[i].cosine;
    let sum = |i: usize| frame.segments[i].calibrated.fraction_turns + error(i);
    let sums = [Lanes([sum(0), sum(2)]), Lanes([sum(1), sum(3)])];
    [correct::<0>(frame, sums[0]), correct::<1>(frame, sums[1])]
}

/// Keeps the directions of travel and adds the model's further rows. A sum of these that is not within half a pitch is
/// left out and reported.
#[inline(never)]
fn correct_further(
    config: &StepConfig,
    frame: &mut Frame,
    phases: &Phases,
    bits: &mut u32,
) -> [Corrected; 2] {
    let raw = &mut frame.raw;
    if !believable(raw.temperature_delta_k) {
        raw.temperature_delta_k = 0.0;
        *bits |= Status::NUMERIC.bits();
    }
    for (direction, speed_m_s) in frame.direction.iter_mut().zip(frame.speed_m_s) {
        *direction = quadrature::direction(*direction, speed_m_s, config.dead_band_m_s);
    }
    let warmth_k = frame.raw.temperature_delta_k;
    let multipliers = [[1.0; 2], frame.speed_m_s, [warmth_k; 2], frame.direction];
    let errors = config.further.errors(phases, &multipliers);
    let mut sum = |i: usize| {
        let error = errors[i % 2].0[i / 2].to_bits();
        let wrong = above(error, 0.5_f32.to_bits());
        *bits |= wrong & Status::NUMERIC.bits();
        frame.segments[i].calibrated.fraction_turns + f32::from_bits(error & !wrong)
    };
    let sums = [Lanes([sum(0), sum(2)]), Lanes([sum(1), sum(3)])];
    [correct::<0>(frame, sums[0]), correct::<1>(frame, sums[1])]
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
fn watch_frozen(config: &StepConfig, state: &mut StepState, sequence: u32) {
    let watch = state.watch;
    let counts = word(state.frame.raw.quadrature_counts[watch.segment as usize & 3]);
    state.watch.counts = counts;
    state.watch.changed = watch.changed | (counts ^ watch.counts);
    if sequence & config.frozen_mask == 0 {
        judge_frozen(config, state);
    }
}

/// At a window's end: whether a channel did not change at all in any of the last four windows, which is one of each segment.
#[inline(always)]
fn judge_frozen(config: &StepConfig, state: &mut StepState) {
    let changed = state.watch.changed;
    // A sign bit for each half that is zero (the lower one's borrow changes nothing: it is zero then).
    let halves = changed.wrapping_sub(0x0001_0001) & !changed & 0x8000_8000;
    let still = (state.watch.still << 1 | u32::from(halves != 0)) & 0b1110_1111;
    let still = if still & 0b1111 == 0 {
        state.frame.status.remove(WATCHED);
        0
    } else {
        judge_still(config.frozen_bit, state, halves, still)
    };
    let segment = state.watch.segment.wrapping_add(1);
    let counts = word(state.frame.raw.quadrature_counts[segment as usize & 3]);
    state.watch = Watch {
        segment,
        counts,
        changed: 0,
        still,
    };
}

/// A channel that stands this far from zero is no dead input, counts. A prior: an input's offset is some percent of the
/// converter's range, of which this is a sixteenth.
const AWAY_FROM_ZERO_COUNTS: u16 = 2048;

/// Bit of [`Watch::still`] that tells of this window's channel that it stands at its amplifier's rail. A definition: it is free
/// there.
const RAIL: u32 = 1 << 4;

/// From the bit of frozen channels, which is none where nothing is watched, to that of the first segment's rail.
const FROZEN_TO_RAIL: u32 =
    Status::RAIL_1.bits().trailing_zeros() - Status::FROZEN.bits().trailing_zeros();

/// Sets the bits where a channel did not change: the converter is frozen, but for a channel that stands away from zero beside one that
/// changes. That one is at its amplifier's rail.
#[cold]
#[inline(never)] // what every sample pays for is the sample's
fn judge_still(frozen_bit: u32, state: &mut StepState, halves: u32, still: u32) -> u32 {
    // Of the one channel that stood still; zero where it is both.
    let count = match halves {
        0x8000 => state.watch.counts,
        0x8000_0000 => state.watch.counts >> 16,
        _ => 0,
    };
    let mut still = still;
    if is_away_from_zero(count as u16) {
        still |= RAIL;
    }
    let mut bits = state.frame.status.bits() & !Status::FROZEN.bits();
    if still & !(still >> 4) & 0b1111 != 0 {
        bits |= frozen_bit;
    }
    let segment = state.watch.segment & 3;
    bits &= !(Status::RAIL_1.bits() << segment);
    if still & RAIL != 0 {
        bits |= frozen_bit << FROZEN_TO_RAIL << segment;
    }
    state.frame.status = Status::from_bits_retain(bits);
    still
}

/// Whether counts in two's complement are [`AWAY_FROM_ZERO_COUNTS`] or more, either way, by one comparison.
#[inline(always)]
const fn is_away_from_zero(counts: u16) -> bool {
    counts.wrapping_add(AWAY_FROM_ZERO_COUNTS - 1) >= 2 * AWAY_FROM_ZERO_COUNTS - 1
}

#[inline(always)]
fn word(counts: [i16; 2]) -> u32 {
    u32::from(counts[0] as u16) | u32::from(counts[1] as u16) << 16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rail_is_as_far_from_zero_either_way() {
        for counts in 0..=u16::MAX {
            let away = counts.cast_signed().unsigned_abs() >= AWAY_FROM_ZERO_COUNTS;
            assert_eq!(is_away_from_zero(counts), away, "{counts}");
        }
    }
}
