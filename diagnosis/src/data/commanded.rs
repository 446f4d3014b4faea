//! Commanded poses that cannot be true: in another unit, of another sign, earlier or later than the readings, or of something else.
//!
//! A command is good to some tens of micrometres, so it tells which tooth a segment stands over. It does so only if it follows the
//! readings: first the slope of the one over the other is looked at (a sign, a unit), then the time between them. What follows after
//! that is used as it was mended, and said; what does not is left aside, and said.

use crate::algebra::statistics::{median, quantile};
use crate::data::observations::Observations;
use crate::data::slips::{MOST_STEPS, whole_teeth};
use crate::linearization::recording::range;
use std::ops::Range;

/// Names of the columns.
const NAMES: [&str; 3] = ["cmd_x_m", "cmd_y_m", "cmd_theta_rad"];
/// Samples between the two whose differences are compared. Derived from a slow courier: at 10 mm/s and a millisecond a sample
/// four go 40 µm, as much as a command is good to.
const DIFFERENCE_SAMPLES: usize = 4;
/// A slope is that of a unit to within this share: stated pitches and spans are better than that. Derived from the units
/// themselves: the nearest two, an inch and a centimetre, are a factor of 2.54 apart, and the stated pitch and span that the
/// slope depends on are known better.
const SLOPE: f64 = 0.2;
/// Latest and earliest command that is looked for, s. A prior: commands have been seen to be late by 50 ms, and ten times that is
/// looked at.
const LATEST_S: f64 = 0.5;
/// Steps of the search for it, each way; then it is halved so often about the best. Derived from what moves: at 0.05 m/s a step
/// of 20 ms is a tooth, and eight halvings come to 0.08 ms, 4 µm of that way, which is less than any command is good to.
const DELAY_STEPS: i32 = 25;
/// See [`DELAY_STEPS`].
const DELAY_HALVINGS: usize = 8;
/// A command is later if the residual then is less than this share of what it was (a choice, without data),
const LESS: f64 = 0.5;
/// and was more than this share of a pitch: some tens of micrometres are a command's own. A prior: the paper's positions without
/// calibration are off by 8.9 µm (3.1.2), and what a controller adds is some tens of micrometres, where a twentieth of a pitch is
/// 51.
const OWN: f64 = 0.05;
/// Samples that the time is found by. A bound on the work: of longer recordings every so many are taken, which tell a mean
/// distance to 2 % all the same.
const COMPARED_SAMPLES: usize = 3000;
/// Nearer than this share of a pitch a command must come to tell one tooth from the next. Derived from the halves between teeth:
/// at half a pitch the next tooth is as near, and a quarter leaves as much for the readings' own errors.
const TELLS: f64 = 0.25;

/// Units that poses are written in for m and rad: how many of these one is.
const LENGTHS: [(f64, &str); 5] = [
    (1.0, "m"),
    (1.0e-3, "mm"),
    (1.0e-2, "cm"),
    (1.0e-6, "µm"),
    (0.0254, "inches"),
];
/// See [`LENGTHS`].
const ANGLES: [(f64, &str); 3] = [
    (1.0, "rad"),
    (std::f64::consts::PI / 180.0, "degrees"),
    (1.0e-3, "mrad"),
];

/// Mends or empties the commanded columns; what was done, a line each.
pub fn repair(o: &mut Observations) -> Vec<String> {
    let mut notes = Vec::new();
    for axis in 0..3 {
        let Some(read_m) = readings_m(o, axis) else {
            continue;
        };
        let arm = if axis == 2 { 0.5 * o.span_m } else { 1.0 };
        let commanded_m: Vec<f64> = o.commanded[axis].iter().map(|c| arm * c).collect();
        if commanded_m.is_empty() {
            continue;
        }
        let pair = Pair {
            t_s: &o.t_s,
            pieces: pieces(&o.run),
            read_m,
            commanded_m,
            pitch_m: o.pitch_m,
        };
        let units = if axis == 2 { &ANGLES[..] } else { &LENGTHS };
        match pair.repaired(units) {
            ColumnRepair::AsItIs => {}
            ColumnRepair::Changed(commanded_m, how) => {
                o.commanded[axis] = commanded_m.iter().map(|c| c / arm).collect();
                notes.push(format!("{}: {how}", NAMES[axis]));
            }
            ColumnRepair::LeftAside => {
                o.commanded[axis].clear();
                notes.push(format!(
                    "{}: does not follow the readings, to a quarter of a pitch wanted: left aside",
                    NAMES[axis]
                ));
            }
        }
    }
    notes
}

/// What the segments say of a coordinate, m; half the difference of a pair for the angle. None without a segment that tells it.
fn readings_m(o: &Observations, axis: usize) -> Option<Vec<f64>> {
    let at = |s: usize, i: usize| o.position_m[s].get(i).copied();
    let value = |i: usize| match axis {
        2 => {
            let half = |s: usize| Some(0.5 * (at(s, i)? - at(s + 2, i)?));
            half(0).or_else(|| half(1))
        }
        _ => match (at(axis, i), at(axis + 2, i)) {
            (Some(a), Some(b)) => Some(0.5 * (a + b)),
            (a, b) => a.or(b),
        },
    };
    (0..o.len()).map(value).collect()
}

