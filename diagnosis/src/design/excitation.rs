//! What a recording, and motions that may follow it, would show of each effect: products of columns, before anything is fitted.
//!
//! The recording is calibrated, and each motion that may follow is laid behind it as the calibrated sensor would read it, without noise. All
//! have the same columns, so products are added: the recording's and those of the motions that are made.

use crate::Insufficient;
use crate::data::observations::Observations;
use crate::data::slips::repair_slips;
use crate::data::tooth_counts::align_pairs;
use crate::design::gram::{Block, Columns, Products, products_by_part};
use crate::linearization::baseline::Baseline;
use crate::linearization::calibrate::{baseline_columns, calibrate};
use crate::linearization::recording::LinearizedRecording;
use courier_signal::equations::{Angle, beacon, outputs};
use effects::sensor::BasisInputs;
use recording::{Recording, Row, Samples};
use std::f64::consts::TAU;

/// A motion that may follow, from where the courier stands.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    /// Steps from there: along x and y, m, and the turn, rad; one every [`Path::step_s`].
    pub steps: Vec<[f64; 3]>,
    /// Time from one to the next, s.
    pub step_s: f64,
}

/// The answer.
#[derive(Clone, Debug)]
pub struct Excitation {
    /// Which columns are whose: the baseline first, then each effect that the recording or a path could show.
    pub blocks: Vec<Block>,
    /// Name of each column.
    pub names: Vec<String>,
    /// Unit of each amount.
    pub units: Vec<&'static str>,
    /// Prior deviation of each amount, in that unit.
    pub deviations: Vec<f64>,
    /// What an amount of one prior deviation does to the readings, rms over the recording and all paths, m.
    pub sizes_m: Vec<f64>,
    /// What recording and paths offer.
    pub inputs: BasisInputs,
    /// Of the recording.
    pub so_far: Products,
    /// Of each path.
    pub paths: Vec<Products>,
}

/// Beyond this share of full scale the spot is counted as at the diode's edge. A prior: a spot has some width, and the last hundredths cut it off.
const EDGE: f64 = 0.95;
/// Time between two motions, s. A prior: an order, its reply, and the board's stream take about as long on the simulated board.
pub const PAUSE_S: f64 = 0.1;

/// What a recording and each of some paths shows.
///
/// # Errors
/// The recording cannot be calibrated yet: too few samples.
pub fn excitation(recording: &Recording, paths: &[Path]) -> Result<Excitation, Insufficient> {
    let mut before = Observations::new(recording)?;
    repair_slips(&mut before);
    align_pairs(&mut before);
    let made = before.len();
    let baseline = calibrate(&before, &vec![true; made]);
    let (both, part) = with_paths(recording, &Stand::new(&before, &baseline), paths);
    let mut observations = Observations::new(&both)?;
    repair_slips(&mut observations);
    align_pairs(&mut observations);
    side_by_side(&mut observations.t_s, &part);
    let mut linearized =
        LinearizedRecording::new(&observations, baseline, vec![true; observations.len()]);
    linearized.inputs.duration_s = span_s(&observations.t_s);
    let columns = columns(&linearized);
    let (mut sums, deviations) = products_by_part(&linearized, &columns, &part, 1 + paths.len());
    let so_far = sums.remove(0);
    let regressors = &columns.regressors;
    Ok(Excitation {
        names: regressors.iter().map(|r| r.name.clone()).collect(),
        units: regressors.iter().map(|r| r.unit).collect(),
        sizes_m: regressors.iter().map(|r| r.size_m).collect(),
        blocks: columns.blocks,
        inputs: linearized.inputs.clone(),
        deviations,
        so_far,
        paths: sums,
    })
}

/// The baseline's columns, and those of each effect.
fn columns(linearized: &LinearizedRecording) -> Columns {
    let mut columns = baseline_columns(linearized);
    for effect in effects::sensor_sides() {
        let regressors = effect.regressors(&linearized.inputs);
        if !regressors.is_empty() {
            columns.push(effect.name(), regressors);
        }
    }
    columns
}

/// Where the courier stands at the end of a recording, and how its sensor reads.
struct Stand<'a> {
    before: &'a Observations,
    baseline: &'a Baseline,
    /// Calibrated outputs there, m.
    outputs_m: [f64; 4],
    amplitude_counts: f64,
    sees_beacon: bool,
}

impl<'a> Stand<'a> {
    fn new(before: &'a Observations, baseline: &'a Baseline) -> Self {
        let last = |s: usize| {
            let known = before.position_m[s].iter().rev().find(|p| p.is_finite());
            let known = known.copied().unwrap_or(0.0);
            baseline.calibrated(s, known, before.pitch_m).0
        };
        Self {
            outputs_m: std::array::from_fn(last),
            amplitude_counts: before.stated_amplitude_counts.max(1.0),
            sees_beacon: !before.tan_psi[0].is_empty(),
            before,
            baseline,
        }
    }

