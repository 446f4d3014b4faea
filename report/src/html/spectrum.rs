//! Least-squares spectra of unevenly placed residuals (Lomb 1976), each line beside what the simulator's own scatter gives there.

use diagnosis::verdict::evidence::Point;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// One line of a spectrum.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Line {
    /// Order (waves a tooth) or frequency, Hz.
    pub at: f64,
    /// Amplitude before, m.
    pub before_m: f64,
    /// Amplitude after, m.
    pub after_m: f64,
    /// Amplitude below which 95 % of the simulator's own scatter stays in this line, m.
    pub floor_m: f64,
    /// Amplitude that whatever is no wave in the residuals before gives here by chance, as the floor: a drift that a few poses sample
    /// looks like a little of every wave.
    pub chance_m: f64,
}

impl Line {
    /// Amplitude before over what chance gives: the simulator's scatter, or what else is in the residuals. Zero where neither is known.
    pub fn over_chance(&self) -> f64 {
        let chance_m = self.floor_m.max(self.chance_m);
        if chance_m > 0.0 {
            self.before_m / chance_m
        } else {
            0.0
        }
    }
}

/// The amplitude of a sine and cosine of the same Gaussian noise follows Rayleigh's distribution: all but this part of it stays below
/// `level` times its rms.
fn level(beyond: f64) -> f64 {
    (-beyond.ln()).sqrt()
}

/// Part of the scatter that a line's floor leaves out.
const BEYOND: f64 = 0.05;

/// A line must exceed what chance gives by this factor to stand out of `lines` of them: among all, the same part of the scatter does by chance.
pub fn standing_out(lines: usize) -> f64 {
    level(BEYOND / lines.max(1) as f64) / level(BEYOND)
}

/// Amplitudes at each of `places` (per unit of `argument`) by itself, beside a mean. A line that the arguments cannot tell is left out.
/// Cost: points times places.
pub fn spectrum(argument: &[f64], points: &[Point], places: &[f64]) -> Vec<Line> {
    let line = |at: &f64| together(argument, points, &[*at])?.pop();
    places.iter().filter_map(line).collect()
}

/// Amplitudes at all of `places` fitted together, beside a mean, each residual weighed by its stated noise: none takes for its own what belongs to another. `None` where the
/// arguments cannot tell them apart. What chance gives follows from the residuals of the fit, each with its own variance (White 1980).
/// Cost: points times the square of places.
pub fn together(argument: &[f64], points: &[Point], places: &[f64]) -> Option<Vec<Line>> {
    let n = 1 + 2 * places.len();
    if points.len() <= n {
        return None;
    }
    let mut normal = DMatrix::<f64>::zeros(n, n);
    let mut right = DMatrix::<f64>::zeros(n, 2);
    // Without a stated noise all weigh the same, and there is no floor.
    let stated = points.iter().all(|p| p.floor_m > 0.0);
    let weight = |point: &Point| {
        if stated { point.floor_m.powi(-2) } else { 1.0 }
    };
    let waves = |x: f64| {
        let mut row = DVector::from_element(n, 1.0);
        for (k, at) in places.iter().enumerate() {
            (row[1 + 2 * k], row[2 + 2 * k]) = (TAU * at * x).sin_cos();
        }
        row
    };
    for (x, point) in argument.iter().zip(points) {
        let row = waves(*x);
        let weight = weight(point);
        normal.syger(weight, &row, &row, 1.0);
        right.column_mut(0).axpy(weight * point.before_m, &row, 1.0);
        right.column_mut(1).axpy(weight * point.after_m, &row, 1.0);
    }
    normal.fill_upper_triangle_with_lower_triangle();
    if !well_told(&normal) {
        return None;
    }
    let inverse = normal.cholesky()?.inverse();
    let amounts = &inverse * right;
    let mut chance = DMatrix::<f64>::zeros(n, n);
    for (x, point) in argument.iter().zip(points) {
        let row = waves(*x);
        let left_m = point.before_m - row.dot(&amounts.column(0));
        chance.syger((weight(point) * left_m).powi(2), &row, &row, 1.0);
    }
    chance.fill_upper_triangle_with_lower_triangle();
    let chance = &inverse * chance * &inverse;
    // Weighed so, the inverse is the covariance that the stated noise gives.
    let level_m = |covariance: &DMatrix<f64>, (s, c): (usize, usize)| {
        level(BEYOND) * (covariance[(s, s)] + covariance[(c, c)]).sqrt()
    };
    let line = |(k, at): (usize, &f64)| {
        let (s, c) = (1 + 2 * k, 2 + 2 * k);
        let amplitude = |of: usize| amounts[(s, of)].hypot(amounts[(c, of)]);
        Line {
            at: *at,
            before_m: amplitude(0),
            after_m: amplitude(1),
            floor_m: if stated {
                level_m(&inverse, (s, c))
            } else {
                0.0
            },
            chance_m: level_m(&chance, (s, c)),
        }
    };
    Some(places.iter().enumerate().map(line).collect())
}

/// Least eigenvalue of evenly weighted normal equations over the largest, below which functions are not told apart: by then the
/// scatter of what is told is ten times that of evenly spread arguments.
const TOLD: f64 = 1.0e-2;

