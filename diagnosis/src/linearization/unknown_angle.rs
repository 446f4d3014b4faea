//! What the courier's turning does to segments that are held against a reference without an angle.
//!
//! A segment sits half a span from the point that the reference measures, so that an angle of theta moves it by half a span times theta
//! (equation (4)). Where the reference tells no angle, that is no error of the sensor, and nothing else may be found for it. An angle that
//! nobody controls is a smooth function of the place, as bearing and motors are; one that is commanded follows the commands. These columns
//! stand beside the baseline's.

use crate::linearization::recording::{LinearizedRecording, range};
use courier_signal::equations::ANGLE_SIGN;
use effects::basis::legendre;
use effects::sensor::{Covariates, Regressor};

/// Prior deviation of the angle, rad: 1.5 degrees, the largest that a recording's usual runs have.
const TURN_RAD: f64 = 0.026;
/// Highest total order of its course over the places. Derived from Taylor's series: over 40 mm the next one of a bearing that
/// winds over half a metre is a hundred thousandth, (2 pi 0.02 / 0.5)^4 / (4! 2^3).
const HIGHEST_ORDER: usize = 3;
/// Half ranges from the middle beyond which the course is not carried on. A prior: farther out a polynomial of this order says nothing.
const BEYOND: f64 = 1.5;

/// The columns; none where the angle is known, or where no span is stated: then a segment is where the reference is.
pub fn regressors(linearized: &LinearizedRecording) -> Vec<Regressor> {
    let o = linearized.observations;
    if !linearized.scope.reference || !o.span_is_stated || !o.reference[2].is_empty() {
        return Vec::new();
    }
    let arm_m = 0.5 * o.span_m;
    let ranges_m = [0, 1].map(|axis| {
        let centres = (0..linearized.len()).map(|i| linearized.centre_m(i)[axis]);
        finite_range(centres).filter(|[from, to]| to - from > o.pitch_m)
    });
    let mut list: Vec<Regressor> = orders(ranges_m.map(|range| range.is_some()))
        .map(|orders| over_places(orders, ranges_m, arm_m))
        .collect();
    if finite_range(o.commanded[2].iter().copied()).is_some_and(|[from, to]| to > from) {
        let angle = |m: &Covariates| m.commanded_theta_rad;
        let name = "turning that is commanded".to_string();
        list.push(turning(name, "1", arm_m, angle).expected(1.0, 1.0));
    }
    list
}

/// Orders along x and y of each shape over the places that are passed.
fn orders(passed: [bool; 2]) -> impl Iterator<Item = [usize; 2]> {
    let highest = passed.map(|p| if p { HIGHEST_ORDER } else { 0 });
    let all = (0..=highest[0]).flat_map(move |x| (0..=highest[1]).map(move |y| [x, y]));
    all.filter(|[x, y]| (1..=HIGHEST_ORDER).contains(&(x + y)))
}

/// One shape of the angle over the places.
fn over_places(orders: [usize; 2], ranges_m: [Option<[f64; 2]>; 2], arm_m: f64) -> Regressor {
    let along = move |m: &Covariates, axis: usize| {
        ranges_m[axis].map_or(1.0, |[from, to]| {
            let off = (2.0 * m.centre_m[axis] - from - to) / (to - from);
            legendre(orders[axis], off.clamp(-BEYOND, BEYOND))
        })
    };
    let name = format!("turning, orders {} and {} of x and y", orders[0], orders[1]);
    let shape = turning(name, "rad", arm_m, move |m| along(m, 0) * along(m, 1));
    shape.of_deviation(TURN_RAD)
}

/// A course of the angle, as it moves the segments.
fn turning(
    name: String,
    unit: &'static str,
    arm_m: f64,
    angle: impl Fn(&Covariates) -> f64 + Send + Sync + 'static,
) -> Regressor {
    Regressor::readings(name, unit, arm_m * TURN_RAD, move |m, out| {
        let off_m = arm_m * angle(m);
        for (out, sign) in out.iter_mut().zip(ANGLE_SIGN.map(f64::from)) {
            *out += sign * off_m;
        }
    })
}

/// Least and largest of what is measured; none of nothing.
fn finite_range(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    let finite: Vec<f64> = values.filter(|v| v.is_finite()).collect();
    range(&finite)
}
