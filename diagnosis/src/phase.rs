//! A vibration on another recording: frequencies and amplitudes are the model's, and its phase is as arbitrary as the zero of
//! time. One shift a line and axis is found: what drives a mount along one drives it along the other at another time. Nothing is
//! scaled.

use crate::gram::{Columns, Gram, folds, solve};
use crate::report::Magnitude;
use crate::scene::Scene;
use effects::beacon_vibration::sensor_side::SLOWEST_HZ;
use effects::sensor::{Moment, Regressor};
use std::f64::consts::TAU;

/// The effect whose phase is arbitrary.
pub const VIBRATION: &str = "beacon_vibration";
/// So large that the prior does not hold a phase.
const FREE_M: f64 = 1.0e-3;

/// Each line along either axis as the model has it, and the same a quarter turn later.
pub fn waves(amounts: &[Magnitude], lines_hz: &[f64]) -> Vec<Regressor> {
    let mut list = Vec::new();
    for &hz in lines_hz.iter().filter(|hz| **hz >= SLOWEST_HZ) {
        for (axis, label) in ["x", "y"].into_iter().enumerate() {
            let [a, b] = ["sine", "cosine"].map(|part| {
                let name = format!("{hz:.3} Hz {part}, {label}");
                let found = amounts.iter().find(|a| a.name == name);
                found.map_or(0.0, |a| a.value)
            });
            // What swells beside a line belongs to its own recording's time, and has no amounts.
            if a == 0.0 && b == 0.0 {
                continue;
            }
            for (later, quarter) in [("", 0.0), (", a quarter turn later", 0.25 * TAU)] {
                let name = format!("{hz:.3} Hz, {label}{later}");
                list.push(Regressor::channel(
                    name,
                    "1",
                    FREE_M,
                    1 + axis,
                    move |m: &Moment| {
                        let (sine, cosine) = (TAU * hz * m.t_s + quarter).sin_cos();
                        a * sine + b * cosine
                    },
                ));
            }
        }
    }
    list
}

/// Finds each line's phase along each axis and holds it; the amplitude stays the model's.
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A line along both axes has a phase along each; one that a model does not know along an axis has none there.
    #[test]
    fn each_axis_has_its_own_phase() {
        let amount = |name: &str| Magnitude {
            name: name.into(),
            value: 1.0e-6,
            unit: "m".into(),
        };
        let known = [
            "30.000 Hz sine, x",
            "30.000 Hz cosine, y",
            "40.000 Hz sine, y",
        ]
        .map(amount);
        let names: Vec<String> = waves(&known, &[30.0, 40.0])
            .into_iter()
            .map(|wave| wave.name)
            .collect();
        let wanted = ["30.000 Hz, x", "30.000 Hz, y", "40.000 Hz, y"];
        let wanted = wanted.map(|name| [name.to_string(), format!("{name}, a quarter turn later")]);
        assert_eq!(names, wanted.concat());
    }
}
