//! A vibration on another recording: frequencies and amplitudes are the model's, and its phase is as arbitrary as the zero of
//! time. One shift a line and axis is found: what drives a mount along one drives it along the other at another time. What drives it keeps
//! no time from run to run, nor turns as evenly: each stretch then shifts all lines of a resonance together. Nothing is scaled.

use crate::data::folds::folds;
use crate::design::gram::{Columns, Gram};
use crate::inference::fit::coefficients;
use crate::linearization::recording::{LinearizedRecording, range};
use crate::spectra::resonance::RESONANCE;
use crate::verdict::answer::Magnitude;
use effects::Detection;
use effects::sensor::SLOWEST_LINE_HZ;
use effects::sensor::{Covariates, Regressor};
use std::f64::consts::TAU;
use std::ops::Range;

/// So large that the prior does not hold a phase: a millimetre, a thousand times a vibration of some micrometres.
const FREE_PHASE_M: f64 = 1.0e-3;
/// Samples of a stretch that tell a phase. Derived from its error: a phase of a line as large as the noise is told to √(2/100),
/// 0.14 rad.
const TELLING: usize = 100;
/// Beats in a stretch that part two lines: nearer ones shift together. Derived from sinc: with two beats in a stretch the sum of
/// two lines is told from one at every phase of theirs.
const PARTING_BEATS: f64 = 2.0;

/// One frequency along one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    hz: f64,
    axis: usize,
    /// Of sine and cosine, m.
    amounts_m: [f64; 2],
}

impl Line {
    /// Those of a model that it has an amount of: what swells beside a line belongs to its own recording's time, and has none.
    pub fn all(amounts: &[Magnitude], lines_hz: &[f64]) -> Vec<Self> {
        let lines = lines_hz.iter().filter(|hz| **hz >= SLOWEST_LINE_HZ);
        let along = lines.flat_map(|hz| [(*hz, 0, "x"), (*hz, 1, "y")]);
        let line = |(hz, axis, label): (f64, usize, &str)| Self {
            hz,
            axis,
            amounts_m: ["sine", "cosine"].map(|part| {
                let name = format!("{hz:.3} Hz {part}, {label}");
                let found = amounts.iter().find(|a| a.name == name);
                found.map_or(0.0, |a| a.value)
            }),
        };
        along
            .map(line)
            .filter(|line| line.amounts_m != [0.0; 2])
            .collect()
    }

    /// The same by an angle later, rad.
    fn later(self, angle: f64) -> Self {
        let ([a, b], (sine, cosine)) = (self.amounts_m, angle.sin_cos());
        Self {
            amounts_m: [a * cosine - b * sine, b * cosine + a * sine],
            ..self
        }
    }

    fn at(&self, t_s: f64) -> f64 {
        let (sine, cosine) = (TAU * self.hz * t_s).sin_cos();
        self.amounts_m[0] * sine + self.amounts_m[1] * cosine
    }
}

/// Each line as the model has it, and the same a quarter turn later.
pub fn waves(lines: &[Line]) -> Vec<Regressor> {
    let wave = |line: &Line| {
        let name = format!("{:.3} Hz, {}", line.hz, ["x", "y"][line.axis]);
        both_quarters(name, vec![*line], None)
    };
    lines.iter().flat_map(wave).collect()
}

/// Lines along one axis together, and the same a quarter turn later: in one stretch or in all.
fn both_quarters(name: String, lines: Vec<Line>, stretch: Option<usize>) -> [Regressor; 2] {
    [("", 0.0), (", a quarter turn later", 0.25 * TAU)].map(|(later, quarter)| {
        let lines: Vec<Line> = lines.iter().map(|line| line.later(quarter)).collect();
        let channel = 1 + lines.first().map_or(0, |line| line.axis);
        let value = move |m: &Covariates| {
            let here = stretch.is_none_or(|k| k == m.stretch);
            let lines = lines.iter().filter(|_| here);
            lines.map(|line| line.at(m.t_s)).sum()
        };
        Regressor::channel(format!("{name}{later}"), "1", FREE_PHASE_M, channel, value)
    })
}