fn well_told(normal: &DMatrix<f64>) -> bool {
    // A sine and its cosine have one scale: one that vanishes at all arguments is not told, however well it would be if it were larger.
    let scale = DVector::from_fn(normal.nrows(), |i, _| {
        let square = match i.checked_sub(1).map(|k| 1 + k / 2 * 2) {
            Some(s) => 0.5 * (normal[(s, s)] + normal[(s + 1, s + 1)]),
            None => normal[(0, 0)],
        };
        square.max(f64::MIN_POSITIVE).sqrt()
    });
    let even = DMatrix::from_fn(normal.nrows(), normal.ncols(), |i, j| {
        normal[(i, j)] / (scale[i] * scale[j])
    });
    let values = even.symmetric_eigenvalues();
    values.min() > TOLD * values.max()
}

#[cfg(test)]
mod tests {
    use super::*;
    use effects::random::{ChaCha8Rng, SeedableRng, normal};

    /// Residuals at uneven places over some turns.
    fn points(turns: f64, before: impl Fn(f64) -> f64) -> (Vec<f64>, Vec<Point>) {
        let x = (0..600).map(|i| (f64::from(i) * 0.618_034).fract() * turns);
        let point = |x: f64| Point {
            before_m: before(x),
            floor_m: 1.0,
            ..Point::default()
        };
        x.map(|x| (x, point(x))).unzip()
    }

    #[test]
    fn a_wave_at_uneven_places_has_its_amplitude_alone_and_together() {
        let wave = |x: f64| 2.0 * (TAU * 3.0 * x + 0.4).sin() + 5.0;
        let (x, points) = points(9.3, wave);
        let places = [1.0, 3.0, 4.0];
        for lines in [
            spectrum(&x, &points, &places),
            together(&x, &points, &places).unwrap(),
        ] {
            assert!((lines[1].before_m - 2.0).abs() < 0.02, "{lines:?}");
            assert!(
                lines[0].before_m < 0.1 && lines[2].before_m < 0.1,
                "{lines:?}"
            );
            assert_eq!(lines[1].after_m, 0.0);
        }
    }

    #[test]
    fn one_line_in_twenty_of_the_scatter_alone_is_above_its_floor() {
        let orders: Vec<f64> = (1..=8).map(f64::from).collect();
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let mut above = 0;
        for _ in 0..200 {
            let (x, mut points) = points(1.0, |_| 0.0);
            for (x, point) in x.iter().zip(&mut points) {
                // Some places are three times as noisy as others.
                point.floor_m = if *x < 0.5 { 1.0 } else { 3.0 };
                point.before_m = point.floor_m * normal(&mut rng);
            }
            let lines = together(&x, &points, &orders).unwrap();
            above += lines.iter().filter(|l| l.before_m > l.floor_m).count();
        }
        // 80 of 1600 are expected; four standard deviations of that count are 35.
        assert!((45..=115).contains(&above), "{above}");
    }

    #[test]
    fn orders_that_the_way_does_not_tell_apart_are_none() {
        let (x, points) = points(0.05, |x| (TAU * x).sin());
        assert_eq!(together(&x, &points, &[1.0, 2.0]), None);
        assert!(spectrum(&x, &points, &[1.0]).is_empty());
    }

    #[test]
    fn a_reading_in_the_dark_weighs_nothing() {
        let (x, mut points) = points(4.0, |x| (TAU * x).sin());
        (points[7].before_m, points[7].floor_m) = (1.0e6, 1.0e9);
        let line = spectrum(&x, &points, &[1.0])[0];
        assert!(
            (line.before_m - 1.0).abs() < 0.01 && line.floor_m < 0.2,
            "{line:?}"
        );
    }

    #[test]
    fn what_is_no_wave_stands_out_of_the_floor_but_not_of_chance() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let (x, mut points) = points(1.0, |_| 0.0);
        for point in &mut points {
            point.floor_m = 0.01;
            point.before_m = normal(&mut rng);
        }
        let orders = [1.0, 2.0, 3.0];
        let lines = together(&x, &points, &orders).unwrap();
        assert!(lines.iter().all(|l| l.before_m > l.floor_m), "{lines:?}");
        assert!(lines.iter().all(|l| l.over_chance() < 1.5), "{lines:?}");
        for (x, point) in x.iter().zip(&mut points) {
            point.before_m += (TAU * 2.0 * x).sin();
        }
        let lines = together(&x, &points, &orders).unwrap();
        assert!(lines[1].over_chance() > 5.0, "{lines:?}");
    }

    #[test]
    fn half_the_sample_rate_has_no_sine_and_is_no_line() {
        let x: Vec<f64> = (0..300).map(f64::from).collect();
        let points: Vec<Point> = x
            .iter()
            .map(|x| Point {
                before_m: (2.0 * x).cos(),
                floor_m: 1.0,
                ..Point::default()
            })
            .collect();
        assert!(spectrum(&x, &points, &[0.5]).is_empty());
        assert_eq!(spectrum(&x, &points, &[0.4]).len(), 1);
    }

    #[test]
    fn the_more_lines_there_are_the_farther_one_must_stand_out() {
        assert_eq!(standing_out(1), 1.0);
        assert!(standing_out(200) > standing_out(10) && standing_out(200) < 2.0);
    }
}
