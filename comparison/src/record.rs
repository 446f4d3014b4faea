//! The estimate of a calibration that a board stores.

use crate::coefficients::coefficients;
use crate::design::{self, Design};
use crate::estimate::{COORDINATION_SENSOR, Certainty, EQUATION_11, Estimate, Unknown};
use crate::joint::{self, JointDesign};
use crate::rows;
use courier_sensor::calibration::Plan;
use courier_sensor::calibration::record::{Calibration, Method};
use nalgebra::{DMatrix, DVector};

/// Of a record that is called `name`.
#[must_use]
pub fn estimate(name: &str, calibration: &Calibration) -> Estimate {
    let (mut unknowns, mut values) = coefficients(calibration);
    let left_m = f64::from(calibration.quality.residual_after_m);
    let by_itself = (left_m > 0.0).then_some((left_m, f64::INFINITY));
    let (certainty, parity) = match calibration.method {
        Method::Platen => {
            let design = design::of(calibration);
            let parity = design.as_ref().ok().map(|of| (of.noise_m, of.freedom));
            (
                design.map(|of| platen(&of, &unknowns)),
                parity.or(by_itself),
            )
        }
        Method::Joint => {
            let (further, lengths) = beacon_unknowns(calibration);
            unknowns.extend(further);
            values.extend(lengths);
            let design = joint::of(calibration);
            (design.map(|of| under_beacon(&of, &unknowns)), by_itself)
        }
    };
    Estimate {
        name: name.into(),
        about: about(calibration),
        made_s: calibration.made.unix_s.map(|unix_s| unix_s as f64),
        geometry: calibration.geometry,
        certainty,
        parity,
        amplitude_counts: calibration.amplitude_counts.map(f64::from),
        looked_for_all: false,
        left_out: left_out(calibration),
        unknowns,
        values: DVector::from_vec(values),
    }
}

/// Height, lever arm and the diode's own errors where any was found, named as the diagnosis names the first three.
fn beacon_unknowns(calibration: &Calibration) -> (Vec<Unknown>, Vec<f64>) {
    let geometry = &calibration.geometry;
    let lengths = [geometry.height_m, geometry.lever_m[0], geometry.lever_m[1]];
    let named = |fitted: joint::Fitted| Unknown {
        effect: if joint::LENGTHS.contains(&fitted) {
            EQUATION_11
        } else {
            COORDINATION_SENSOR
        }
        .into(),
        name: beacon_name(fitted),
        unit: beacon_unit(fitted).into(),
        wave: None,
    };
    let mut list: Vec<(Unknown, f64)> = joint::LENGTHS
        .into_iter()
        .map(named)
        .zip(lengths.map(f64::from))
        .collect();
    let sensor = calibration
        .beacon
        .iter()
        .flat_map(|beacon| beacon.sensor.iter().zip(joint::sensor_unknowns()));
    list.extend(
        sensor
            .filter(|(value, _)| **value != 0.0)
            .map(|(value, of)| (named(of), f64::from(*value))),
    );
    list.into_iter().unzip()
}

fn beacon_name(fitted: joint::Fitted) -> String {
    match fitted {
        joint::Fitted::Height => "height h".into(),
        joint::Fitted::Lever(axis) => format!("lever l_{}", ['x', 'y'][axis]),
        other => other.to_string(),
    }
}

fn beacon_unit(fitted: joint::Fitted) -> &'static str {
    match fitted {
        joint::Fitted::Height | joint::Fitted::Lever(_) => "m",
        joint::Fitted::Turn => "rad",
        _ => "1",
    }
}

/// The joint fit's covariance for a list of unknowns.
fn under_beacon(design: &JointDesign, unknowns: &[Unknown]) -> Certainty {
    let place = |unknown: &Unknown| {
        design
            .unknowns
            .iter()
            .position(|fitted| match (*fitted, unknown.wave) {
                (
                    joint::Fitted::Coefficient {
                        segment,
                        term,
                        part,
                    },
                    Some(wave),
                ) => (segment, term, part == 1) == (wave.segment, wave.term, wave.cosine),
                (joint::Fitted::Coefficient { .. }, None) => false,
                (fitted, None) => beacon_name(fitted) == unknown.name,
                _ => false,
            })
    };
    let places: Vec<Option<usize>> = unknowns.iter().map(place).collect();
    let element = |a: usize, b: usize| match (places[a], places[b]) {
        (Some(a), Some(b)) => design.covariance[(a, b)],
        _ => 0.0,
    };
    Certainty {
        covariance: DMatrix::from_fn(unknowns.len(), unknowns.len(), element),
        freedom: design.freedom,
        own: 0.0,
        lateral: None,
        source: design.source.clone(),
    }
}

