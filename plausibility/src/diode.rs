//! The segments against the coordination sensor: equations (10) and (11) to first order.
//!
//! Within a group of rows x = h t_x - l_y theta + constant and y = h t_y + l_x theta + constant, where t is the tangent that the
//! electrodes tell. The fit's four coefficients of t tell axes, signs and height times full scale, those of theta the lever arms.

use crate::fault::{ANGLES, FULL_SCALE_SHARE, Fault, LENGTHS, unit_of};
use crate::poses::{DRAWING_TOLERANCE, ERROR_FLOOR_M, EXCITATION_M};
use crate::products::{Fit, Products, fit};
use crate::readings::Readings;
use crate::view::View;
use nalgebra::DVector;

/// Ways to make two axes of four electrodes: the electrodes of each axis, and which two are exchanged.
const PAIRINGS: [([[usize; 2]; 2], Option<[usize; 2]>); 5] = [
    ([[0, 1], [2, 3]], None),
    ([[2, 1], [0, 3]], Some([0, 2])),
    ([[3, 1], [2, 0]], Some([0, 3])),
    ([[0, 2], [1, 3]], Some([1, 2])),
    ([[0, 3], [2, 1]], Some([1, 3])),
];

/// The diode explains a motion if less than this share of it is left: the lever arm of 90 mm turns 4 µm of a pair's error into 40.
const UNEXPLAINED_SHARE: f64 = 0.15;
/// What a bracket adds to that, m.
const BRACKET_TOLERANCE_M: f64 = 2.0e-3;
/// Standard errors within which two values are the same. A prior: the errors are bounds of what equation (3) leaves, not
/// deviations of noise, so that one is enough.
const COVERAGE_FACTOR: f64 = 1.0;
/// A main coefficient is known to this share of itself, or nothing is told. Derived from the units: the nearest two differ by a
/// factor of 2.54, fifteen such errors.
pub(crate) const RELATIVE_ERROR: f64 = 0.1;
/// What the other axis of the diode may do beside the main one, as a share: a mount turned by 17 degrees.
const CROSS_AXIS_SHARE: f64 = 0.3;
/// Least share of an angle's own movement, by its square, that must be turning and not its error for it to tell the lever arms.
/// A prior: an error in the regressor makes them too short by the rest, which is added to their own errors.
const TURN_SHARE: f64 = 0.5;
/// Zero of the angle that tooth counts may have by chance, rad: half a pitch over the span. Derived from the paper's: 0.508 mm
/// over 9.7 mm is 0.052 rad.
const ANGLE_ORIGIN_RAD: f64 = 0.05;

/// Electrodes beside all recorded segments, for every pairing.
#[derive(Clone, Debug)]
pub(crate) struct Diode {
    products: Products,
    full_m: f64,
    lever_m: [f64; 2],
}

/// What a view of the segments makes of the diode.
#[derive(Clone, Debug, Default)]
pub(crate) struct Judged {
    /// What is wrong with electrodes and stated geometry.
    pub faults: Vec<Fault>,
    /// Responses that the diode does not explain.
    pub unexplained: usize,
    /// Responses that move enough to be looked at.
    pub told: usize,
    /// Responses that it does explain.
    pub explained: usize,
    /// Height times full scale over the stated one, and the standard error of that.
    pub height: Option<[f64; 2]>,
    /// Lever arms by the data and their standard errors, m, with the span as the view has it.
    pub lever_m: [Option<[f64; 2]>; 2],
}

/// One response's fit: by t_x, t_y and theta; what it does beside the main axis and by the angle with their standard errors.
struct Row {
    main: usize,
    factor: f64,
    beside: Option<[f64; 2]>,
    error: f64,
    by_angle: Option<[f64; 2]>,
}

impl Diode {
    /// Of a recording with electrodes and enough rows under a beacon.
    pub fn new(readings: &Readings) -> Option<Self> {
        let coordination = readings.coordination?;
        if readings.electrodes.iter().any(Vec::is_empty) {
            return None;
        }
        let mut needed: Vec<&Vec<f64>> = readings.position_m.iter().collect();
        needed.extend(readings.electrodes.iter());
        let rows = readings.rows_with(&needed);
        let mut tangents = Vec::new();
        for (axes, _) in PAIRINGS {
            for [plus, minus] in axes {
                let [plus, minus] = [plus, minus].map(|e| &readings.electrodes[e]);
                let tangent = |(p, n): (&f64, &f64)| (p - n) / (p + n);
                tangents.push(plus.iter().zip(minus).map(tangent).collect::<Vec<f64>>());
            }
        }
        let mut columns: Vec<&Vec<f64>> = readings.position_m.iter().collect();
        columns.extend(tangents.iter());
        let finite = |i: &usize| tangents.iter().all(|t| t[*i].is_finite());
        let rows: Vec<usize> = rows.into_iter().filter(finite).collect();
        Some(Self {
            products: readings.products(&rows, &columns)?,
            full_m: coordination.height_m * coordination.tan_full_scale,
            lever_m: [coordination.lever_x_m, coordination.lever_y_m],
        })
    }