/// Samples of one run that follow each other.
pub(crate) fn pieces(run: &[usize]) -> Vec<Range<usize>> {
    let mut list: Vec<Range<usize>> = Vec::new();
    for i in 0..run.len() {
        match list.last_mut() {
            Some(last) if run[last.start] == run[i] => last.end = i + 1,
            _ => list.push(i..i + 1),
        }
    }
    list
}

/// What became of a column.
#[derive(Debug, PartialEq)]
enum ColumnRepair {
    AsItIs,
    /// Its values, m, and what was done.
    Changed(Vec<f64>, String),
    LeftAside,
}

/// A coordinate as it was read and as it was told.
struct Pair<'a> {
    t_s: &'a [f64],
    pieces: Vec<Range<usize>>,
    read_m: Vec<f64>,
    commanded_m: Vec<f64>,
    pitch_m: f64,
}

impl Pair<'_> {
    fn repaired(&self, units: &[(f64, &str)]) -> ColumnRepair {
        let fine_m = TELLS * self.pitch_m;
        if travel(&self.read_m) < fine_m && travel(&self.commanded_m) < fine_m {
            return ColumnRepair::AsItIs;
        }
        let Some((factor, unit)) = self.unit(units) else {
            return ColumnRepair::LeftAside;
        };
        let scaled: Vec<f64> = self.commanded_m.iter().map(|c| factor * c).collect();
        let delay_s = self.delay_s(&scaled);
        let there: Vec<f64> = if delay_s == 0.0 {
            scaled
        } else {
            (0..scaled.len())
                .map(|i| self.at(&scaled, i, delay_s))
                .collect()
        };
        if !self.tells_teeth(&there) {
            return ColumnRepair::LeftAside;
        }
        let mut how = Vec::new();
        if factor.abs() != 1.0 {
            how.push(format!(
                "is written in {unit}, {} wanted: taken as {unit}",
                units[0].1
            ));
        }
        if factor < 0.0 {
            how.push("runs against the readings: taken with the other sign".into());
        }
        if delay_s != 0.0 {
            let word = if delay_s > 0.0 { "after" } else { "before" };
            how.push(format!(
                "comes {:.0} ms {word} the readings: laid over them",
                1.0e3 * delay_s.abs()
            ));
        }
        if how.is_empty() {
            ColumnRepair::AsItIs
        } else {
            ColumnRepair::Changed(there, how.join("; "))
        }
    }

    /// The unit and sign by the slope over what moves most: half of the quickest or quicker.
    fn unit<'u>(&self, units: &[(f64, &'u str)]) -> Option<(f64, &'u str)> {
        let mut steps: Vec<(f64, f64)> = Vec::new();
        for piece in &self.pieces {
            for i in piece.clone().skip(DIFFERENCE_SAMPLES) {
                let step = |of: &[f64]| of[i] - of[i - DIFFERENCE_SAMPLES];
                let both = (step(&self.read_m), step(&self.commanded_m));
                if both.0.is_finite() && both.1.is_finite() {
                    steps.push(both);
                }
            }
        }
        let quick = quantile(
            &mut steps.iter().map(|s| s.0.abs()).collect::<Vec<f64>>(),
            0.95,
        )?;
        let moving = steps
            .iter()
            .filter(|s| s.0.abs() >= 0.5 * quick && s.0 != 0.0);
        let slope = median(&mut moving.map(|s| s.1 / s.0).collect::<Vec<f64>>())?;
        let unit = units
            .iter()
            .find(|(of, _)| (slope.abs() * of - 1.0).abs() < SLOPE)?;
        Some((unit.0 * slope.signum(), unit.1))
    }

    /// How much later than the readings the told values come, s; zero where that is not plain.
    fn delay_s(&self, commanded_m: &[f64]) -> f64 {
        let now = self.misfit_m(commanded_m, 0.0);
        if now < OWN * self.pitch_m {
            return 0.0;
        }
        let mut step = LATEST_S / f64::from(DELAY_STEPS);
        let all = (-DELAY_STEPS..=DELAY_STEPS).map(|k| f64::from(k) * step);
        let mut best = all
            .map(|t| (self.misfit_m(commanded_m, t), t))
            .fold((now, 0.0), less);
        for _ in 0..DELAY_HALVINGS {
            step *= 0.5;
            let near = [best.1 - step, best.1 + step];
            best = near
                .map(|t| (self.misfit_m(commanded_m, t), t))
                .into_iter()
                .fold(best, less);
        }
        if best.0 < LESS * now { best.1 } else { 0.0 }
    }

    /// Mean distance between reading and what is told so much later, about its median, m: slips add to it at any time alike.
    fn misfit_m(&self, commanded_m: &[f64], later_s: f64) -> f64 {
        let step = self.t_s.len().div_ceil(COMPARED_SAMPLES).max(1);
        let off = |i: usize| self.read_m[i] - self.at(commanded_m, i, later_s);
        let list = (0..self.t_s.len()).step_by(step).map(off);
        let mut list: Vec<f64> = list.filter(|v| v.is_finite()).collect();
        let Some(middle) = median(&mut list) else {
            return f64::INFINITY;
        };
        list.iter().map(|v| (v - middle).abs()).sum::<f64>() / list.len() as f64
    }

    /// The value that is told so much later than a sample, in its own run; the run's last one beyond.
    fn at(&self, commanded_m: &[f64], i: usize, later_s: f64) -> f64 {
        let number = self.pieces.partition_point(|piece| piece.end <= i);
        let piece = self.pieces[number].clone();
        let t_s = self.t_s[i] + later_s;
        let next = piece.start + self.t_s[piece.clone()].partition_point(|t| *t < t_s);
        if next == piece.start || next == piece.end {
            return commanded_m[next.min(piece.end - 1)];
        }
        let (from, to) = (self.t_s[next - 1], self.t_s[next]);
        let part = (t_s - from) / (to - from);
        commanded_m[next - 1] + part * (commanded_m[next] - commanded_m[next - 1])
    }

    /// True if what is told goes with the readings but for single steps of whole teeth.
    fn tells_teeth(&self, commanded_m: &[f64]) -> bool {
        let off: Vec<f64> = self
            .read_m
            .iter()
            .zip(commanded_m)
            .map(|(r, c)| r - c)
            .collect();
        let mut changes: Vec<f64> = Vec::new();
        for piece in &self.pieces {
            let here = piece.clone().skip(DIFFERENCE_SAMPLES);
            changes.extend(here.map(|i| (off[i] - off[i - DIFFERENCE_SAMPLES]).abs()));
        }
        changes.retain(|change| change.is_finite());
        let flat = quantile(&mut changes, 0.9).is_none_or(|change| change < TELLS * self.pitch_m);
        // Between runs a count may begin anew.
        let steps =
            |piece: &Range<usize>| whole_teeth(&off[piece.clone()], self.pitch_m).changes.len();
        flat && self.pieces.iter().map(steps).sum::<usize>() <= MOST_STEPS
    }
}

