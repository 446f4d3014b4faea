//! Shapes over time that repeat at a frequency: lines of the segments, of the beacon, of one pair, and of the diode's gain.

use crate::design::nameless::{CHANNEL, SIZE_M};
use effects::sensor::SLOWEST_LINE_HZ;
use effects::sensor::{BasisInputs, Covariates, Regressor};
use std::f64::consts::TAU;

/// Every line that stands out and that no effect owns.
pub fn lines(inputs: &BasisInputs) -> Vec<Regressor> {
    let mut list = Vec::new();
    for &hz in &inputs.segment_lines_hz {
        for s in (0..4).filter(|s| inputs.segments[*s]) {
            let name = |part| format!("{hz:.3} Hz {part}, segment {}", s + 1);
            list.push(Regressor::reading(name("sine"), "m", SIZE_M, s, move |m| {
                (TAU * hz * m.t_s).sin()
            }));
            list.push(Regressor::reading(
                name("cosine"),
                "m",
                SIZE_M,
                s,
                move |m| (TAU * hz * m.t_s).cos(),
            ));
        }
    }
    // Too slow for a mount of the beacon.
    for &hz in inputs
        .beacon_lines_hz
        .iter()
        .filter(|hz| **hz < SLOWEST_LINE_HZ)
    {
        for channel in (1..3).filter(|_| inputs.beacon) {
            for (part, quarter) in [("sine", 0.0), ("cosine", 0.25 * TAU)] {
                let name = format!("{hz:.3} Hz {part} on {}", CHANNEL[channel]);
                list.push(Regressor::channel(name, "m", SIZE_M, channel, move |m| {
                    (TAU * hz * m.t_s + quarter).sin()
                }));
            }
        }
    }
    for s in (0..4).filter(|s| inputs.segments[*s]) {
        for &hz in &inputs.pair_lines_hz[s] {
            list.extend(hum(s, hz));
        }
    }
    for &hz in inputs.flicker_hz.iter().filter(|_| inputs.beacon) {
        list.extend(flicker(hz));
    }
    list
}

/// A line in the gain along either axis, and beside it: the light that flickers has a centre of its own.
fn flicker(hz: f64) -> Vec<Regressor> {
    let mut list = Vec::new();
    for axis in 0..2 {
        for (part, quarter) in [("sine", 0.0), ("cosine", 0.25 * TAU)] {
            let wave = move |m: &Covariates| (TAU * hz * m.t_s + quarter).sin();
            let name = |of: &str| format!("{hz:.3} Hz {part} {of}, {}", CHANNEL[1 + axis]);
            let mut push = |name, value: Box<dyn Fn(&Covariates) -> f64 + Send + Sync>| {
                list.push(Regressor::channel(name, "m", SIZE_M, 1 + axis, value));
            };
            push(
                name("times deflection"),
                Box::new(move |m| wave(m) * m.deflection[axis]),
            );
            push(name("beside it"), Box::new(wave));
        }
    }
    list
}

/// A line in the sine or the cosine of a pair.
fn hum(s: usize, hz: f64) -> Vec<Regressor> {
    let part = [("sine", 0.0), ("cosine", 0.25 * TAU)];
    let both = part
        .iter()
        .flat_map(|time| part.iter().map(move |phase| (time, phase)));
    both.map(|(&(time, late), &(phase, quarter))| {
        let name = format!("{hz:.3} Hz {time} times {phase}, segment {}", s + 1);
        Regressor::reading(name, "m", SIZE_M, s, move |m| {
            (TAU * hz * m.t_s + late).sin() * (m.raw_phase[s] + quarter).sin()
        })
    })
    .collect()
}