    /// Judges the diode as a view of the segments sees it, with the electrodes paired in the way that costs least.
    pub fn judge(&self, view: &View) -> Judged {
        let ways = (0..PAIRINGS.len()).map(|pairing| self.paired(view, pairing));
        let cost =
            |j: &Judged| j.faults.iter().map(Fault::cost).sum::<f64>() + 2.0 * j.unexplained as f64;
        ways.min_by(|a, b| cost(a).total_cmp(&cost(b)))
            .unwrap_or_default()
    }

    fn paired(&self, view: &View, pairing: usize) -> Judged {
        let mut judged = Judged::default();
        if let Some([a, b]) = PAIRINGS[pairing].1 {
            judged.faults.push(Fault::ElectrodesExchanged(a, b));
        }
        let rows = [0, 1].map(|response| self.row(view, response, pairing, &mut judged));
        let known = |row: &&Row| row.factor.is_finite();
        judged.explained = rows.iter().flatten().filter(known).count();
        let turn = self.mounting(&rows, &mut judged);
        self.levers(&rows, turn, &mut judged);
        // Other electrodes than the stated ones have to be seen at work.
        if pairing > 0 && judged.height.is_none() {
            judged.unexplained += 1;
        }
        judged
    }

    fn row(
        &self,
        view: &View,
        response: usize,
        pairing: usize,
        judged: &mut Judged,
    ) -> Option<Row> {
        let width = self.products.projected.nrows();
        let weights = view.response(response, width)?;
        let mut regressors: Vec<DVector<f64>> = [0, 1]
            .map(|axis| {
                let mut one = DVector::zeros(width);
                one[4 + 2 * pairing + axis] = 1.0;
                one
            })
            .into();
        regressors.extend(view.response(2, width));
        let fit = fit(&self.products.projected, &weights, &regressors);
        // By what was measured, whatever the view's scale: no view makes a motion too small to be looked at.
        if fit.was * view.lengths < EXCITATION_M {
            return None;
        }
        judged.told += 1;
        if fit.left > UNEXPLAINED_SHARE * fit.was {
            judged.unexplained += 1;
            return None;
        }
        let by_angle = by_angle(&fit, view.angle_error_rad(self.products.periodic_m));
        let known =
            |axis: &usize| error(&fit, *axis) < RELATIVE_ERROR * fit.coefficients[*axis].abs();
        let size = |axis: &usize| fit.coefficients[*axis].abs();
        let main = [0, 1]
            .into_iter()
            .filter(known)
            .max_by(|a, b| size(a).total_cmp(&size(b)));
        let Some(main) = main else {
            return Some(Row {
                main: response,
                factor: f64::NAN,
                beside: None,
                error: f64::NAN,
                by_angle,
            });
        };
        let other = 1 - main;
        let told = error(&fit, other) < CROSS_AXIS_SHARE / COVERAGE_FACTOR * size(&main);
        Some(Row {
            main,
            factor: fit.coefficients[main],
            beside: told.then(|| [fit.coefficients[other], error(&fit, other)]),
            error: error(&fit, main),
            by_angle,
        })
    }

    /// Axes, signs and scale of the diode. Returns the angle by which its axes are turned against the segments', and its standard error, rad,
    /// where told.
    fn mounting(&self, rows: &[Option<Row>; 2], judged: &mut Judged) -> Option<[f64; 2]> {
        let told = rows
            .each_ref()
            .map(|row| row.as_ref().filter(|r| r.factor.is_finite()));
        for row in told.iter().flatten() {
            if row
                .beside
                .is_some_and(|[b, _]| b.abs() > CROSS_AXIS_SHARE * row.factor.abs())
            {
                judged.unexplained += 1;
            }
        }
        let negative = |row: &Row| row.factor < 0.0;
        match told {
            [Some(x), Some(y)] if x.main == y.main => judged.unexplained += 1,
            [Some(x), Some(y)] => judged
                .faults
                .extend(mounted(x.main == 1, [negative(x), negative(y)])),
            [Some(row), None] | [None, Some(row)] => {
                let crossed = row.main != usize::from(told[0].is_none());
                if crossed {
                    judged.faults.push(Fault::DiodeAxesExchanged);
                }
                if negative(row) {
                    let [a, b] = [2 * row.main, 2 * row.main + 1];
                    judged.faults.push(Fault::ElectrodesExchanged(a, b));
                }
            }
            [None, None] => return None,
        }
        let scales: Vec<[f64; 2]> = told
            .iter()
            .flatten()
            .map(|row| [row.factor.abs() / self.full_m, row.error / self.full_m])
            .collect();
        let [scale, error] = scales
            .iter()
            .copied()
            .min_by(|a, b| a[1].total_cmp(&b[1]))?;
        if scales.iter().any(|s| {
            (s[0] / scale - 1.0).abs() > DRAWING_TOLERANCE + COVERAGE_FACTOR * s[1] / scale
        }) {
            judged.unexplained += 1;
        }
        judged.height = Some([scale, error]);
        if (scale - 1.0).abs() > DRAWING_TOLERANCE + COVERAGE_FACTOR * error {
            let degrees = unit_of(1.0 / scale, &ANGLES[..1], FULL_SCALE_SHARE);
            let length = unit_of(1.0 / scale, &LENGTHS, DRAWING_TOLERANCE / 10.0);
            let factor = degrees.or(length).map_or(scale, |_| scale);
            judged.faults.push(Fault::Height(factor));
        }
        match told {
            [Some(x), Some(y)] if x.main == 0 && x.factor > 0.0 && y.factor > 0.0 => {
                let ([by_y, y_error], [by_x, x_error]) = (x.beside?, y.beside?);
                let along = x.factor + y.factor;
                let turn = [(by_x - by_y).atan2(along), (x_error + y_error) / along];
                // Known less well than that it tells no more of the angle's zero than tooth counts do.
                (turn[1] < ANGLE_ORIGIN_RAD).then_some(turn)
            }
            _ => None,
        }
    }

