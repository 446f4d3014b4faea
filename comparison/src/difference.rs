//! The difference of two estimates.

use crate::distribution::effective_freedom;
use crate::estimate::{Certainty, Estimate, Unknown};
use courier_sensor::geometry::Geometry;
use nalgebra::{DMatrix, DVector};

/// The second estimate less the first, unknown by unknown; what one of them lacks is zero there, with certainty.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// Unknowns of both.
    pub unknowns: Vec<Unknown>,
    /// Values of the first, in the unknowns' units.
    pub first: DVector<f64>,
    /// Values of the second.
    pub second: DVector<f64>,
    /// Covariance of the second less the first, as independent measurements; or whose is not known, and why.
    pub certainty: Result<Certainty, String>,
    /// Geometry of the first.
    pub geometry: Geometry,
}

impl Difference {
    /// Of two estimates from independent measurements of one courier.
    #[must_use]
    pub fn between(first: &Estimate, second: &Estimate) -> Self {
        let mut unknowns = first.unknowns.clone();
        let new = second
            .unknowns
            .iter()
            .filter(|of| !first.unknowns.iter().any(|other| other.is(of)));
        unknowns.extend(new.cloned());
        let certainty = match (&first.certainty, &second.certainty) {
            (Ok(one), Ok(two)) => {
                let (one, two) = (
                    Spread::of(one, first, &unknowns),
                    Spread::of(two, second, &unknowns),
                );
                Ok(joined(&one, &two))
            }
            (Err(why), _) => Err(format!("{}: {why}", first.name)),
            (_, Err(why)) => Err(format!("{}: {why}", second.name)),
        };
        Self {
            first: values(first, &unknowns),
            second: values(second, &unknowns),
            geometry: first.geometry,
            certainty,
            unknowns,
        }
    }

    /// The second less the first.
    #[must_use]
    pub fn values(&self) -> DVector<f64> {
        &self.second - &self.first
    }
}

/// Values of an estimate for a list of unknowns, zero for those that it lacks.
pub fn values(estimate: &Estimate, unknowns: &[Unknown]) -> DVector<f64> {
    let places = places(estimate, unknowns);
    DVector::from_iterator(
        unknowns.len(),
        places
            .iter()
            .map(|place| place.map_or(0.0, |k| estimate.values[k])),
    )
}

/// Covariance of an estimate for a list of unknowns, zero for those that it lacks.
pub fn covariance(
    certainty: &Certainty,
    estimate: &Estimate,
    unknowns: &[Unknown],
) -> DMatrix<f64> {
    let places = places(estimate, unknowns);
    DMatrix::from_fn(unknowns.len(), unknowns.len(), |a, b| {
        match (places[a], places[b]) {
            (Some(a), Some(b)) => certainty.covariance[(a, b)],
            _ => 0.0,
        }
    })
}

fn places(estimate: &Estimate, unknowns: &[Unknown]) -> Vec<Option<usize>> {
    let place = |unknown: &Unknown| estimate.unknowns.iter().position(|of| of.is(unknown));
    unknowns.iter().map(place).collect()
}

/// One side's covariance for the unknowns of both.
struct Spread {
    covariance: DMatrix<f64>,
    freedom: f64,
}

impl Spread {
    fn of(certainty: &Certainty, estimate: &Estimate, unknowns: &[Unknown]) -> Self {
        Self {
            covariance: covariance(certainty, estimate, unknowns),
            freedom: certainty.freedom,
        }
    }
}

/// The sum, with degrees of freedom by each side's mean share of the variances (Welch 1947).
fn joined(one: &Spread, two: &Spread) -> Certainty {
    let covariance = &one.covariance + &two.covariance;
    let share = |side: &Spread| {
        let shares = side
            .covariance
            .diagonal()
            .iter()
            .zip(covariance.diagonal().iter())
            .filter(|(_, all)| **all > 0.0)
            .map(|(own, all)| own / all)
            .collect::<Vec<f64>>();
        (
            shares.iter().sum::<f64>() / shares.len().max(1) as f64,
            side.freedom,
        )
    };
    Certainty {
        freedom: effective_freedom([share(one), share(two)]),
        covariance,
        source: String::new(),
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::estimate::Wave;
    use courier_sensor::model::Term;

    /// An estimate of sine and cosine of one order of one segment, both of one deviation.
    pub fn of_order(order: u8, values_m: [f64; 2], deviation_m: f64) -> Estimate {
        let wave = |cosine| {
            Unknown::of_wave(Wave {
                segment: 0,
                term: Term::own(order),
                cosine,
                share: 1.0,
            })
        };
        Estimate {
            name: format!("order {order}"),
            about: String::new(),
            made_s: None,
            geometry: Geometry::PAPER,
            unknowns: vec![wave(false), wave(true)],
            values: DVector::from_column_slice(&values_m),
            certainty: Ok(Certainty {
                covariance: DMatrix::identity(2, 2) * deviation_m * deviation_m,
                freedom: 100.0,
                source: String::new(),
            }),
            parity: Some((1.0e-6, 100.0)),
            amplitude_counts: [20_000.0; 4],
            left_out: Vec::new(),
        }
    }

    #[test]
    fn unknowns_of_either_are_compared() {
        let (one, two) = (of_order(1, [1.0, 2.0], 0.1), of_order(2, [3.0, 4.0], 0.2));
        let apart = Difference::between(&one, &two);
        assert_eq!(apart.values().as_slice(), [-1.0, -2.0, 3.0, 4.0]);
        let certainty = apart.certainty.unwrap();
        let variances: Vec<f64> = certainty.covariance.diagonal().iter().copied().collect();
        assert!(
            variances
                .iter()
                .zip([0.01, 0.01, 0.04, 0.04])
                .all(|(a, b)| (a - b).abs() < 1e-12)
        );
        assert!((certainty.freedom - 200.0).abs() < 1.0e-9);
        let same = Difference::between(&one, &of_order(1, [1.5, 2.0], 0.2));
        assert_eq!(same.values().as_slice(), [0.5, 0.0]);
        assert!((same.certainty.unwrap().covariance[(0, 0)] - 0.05).abs() < 1.0e-12);
    }

    #[test]
    fn what_is_not_known_is_said_with_its_name() {
        let mut two = of_order(1, [0.0; 2], 1.0);
        two.certainty = Err("no self-calibration".into());
        let told = Difference::between(&of_order(1, [0.0; 2], 1.0), &two)
            .certainty
            .unwrap_err();
        assert_eq!(told, "order 1: no self-calibration");
    }
}