fn about(calibration: &Calibration) -> String {
    let method = match calibration.method {
        Method::Platen => "platen",
        Method::Joint => "joint",
    };
    format!(
        "{method} calibration of board {}, {:.1} °C",
        calibration.device, calibration.temperature_c
    )
}

/// The platen fit's covariance for a list of unknowns.
fn platen(design: &Design, unknowns: &[Unknown]) -> Certainty {
    let place = |unknown: &Unknown| {
        let wave = unknown.wave.filter(|wave| rows::fitted(&wave.term))?;
        let order = wave.term.own_order;
        let order = design.orders.iter().position(|&own| own == order)?;
        let first = 2 * (wave.segment * design.orders.len() + order);
        Some(first + usize::from(wave.cosine))
    };
    let places: Vec<Option<usize>> = unknowns.iter().map(place).collect();
    let element = |a: usize, b: usize| match (places[a], places[b]) {
        (Some(a), Some(b)) => design.covariance[(a, b)],
        _ => 0.0,
    };
    Certainty {
        covariance: DMatrix::from_fn(unknowns.len(), unknowns.len(), element),
        freedom: design.freedom,
        own: design.own,
        lateral: design.lateral.as_ref().map(|of| of.of_unknowns(&places)),
        source: format!(
            "by the record{}: {} poses, {:.3} µm left, a pair's errors of order {} correlated by {:.2}",
            named(design.plan),
            design.poses,
            1.0e6 * design.noise_m,
            design.orders.first().unwrap_or(&0),
            design.correlation.first().unwrap_or(&0.0)
        ),
    }
}

/// Which poses a covariance is of, for people.
fn named(plan: Option<Plan>) -> &'static str {
    match plan {
        Some(Plan::Random) => " and the random poses that it names",
        Some(Plan::Optimal) => " and the chosen poses that it names",
        None => ", which does not say which poses",
    }
}

/// What is no part of the comparison: nothing tells it, or it is another at each start.
fn left_out(calibration: &Calibration) -> Vec<String> {
    let mut list = vec![
        "constants of the segments: a pair's mean is told by no reading (gauge), their sum in g_p by where the tooth counts began"
            .to_owned(),
    ];
    if calibration.beacon.is_some() {
        list.push("the beacon's place: it is counted from where the tooth counts began".into());
    }
    list
}

#[cfg(test)]
mod tests {
    use super::*;
    use courier_sensor::geometry::Geometry;
    use courier_sensor::model::{ErrorModel, Multiplier, Term, TermTable};

    #[test]
    fn what_was_held_has_no_variance() {
        let mut calibration = Calibration::identity(Geometry::PAPER);
        let mut terms = TermTable::equation_9();
        terms.push(Term::default().with(Multiplier::Speed)).unwrap();
        calibration.model = ErrorModel::zero(terms);
        let quality = &mut calibration.quality;
        (quality.poses, quality.unknowns, quality.rank) = (1000, 33, 33);
        (quality.residual_after_m, quality.predicted_worst_m) = (1.0e-6, 0.2e-6);
        let estimate = estimate("a", &calibration);
        // Four orders and a lateral one of two parts, a delay of one, for four segments.
        assert_eq!(estimate.unknowns.len(), 4 * (5 * 2 + 1));
        let held: Vec<&str> = (0..estimate.unknowns.len())
            .filter(|&i| !estimate.is_estimated(i))
            .map(|i| estimate.unknowns[i].effect.as_str())
            .collect();
        assert_eq!(held.len(), 12);
        assert!(
            held.iter()
                .all(|e| ["lateral_dependence", "velocity_lag"].contains(e)),
            "{held:?}"
        );
        let covariance = &estimate.certainty.unwrap().covariance;
        assert_eq!(*covariance, covariance.transpose());
        assert!(covariance.symmetric_eigenvalues().min() > -1.0e-20);
    }
}
