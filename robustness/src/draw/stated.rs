//! What `recording.toml` states: mostly what is true, else anything that the reader takes.

use super::chance::chance;
use effects::random::{ChaCha8Rng, index, log_uniform};
use recording::Meta;

/// Lengths, m, and numbers: the reader's ranges (recording/src/meta.rs).
const PITCH_M: [f64; 2] = [1.0e-7, 0.1];
/// See [`PITCH_M`].
const LENGTH_M: [f64; 2] = [1.0e-7, 10.0];
/// See [`PITCH_M`].
const POSITIVE: [f64; 2] = [1.0e-9, 1.0e9];
/// See [`PITCH_M`]: zero besides.
const NOISE_COUNTS: [f64; 2] = [1.0e-3, 1.0e9];
/// See [`PITCH_M`]: zero besides.
const NOISE_M: [f64; 2] = [1.0e-12, 1.0e-2];

/// Changes some of the stated values.
pub fn restate(meta: &mut Meta, rng: &mut ChaCha8Rng) {
    meta.electronics.position_noise_m = Some(1.6e-7);
    if chance(rng, 0.5) {
        return;
    }
    let geometry = &mut meta.geometry;
    maybe(&mut geometry.pitch_m, PITCH_M, rng);
    optional(&mut geometry.span_m, LENGTH_M, rng);
    optional(&mut geometry.lateral_m, LENGTH_M, rng);
    if let Some(coordination) = &mut meta.coordination {
        maybe(&mut coordination.height_m, LENGTH_M, rng);
        maybe(&mut coordination.lever_x_m, LENGTH_M, rng);
        maybe(&mut coordination.lever_y_m, LENGTH_M, rng);
        maybe(&mut coordination.tan_full_scale, POSITIVE, rng);
    }
    let electronics = &mut meta.electronics;
    optional(&mut electronics.amplitude_counts, POSITIVE, rng);
    optional(&mut electronics.psd_sum_counts, POSITIVE, rng);
    noise(&mut electronics.quadrature_noise_counts, NOISE_COUNTS, rng);
    noise(&mut electronics.psd_noise_counts, NOISE_COUNTS, rng);
    noise(&mut electronics.position_noise_m, NOISE_M, rng);
    if chance(rng, 0.1) {
        electronics.adc_bits = Some(16 + index(rng, 17) as u32);
    }
}

/// Perhaps another value: a few times what it was, or anything in the range.
fn maybe(value: &mut f64, [low, high]: [f64; 2], rng: &mut ChaCha8Rng) {
    match index(rng, 12) {
        0 => *value = log_uniform(rng, low, high),
        1 => *value = low,
        2 => *value = high,
        3 | 4 => *value = (*value * log_uniform(rng, 0.1, 10.0)).clamp(low, high),
        _ => {}
    }
}

fn optional(value: &mut Option<f64>, range: [f64; 2], rng: &mut ChaCha8Rng) {
    if let Some(value) = value {
        maybe(value, range, rng);
    }
}

fn noise(value: &mut Option<f64>, range: [f64; 2], rng: &mut ChaCha8Rng) {
    optional(value, range, rng);
    if chance(rng, 0.05) {
        *value = Some(0.0);
    }
}