    fn levers(&self, rows: &[Option<Row>; 2], turn_rad: Option<[f64; 2]>, judged: &mut Judged) {
        let by_angle = rows
            .each_ref()
            .map(|row| row.as_ref().and_then(|r| r.by_angle));
        // Equation (11): x holds -l_y theta, y holds l_x theta.
        let mut found = [
            by_angle[1],
            by_angle[0].map(|[value, error]| [-value, error]),
        ];
        if let ([Some(x), Some(y)], Some([turn, turn_error])) = (&mut found, turn_rad) {
            let (sine, cosine) = turn.sin_cos();
            (x[0], y[0]) = (cosine * x[0] + sine * y[0], cosine * y[0] - sine * x[0]);
            // As far as the turn is not known, each arm holds an unknown part of the other.
            (x[1], y[1]) = (
                x[1] + turn_error * y[0].abs(),
                y[1] + turn_error * x[0].abs(),
            );
        }
        judged.lever_m = found;
        let zero = if turn_rad.is_some() {
            0.0
        } else {
            ANGLE_ORIGIN_RAD
        };
        let near = |axis: usize, wanted: f64| {
            found[axis].is_none_or(|[value, error]| {
                let other = self.lever_m[1 - axis].abs();
                let allowed = DRAWING_TOLERANCE * wanted.abs()
                    + BRACKET_TOLERANCE_M
                    + COVERAGE_FACTOR * error
                    + zero * other;
                (value - wanted).abs() <= allowed
            })
        };
        let [x, y] = self.lever_m;
        if near(0, x) && near(1, y) {
            return;
        }
        if near(0, y) && near(1, x) && found.iter().all(Option::is_some) {
            judged.faults.push(Fault::LeversExchanged);
            return;
        }
        for (axis, stated) in self.lever_m.into_iter().enumerate() {
            if near(axis, stated) {
                continue;
            }
            if near(axis, -stated) {
                judged.faults.push(Fault::LeverReversed(axis));
            } else if let Some([value, _]) = found[axis] {
                judged.faults.push(Fault::Lever(axis, value));
            }
        }
    }
}

/// The coefficient of theta and its standard error, where theta turns by more than its own error.
fn by_angle(fit: &Fit, error_rad: f64) -> Option<[f64; 2]> {
    let alone_rad = *fit.alone.get(2)?;
    let turned = 1.0 - (error_rad / alone_rad.max(1.0e-300)).powi(2);
    let value = fit.coefficients[2];
    let too_short = value.abs() * (1.0 - turned) / turned;
    (turned > TURN_SHARE).then(|| [value, error(fit, 2) + too_short])
}

fn error(fit: &Fit, regressor: usize) -> f64 {
    fit.error(regressor, ERROR_FLOOR_M)
}

/// What a crossing of the axes and the signs of x and y are the result of.
fn mounted(crossed: bool, negative: [bool; 2]) -> Vec<Fault> {
    let x = Fault::ElectrodesExchanged(0, 1);
    let y = Fault::ElectrodesExchanged(2, 3);
    match (crossed, negative) {
        (false, [false, false]) => Vec::new(),
        (false, [true, false]) => vec![x],
        (false, [false, true]) => vec![y],
        (false, [true, true]) => vec![Fault::DiodeTurned(180)],
        (true, [false, false]) => vec![Fault::DiodeAxesExchanged],
        // x = h t_y: the diode's y axis lies along x.
        (true, [false, true]) => vec![Fault::DiodeTurned(90)],
        (true, [true, false]) => vec![Fault::DiodeTurned(270)],
        (true, [true, true]) => vec![Fault::DiodeAxesExchanged, Fault::DiodeTurned(180)],
    }
}
