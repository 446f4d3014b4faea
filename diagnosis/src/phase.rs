//! A vibration on another recording: frequencies and amplitudes are the model's, and its phase is as arbitrary as the zero of
//! time. One shift a line is found, common to both axes; nothing is scaled.

use crate::gram::{Columns, Gram, folds, solve};
use crate::report::Magnitude;
use crate::scene::Scene;
use effects::beacon_vibration::sensor_side::SLOWEST_HZ;
use effects::sensor::{Action, CHANNELS, Moment, Regressor};
use std::f64::consts::TAU;

/// The effect whose phase is arbitrary.
pub const VIBRATION: &str = "beacon_vibration";
/// So large that the prior does not hold a phase.
const FREE_M: f64 = 1.0e-3;

/// Each line as the model has it, and the same a quarter turn later.
pub fn waves(amounts: &[Magnitude], lines_hz: &[f64]) -> Vec<Regressor> {
    let mut list = Vec::new();
    for &hz in lines_hz.iter().filter(|hz| **hz >= SLOWEST_HZ) {
        let amount = |part: &str, axis: usize| {
            let name = format!("{hz:.3} Hz {part}, {}", ["x", "y"][axis]);
            let found = amounts.iter().find(|a| a.name == name);
            found.map_or(0.0, |a| a.value)
        };
        let axes = [0, 1].map(|axis| [amount("sine", axis), amount("cosine", axis)]);
        // What swells beside a line belongs to its own recording's time, and has no amounts.
        if axes.iter().flatten().all(|a| *a == 0.0) {
            continue;
        }
        for (label, quarter) in [("", 0.0), (", a quarter turn later", 0.25 * TAU)] {
            let add = move |m: &Moment, out: &mut [f64; CHANNELS]| {
                let (sine, cosine) = (TAU * hz * m.t_s + quarter).sin_cos();
                for (axis, [a, b]) in axes.iter().enumerate() {
                    out[1 + axis] += a * sine + b * cosine;
                }
            };
            list.push(Regressor {
                name: format!("{hz:.3} Hz{label}"),
                unit: "1",
                size_m: FREE_M,
                deviation: None,
                mean: 0.0,
                during: effects::sensor::ALWAYS,
                action: Action::Channels(Box::new(add)),
            });
        }
    }
    list
}

/// Finds each line's phase and holds it; the amplitude stays the model's.
pub fn align(scene: &Scene, columns: &mut Columns) {
    let Some(block) = columns.blocks.iter().find(|b| b.name == VIBRATION) else {
        return;
    };
    let lines: Vec<usize> = block.columns.clone().step_by(2).collect();
    let gram = Gram::new(scene, columns, &folds(&scene.observations.stretch));
    let list: Vec<usize> = columns.blocks[0]
        .columns
        .clone()
        .chain(block.columns.clone())
        .collect();
    let fit = solve(gram.training(None), &list, &gram.centre, 1.0);
    for c in lines {
        let amount = |c: usize| {
            let at = list.iter().position(|k| *k == c);
            let found = fit.as_ref().zip(at);
            found.map_or(0.0, |(fit, at)| fit.amount[at] * gram.scale[c])
        };
        let turn = amount(c + 1).atan2(amount(c));
        (columns.centre[c + 1], columns.centre[c]) = turn.sin_cos();
        (columns.held[c], columns.held[c + 1]) = (true, true);
    }
}
