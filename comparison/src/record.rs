//! The estimate of a calibration that a board stores.

use crate::design::{self, Design};
use crate::estimate::{Certainty, Estimate, Unknown, Wave};
use courier_sensor::calibration::record::{Calibration, Method};
use courier_sensor::frame::SEGMENTS;
use nalgebra::{DMatrix, DVector};

/// Of a record that is called `name`.
#[must_use]
pub fn estimate(name: &str, calibration: &Calibration) -> Estimate {
    let (unknowns, values) = coefficients(calibration);
    let design = design::of(calibration);
    let parity = design
        .as_ref()
        .ok()
        .map(|design| (design.noise_m, design.freedom));
    let left_m = f64::from(calibration.quality.residual_after_m);
    Estimate {
        name: name.into(),
        about: about(calibration),
        made_s: calibration.made.unix_s.map(|unix_s| unix_s as f64),
        geometry: calibration.geometry,
        certainty: design.map(|design| certainty(&design, &unknowns)),
        parity: parity.or((left_m > 0.0).then_some((left_m, f64::INFINITY))),
        amplitude_counts: calibration.amplitude_counts.map(f64::from),
        left_out: left_out(calibration),
        unknowns,
        values: DVector::from_vec(values),
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

/// Every coefficient of the error model but the constants.
fn coefficients(calibration: &Calibration) -> (Vec<Unknown>, Vec<f64>) {
    let mut list = Vec::new();
    for (term, rows) in calibration
        .model
        .terms
        .iter()
        .zip(&calibration.model.coefficients)
    {
        for segment in 0..SEGMENTS {
            for part in usize::from(!term.periodic())..2 {
                let wave = Wave {
                    segment,
                    term: *term,
                    cosine: part == 1,
                    share: 1.0,
                };
                list.push((Unknown::of_wave(wave), f64::from(rows[segment][part])));
            }
        }
    }
    list.into_iter().unzip()
}

fn certainty(design: &Design, unknowns: &[Unknown]) -> Certainty {
    let of = |unknown: &Unknown| {
        let wave = unknown.wave.filter(|wave| design::fitted(&wave.term))?;
        let order = design
            .orders
            .iter()
            .position(|&order| order == wave.term.own_order)?;
        Some((wave, order))
    };
    let element = |a: usize, b: usize| match (of(&unknowns[a]), of(&unknowns[b])) {
        (Some((one, order)), Some((two, other))) if order == other && one.cosine == two.cosine => {
            match one.segment.abs_diff(two.segment) {
                0 => design.variance[order],
                2 => design.variance[order] * design.correlation[order],
                _ => 0.0,
            }
        }
        _ => 0.0,
    };
    Certainty {
        covariance: DMatrix::from_fn(unknowns.len(), unknowns.len(), element),
        freedom: design.freedom,
        source: format!(
            "by the record: {} poses, {:.3} µm left, a pair's errors of order {} correlated by {:.2}",
            design.poses,
            1.0e6 * design.noise_m,
            design.orders.first().unwrap_or(&0),
            design.correlation.first().unwrap_or(&0.0)
        ),
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
