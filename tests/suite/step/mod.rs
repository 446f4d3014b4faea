//! The signal path from counts to frame: what the documentation quotes, every status bit, and no surprise for any input.

mod any_input;
mod configuration;
mod missed;
mod phase;
mod pose;
mod status;
mod terms;

use courier_sensor::frame::{Frame, RawFrame, SEGMENTS};
use courier_sensor::geometry::Geometry;
use courier_sensor::model::{ErrorModel, TermTable};
use courier_sensor::settings::Settings;
use courier_sensor::step::{StepConfig, StepState, step};
use std::f64::consts::TAU;

const PITCH_M: f64 = Geometry::PAPER.pitch_m as f64;
const BEACON: [i16; 4] = [6000, 5000, 5500, 5500];

/// Counts of a perfect pair.
fn pair(amplitude: f64, turns: f64) -> [i16; 2] {
    let (s, c) = (turns * TAU).sin_cos();
    [
        (amplitude * s).round() as i16,
        (amplitude * c).round() as i16,
    ]
}

/// A frame of perfect pairs at these positions in turns, with a beacon.
fn raw(turns: [f64; SEGMENTS]) -> RawFrame {
    RawFrame {
        quadrature_counts: turns.map(|t| pair(25_000.0, t)),
        electrode_counts: BEACON,
        ..RawFrame::default()
    }
}

/// Segments' positions in turns from x, y and half the difference of a pair.
fn at(x: f64, y: f64, half: f64) -> [f64; SEGMENTS] {
    [x + half, y + half, x - half, y - half]
}

fn calibrated() -> Settings {
    Settings {
        model: Some(ErrorModel::zero(TermTable::equation_3())),
        ..Settings::default()
    }
}

fn run(settings: &Settings, raws: impl IntoIterator<Item = RawFrame>) -> Vec<Frame> {
    let config = StepConfig::build(settings).unwrap();
    let mut state = StepState::new();
    raws.into_iter()
        .map(|raw| step(&config, &mut state, &raw))
        .collect()
}