    /// A row of what is read after a step.
    fn row<'r>(&self, [x, y, turn]: [f64; 3], t_s: f64, run: &'r str, like: &Row) -> Row<'r> {
        let o = self.before;
        let moved = outputs([x, y], turn, o.span_m);
        let p: [f64; 4] = std::array::from_fn(|s| self.outputs_m[s] + moved[s]);
        let raw: [f64; 4] = std::array::from_fn(|s| self.baseline.unmodified(s, p[s], o.pitch_m));
        let pairs = raw.map(|p| {
            let (sine, cosine) = (TAU * p / o.pitch_m).sin_cos();
            [sine, cosine].map(|v| self.amplitude_counts * v)
        });
        let teeth = |s: usize| {
            let [sine, cosine] = pairs[s];
            (raw[s] / o.pitch_m - sine.atan2(cosine) / TAU).round() as i32
        };
        Row {
            t_s,
            run,
            quadrature_counts: pairs.map(Some),
            teeth: std::array::from_fn(|s| Some(teeth(s))),
            electrode_counts: self.electrodes(&p),
            temperature_c: like.temperature_c,
            ..Row::default()
        }
    }

    /// Electrodes, where the beacon is seen: what makes g_x and g_y zero.
    fn electrodes(&self, p: &[f64; 4]) -> Option<[f64; 4]> {
        if !self.sees_beacon {
            return None;
        }
        let (o, b) = (self.before, self.baseline);
        let theta = courier_signal::equations::theta(p, o.span_m);
        let centre = courier_signal::equations::middle(p);
        let angle = Angle::of_rad(theta);
        let place = [0, 1].map(|axis| b.origin_m[axis] + b.lever_m[axis]);
        let without = beacon(centre, [0.0; 2], b.lever_m, place, &angle).g;
        // The displacement enters g turned by the angle: by two unit displacements.
        let by = [[1.0, 0.0], [0.0, 1.0]].map(|unit: [f64; 2]| {
            let g = beacon(centre, unit, b.lever_m, place, &angle).g;
            [g[0] - without[0], g[1] - without[1]]
        });
        let det = by[0][0] * by[1][1] - by[1][0] * by[0][1];
        let displaced = [
            (by[1][0] * without[1] - by[1][1] * without[0]) / det,
            (by[0][1] * without[0] - by[0][0] * without[1]) / det,
        ];
        let tan = displaced.map(|d| d / b.height_m / o.tan_full_scale);
        let seen = tan.iter().all(|t| t.abs() < EDGE);
        let half = 1.0e4;
        seen.then(|| [1.0 + tan[0], 1.0 - tan[0], 1.0 + tan[1], 1.0 - tan[1]].map(|v| half * v))
    }
}

/// The recording with all paths behind it, and the part that each sample belongs to: 0 is the recording.
fn with_paths(recording: &Recording, stand: &Stand, paths: &[Path]) -> (Recording, Vec<u16>) {
    let made = recording.samples.len();
    let mut samples = recording.samples.clone();
    let mut part = vec![0; made];
    let like = recording.samples.row(made - 1);
    let mut t_s = like.t_s + PAUSE_S;
    for (number, path) in paths.iter().enumerate() {
        let run = format!("path {number}");
        for step in &path.steps {
            samples.push(&stand.row(*step, t_s, &run, &like));
            part.push(1 + number as u16);
            t_s += path.step_s;
        }
        t_s += PAUSE_S;
    }
    let logged: Vec<_> = recording.samples.logged().to_vec();
    let samples = relogged(samples, logged);
    let both = Recording {
        meta: recording.meta.clone(),
        samples,
        warnings: Vec::new(),
    };
    (both, part)
}

/// Logged columns as long as the samples are now.
fn relogged(samples: Samples, logged: Vec<recording::Logged>) -> Samples {
    if logged.is_empty() {
        return samples;
    }
    let mut out = Samples::default();
    (0..samples.len()).for_each(|i| out.push(&samples.row(i)));
    logged.into_iter().for_each(|column| out.log(column));
    out
}

/// Every path begins when the recording has ended: only one of them will be made.
fn side_by_side(t_s: &mut [f64], part: &[u16]) {
    let made = part.iter().filter(|p| **p == 0).count();
    let mut shift_s = 0.0;
    for i in made..t_s.len() {
        if part[i] != part[i - 1] {
            shift_s = t_s[i] - (t_s[made - 1] + PAUSE_S);
        }
        t_s[i] -= shift_s;
    }
}

fn span_s(t_s: &[f64]) -> f64 {
    let most = t_s.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    most - t_s.first().copied().unwrap_or(0.0)
}