/// Finds the phase of each of `lines` and holds it, then what each stretch shifts; the amplitude stays the model's.
pub fn align(linearized: &LinearizedRecording, columns: &mut Columns, lines: &[Line]) {
    let Some(block) = columns
        .blocks
        .iter()
        .find(|b| effects::is(&b.name, Detection::ByLines))
    else {
        return;
    };
    let block = block.columns.clone();
    let turns = turns(linearized, columns, block, 0.0);
    let turned: Vec<Line> = lines
        .iter()
        .zip(turns)
        .map(|(l, turn)| l.later(turn))
        .collect();
    let mut shifted = Vec::new();
    for (stretch, length_s) in telling(linearized) {
        for (n, together) in resonances(&turned, length_s).into_iter().enumerate() {
            let name = format!("resonance {n}, stretch {stretch}");
            shifted.extend(both_quarters(name, together, Some(stretch)));
        }
    }
    let start = columns.regressors.len();
    columns.push("phase of each stretch", shifted);
    self::turns(linearized, columns, start..columns.regressors.len(), 1.0);
}

/// Finds by how much each pair of columns of a block is later, and holds it there: beside what is there of the first of them already.
fn turns(
    linearized: &LinearizedRecording,
    columns: &mut Columns,
    block: Range<usize>,
    there: f64,
) -> Vec<f64> {
    let gram = Gram::new(
        linearized,
        columns,
        &folds(&linearized.observations.stretch),
    );
    let found = coefficients(&gram, columns);
    let turn = |c: usize| {
        let amount = |c: usize| found[c] * gram.scale[c];
        let turn = amount(c + 1).atan2(there + amount(c));
        columns.centre[c] = turn.cos() - there;
        columns.centre[c + 1] = turn.sin();
        (columns.held[c], columns.held[c + 1]) = (true, true);
        turn
    };
    block.step_by(2).map(turn).collect()
}

/// Stretches with enough samples of the beacon, and how long they see it, s.
fn telling(linearized: &LinearizedRecording) -> Vec<(usize, f64)> {
    let o = linearized.observations;
    let mut seen_s = vec![Vec::new(); o.stretch.last().map_or(0, |last| last + 1)];
    let samples = (0..linearized.len()).filter(|i| linearized.mask[*i] && o.sees_beacon(*i));
    samples.for_each(|i| seen_s[o.stretch[i]].push(o.t_s[i]));
    let telling = seen_s
        .iter()
        .enumerate()
        .filter(|(_, seen_s)| seen_s.len() >= TELLING);
    telling
        .filter_map(|(k, seen_s)| range(seen_s).map(|[from, to]| (k, to - from)))
        .collect()
}

/// Lines of one axis that are within a resonance, or that a stretch of this length does not part.
fn resonances(lines: &[Line], length_s: f64) -> Vec<Vec<Line>> {
    let mut sorted = lines.to_vec();
    sorted.sort_by(|a, b| a.axis.cmp(&b.axis).then(a.hz.total_cmp(&b.hz)));
    let near = |a: &Line, b: &Line| {
        let apart = b.hz - a.hz;
        a.axis == b.axis && (apart < RESONANCE * b.hz || apart * length_s < PARTING_BEATS)
    };
    sorted.chunk_by(near).map(<[Line]>::to_vec).collect()
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
            deviation: None,
            unit: "m".into(),
        };
        let known = [
            "30.000 Hz sine, x",
            "30.000 Hz cosine, y",
            "40.000 Hz sine, y",
        ]
        .map(amount);
        let names: Vec<String> = waves(&Line::all(&known, &[30.0, 40.0]))
            .into_iter()
            .map(|wave| wave.name)
            .collect();
        let wanted = ["30.000 Hz, x", "30.000 Hz, y", "40.000 Hz, y"];
        let wanted = wanted.map(|name| [name.to_string(), format!("{name}, a quarter turn later")]);
        assert_eq!(names, wanted.concat());
    }

    /// What beats with a line shifts with it, and what a stretch is too short to part.
    #[test]
    fn lines_of_a_resonance_shift_together() {
        let line = |hz: f64, axis: usize| Line {
            hz,
            axis,
            amounts_m: [1.0e-6, 0.0],
        };
        let lines = [line(60.0, 0), line(30.0, 0), line(30.5, 0), line(30.2, 1)];
        let sizes = |length_s: f64| -> Vec<usize> {
            let together = resonances(&lines, length_s);
            together.iter().map(Vec::len).collect()
        };
        assert_eq!(sizes(10.0), [2, 1, 1]);
        assert_eq!(sizes(0.05), [3, 1]);
    }
}