fn less(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    if b.0 < a.0 { b } else { a }
}

/// Highest less lowest of what is known.
fn travel(values: &[f64]) -> f64 {
    let known = values.iter().copied().filter(|v| v.is_finite());
    range(&known.collect::<Vec<f64>>()).map_or(0.0, |[low, high]| high - low)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// There and back over 40 mm, twice: a place every millisecond.
    fn way(t_s: f64) -> f64 {
        0.02 * (1.0 - (std::f64::consts::PI * t_s).cos()) + 1.0e-5 * (77.0 * t_s).sin()
    }

    fn repaired(commanded: impl Fn(f64) -> f64) -> ColumnRepair {
        let t_s: Vec<f64> = (0..4000).map(|i| 1.0e-3 * f64::from(i)).collect();
        let pair = Pair {
            read_m: t_s.iter().map(|t| way(*t)).collect(),
            commanded_m: t_s.iter().map(|t| commanded(*t)).collect(),
            pieces: vec![0..2000, 2000..4000],
            t_s: &t_s,
            pitch_m: 1.016e-3,
        };
        pair.repaired(&LENGTHS)
    }

    #[test]
    fn units_signs_and_delays_are_told_and_mended() {
        assert_eq!(repaired(|t| way(t) + 2.0e-5), ColumnRepair::AsItIs);
        for (commanded, words) in [
            (&(|t| 1.0e3 * way(t)) as &dyn Fn(f64) -> f64, "in mm"),
            (&|t| -way(t), "other sign"),
            (&|t| way(t - 0.05), "comes 50 ms after"),
            (&|t| way(t + 0.03), "comes 30 ms before"),
        ] {
            let ColumnRepair::Changed(commanded_m, how) = repaired(commanded) else {
                panic!("{words}: not mended");
            };
            assert!(how.contains(words), "{how}");
            let off = |i: usize| commanded_m[i] - way(1.0e-3 * i as f64);
            assert!((100..1900).all(|i| off(i).abs() < 5.0e-5), "{words}");
        }
    }

    #[test]
    fn what_does_not_follow_is_left_aside() {
        assert_eq!(repaired(|_| 0.0), ColumnRepair::LeftAside);
        // The target of each move alone.
        assert_eq!(
            repaired(|t| 0.04 * f64::from(u8::from(t % 2.0 < 1.0))),
            ColumnRepair::LeftAside
        );
        assert_eq!(repaired(|t| way(1.3 * t)), ColumnRepair::LeftAside);
    }

    /// A slip of the count is the readings' fault: the command stays to tell it.
    #[test]
    fn a_slip_leaves_the_command_in_use() {
        let slip = |t: f64| if t < 1.5 { 0.0 } else { -1.016e-3 };
        assert_eq!(repaired(|t| way(t) + slip(t)), ColumnRepair::AsItIs);
    }
}
