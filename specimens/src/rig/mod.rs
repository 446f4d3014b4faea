//! A second simulator, written apart from hal-sim and from the catalogue, to judge the diagnosis by.
//!
//! Geometry of equations (3), (4), (9) to (11); every shape is drawn anew. It shares no code with either side of the
//! effects. `UNLISTED` holds effects that no catalogue has.
#![allow(dead_code, clippy::needless_range_loop, missing_docs)]

mod courier;
mod dice;
mod effect;
mod measure;
mod motion;
pub mod shake;

pub use courier::Courier;
pub use dice::Dice;
pub use motion::Options;

use courier::Truth;
use effect::Effect;
use measure::{beacon, measure};
use motion::program;
use recording::{Coordination, Electronics, Geometry, Meta, Recording};
use std::f64::consts::TAU;

pub const CATALOGUE: [&str; 19] = [
    "lateral_dependence",
    "extra_harmonics",
    "tooth_variation",
    "angle_dependence",
    "psd_nonlinearity",
    "psd_misalignment",
    "thermal_drift",
    "velocity_lag",
    "psd_latency",
    "hysteresis",
    "gap_variation",
    "beacon_vibration",
    "axis_skew",
    "cycle_slip",
    "outlier_bursts",
    "excess_noise",
    "adc_clipping",
    "quadrature_drift",
    "span_error",
];

/// Catalogued as well: a list of its own, so that couriers that are drawn from [`CATALOGUE`] stay who they are.
pub const LATER: [&str; 1] = ["stray_field"];

pub const UNLISTED: [&str; 13] = [
    "time_drift",
    "line_pickup",
    "platen_bow",
    "half_order",
    "warm_harmonics",
    "speed_harmonics",
    "direction_harmonics",
    "psd_time_drift",
    "psd_fringes",
    "theta_bend",
    "pair_product",
    "speeds_together",
    "warm_thirds",
];

/// Makes a recording of the courier with the effects.
pub fn record(seed: u64, effects: &[(&str, f64)], o: &Options) -> (Recording, Courier) {
    record_as(seed, seed, effects, o)
}

/// The mounts' temperature, one small step after the other.
fn warm_through(truth: &mut [Truth], mount_s: f64) {
    let Some(mut last) = truth.first().copied() else {
        return;
    };
    last.mount = last.temp;
    for q in truth {
        let steps = ((q.t - last.t) / (0.01 * mount_s)).ceil().max(1.0);
        let share = (q.t - last.t) / steps / mount_s;
        q.mount = last.mount;
        for k in 0..steps as usize {
            let board = last.temp + (q.temp - last.temp) * (k as f64 + 0.5) / steps;
            q.mount += (board - q.mount) * share;
        }
        last = *q;
    }
}

/// What one recording has for itself: poses, temperature, noise.
fn own(motion: u64) -> Dice {
    Dice(motion.wrapping_mul(517) + 29)
}

/// The same courier and effects (`seed`), other poses and noise (`motion`).
pub fn record_as(
    seed: u64,
    motion: u64,
    effects: &[(&str, f64)],
    o: &Options,
) -> (Recording, Courier) {
    let mut d = Dice(seed.wrapping_mul(77) + 5);
    let u = Courier::draw(&mut d);
    let mut list: Vec<Effect> = effects
        .iter()
        .map(|(n, s)| Effect::draw(n, &mut d, *s))
        .collect();
    // An effect's size is the courier's: it is stated over the first recording's motion, whichever is made.
    let usual = || Dice(seed.wrapping_mul(991) + 3);
    let mut first = program(&u, &mut usual(), &mut own(seed), o, &mut Vec::new());
    warm_through(&mut first, o.mount_s);
    let all = first.last().map_or(1.0, |q| q.t);
    for e in &mut list {
        scale(e, &u, &first, all);
    }
    let mut m = own(motion);
    let mut names = Vec::new();
    let mut truth = program(&u, &mut usual(), &mut m, o, &mut names);
    for q in &mut truth {
        q.temp += o.warmer_k;
    }
    warm_through(&mut truth, o.mount_s);
    let samples = measure(&u, &list, &truth, &names, all, &mut m, o);
    let meta = Meta {
        device: "rig".into(),
        names: recording::Names::default(),
        source: format!("independent rig, seed {seed}"),
        geometry: Geometry {
            pitch_m: u.pitch,
            span_m: Some(u.span),
            lateral_m: Some(u.lo),
        },
        coordination: o.beacon.then(|| Coordination {
            height_m: u.h * 1.03,
            lever_x_m: u.l[0] * 0.98,
            lever_y_m: u.l[1] * 1.04,
            tan_full_scale: u.fs,
        }),
        electronics: Electronics {
            adc_bits: Some(16),
            amplitude_counts: Some(u.amp),
            quadrature_noise_counts: Some(u.noise),
            psd_sum_counts: Some(u.sum),
            psd_noise_counts: Some(u.psd_noise),
            position_noise_m: if o.counts {
                None
            } else {
                Some(u.noise / u.amp * u.pitch / TAU)
            },
        },
    };
    (
        Recording {
            meta,
            samples,
            warnings: Vec::new(),
        },
        u,
    )
}

/// Makes the rms of what an effect adds, over the samples where it acts, what was asked for.
fn scale(e: &mut Effect, u: &Courier, truth: &[Truth], all: f64) {
    let asked = e.size;
    e.size = 1.0;
    let (mut sum, mut n) = (0.0, 0.0);
    for q in truth.iter().step_by(7) {
        let d = e.displace(u, q, all);
        let mean = d.iter().map(|v| v * v).sum::<f64>() / 4.0;
        let t = beacon(u, q, [0.0; 2]);
        let z = if q.seen {
            e.deflect(u, q, t, all)
        } else {
            [0.0; 2]
        };
        let both = mean + (z[0] * z[0] + z[1] * z[1]) / 2.0;
        if both > 0.0 {
            sum += both;
            n += 1.0;
        }
    }
    e.size = if n > 0.0 {
        asked / (sum / n).sqrt()
    } else {
        asked
    };
}
