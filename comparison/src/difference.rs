//! The difference of two estimates.

use crate::distribution::effective_freedom;
use crate::estimate::{Certainty, Estimate, Unknown};
use crate::lateral::{self, Lateral, Moments};
use courier_sensor::geometry::Geometry;
use nalgebra::{DMatrix, DVector};

/// The second estimate less the first, for the unknowns that both speak of.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// The unknowns.
    pub unknowns: Vec<Unknown>,
    /// Values of the first, in the unknowns' units.
    pub first: DVector<f64>,
    /// Values of the second.
    pub second: DVector<f64>,
    /// Covariance of the second less the first, as independent measurements, zero for what one of them held; or whose is not known, and
    /// why.
    pub certainty: Result<Certainty, String>,
    /// Geometry of the first.
    pub geometry: Geometry,
    /// What one of them has alone, or held: it is not compared.
    pub left_out: Vec<String>,
}

impl Difference {
    /// Of two estimates from independent measurements of one courier. An effect that one of them does not have is zero there if it was
    /// looked for; anything else that one of them lacks is left out.
    #[must_use]
    pub fn between(first: &Estimate, second: &Estimate) -> Self {
        let mut unknowns = first.unknowns.clone();
        let new = second
            .unknowns
            .iter()
            .filter(|of| !first.unknowns.iter().any(|other| other.is(of)));
        unknowns.extend(new.cloned());
        let speaks = |of: &Estimate, unknown: &Unknown| {
            of.unknowns.iter().any(|own| own.is(unknown))
                || of.looked_for_all && unknown.is_of_an_effect()
        };
        let (kept, alone): (Vec<Unknown>, Vec<Unknown>) = unknowns
            .into_iter()
            .partition(|of| speaks(first, of) && speaks(second, of));
        let mut left_out = by_effect(&alone, |of| {
            let owner = if speaks(first, of) { first } else { second };
            format!("{} alone has", owner.name)
        });
        let certainty = match (&first.certainty, &second.certainty) {
            (Ok(one), Ok(two)) => {
                let one = Spread::of(one, first, &kept);
                let two = Spread::of(two, second, &kept);
                let held = |side: &Spread, of: &Estimate| {
                    by_effect(&side.held(&kept), |_| format!("{} held", of.name))
                };
                left_out.extend(held(&one, first));
                left_out.extend(held(&two, second));
                Ok(joined(&one, &two))
            }
            (Err(why), _) => Err(format!("{}: {why}", first.name)),
            (_, Err(why)) => Err(format!("{}: {why}", second.name)),
        };
        Self {
            first: values(first, &kept),
            second: values(second, &kept),
            geometry: first.geometry,
            unknowns: kept,
            certainty,
            left_out,
        }
    }

    /// The second less the first.
    #[must_use]
    pub fn values(&self) -> DVector<f64> {
        &self.second - &self.first
    }
}

/// Unknowns counted by what is said of them and by effect: a line each.
fn by_effect(unknowns: &[Unknown], said: impl Fn(&Unknown) -> String) -> Vec<String> {
    let mut counts: Vec<(String, usize)> = Vec::new();
    for unknown in unknowns {
        let name = format!("{} {}", said(unknown), unknown.effect);
        match counts.iter_mut().find(|(of, _)| *of == name) {
            Some((_, count)) => *count += 1,
            None => counts.push((name, 1)),
        }
    }
    let line =
        |(name, count): (String, usize)| format!("{name}: unknowns that are left out, {count}");
    counts.into_iter().map(line).collect()
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
    own: f64,
    lateral: Option<Lateral>,
    /// Whether each was estimated, or looked for.
    known: Vec<bool>,
}

impl Spread {
    fn of(certainty: &Certainty, estimate: &Estimate, unknowns: &[Unknown]) -> Self {
        let covariance = covariance(certainty, estimate, unknowns);
        let places = places(estimate, unknowns);
        let known = (0..unknowns.len()).map(|k| places[k].is_none() || covariance[(k, k)] > 0.0);
        Self {
            freedom: certainty.freedom,
            own: certainty.own,
            lateral: certainty.lateral.as_ref().map(|of| of.of_unknowns(&places)),
            known: known.collect(),
            covariance,
        }
    }

    /// Those that were held.
    fn held(&self, unknowns: &[Unknown]) -> Vec<Unknown> {
        let held = unknowns
            .iter()
            .zip(&self.known)
            .filter(|(_, known)| !**known);
        held.map(|(of, _)| of.clone()).collect()
    }
}

/// The sum, zero for what either held, with degrees of freedom by each side's mean share of the variances (Welch 1947). By its share a side's
/// scale has a part in the sum's, and again by its share a side's error has a part in the difference.
fn joined(one: &Spread, two: &Spread) -> Certainty {
    let n = one.known.len();
    let known = |k: usize| one.known[k] && two.known[k];
    let covariance = DMatrix::from_fn(n, n, |a, b| {
        if known(a) && known(b) {
            one.covariance[(a, b)] + two.covariance[(a, b)]
        } else {
            0.0
        }
    });
    let share = |side: &Spread| {
        let tested = (0..n).filter(|&k| covariance[(k, k)] > 0.0);
        let shares: Vec<f64> = tested
            .map(|k| side.covariance[(k, k)] / covariance[(k, k)])
            .collect();
        shares.iter().sum::<f64>() / shares.len().max(1) as f64
    };
    let sides = [(share(one), one), (share(two), two)];
    let freedom = effective_freedom(sides.map(|(share, side)| (share, side.freedom)));
    let moments = match (&one.lateral, &two.lateral) {
        (Some(of_one), Some(of_two)) => lateral::moments(
            &covariance,
            freedom,
            [(sides[0].0, of_one), (sides[1].0, of_two)],
        ),
        _ => Moments { mean: 1.0, freedom },
    };
    Certainty {
        freedom: moments.freedom,
        own: sides
            .map(|(share, side)| share * share * side.own)
            .iter()
            .sum(),
        lateral: None,
        covariance: covariance * moments.mean,
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
                own: 0.0,
                lateral: None,
                source: String::new(),
            }),
            parity: Some((1.0e-6, 100.0)),
            amplitude_counts: [20_000.0; 4],
            looked_for_all: false,
            left_out: Vec::new(),
        }
    }

    #[test]
    fn an_effect_that_was_looked_for_is_zero_where_it_is_not() {
        let looked = |order, values| Estimate {
            looked_for_all: true,
            ..of_order(order, values, 0.1 * f64::from(order))
        };
        let apart = Difference::between(&looked(3, [1.0, 2.0]), &looked(5, [3.0, 4.0]));
        assert_eq!(apart.values().as_slice(), [-1.0, -2.0, 3.0, 4.0]);
        let certainty = apart.certainty.unwrap();
        let variances = certainty.covariance.diagonal();
        let wanted = [0.09, 0.09, 0.25, 0.25];
        assert!(
            variances
                .iter()
                .zip(wanted)
                .all(|(a, b)| (a - b).abs() < 1e-12),
            "{variances}"
        );
        assert!((certainty.freedom - 200.0).abs() < 1.0e-9 && apart.left_out.is_empty());
        let same =
            Difference::between(&of_order(1, [1.0, 2.0], 0.1), &of_order(1, [1.5, 2.0], 0.2));
        assert_eq!(same.values().as_slice(), [0.5, 0.0]);
        assert!((same.certainty.unwrap().covariance[(0, 0)] - 0.05).abs() < 1.0e-12);
    }

    #[test]
    fn what_one_has_alone_or_held_is_left_out() {
        let apart = Difference::between(&of_order(1, [1.0; 2], 0.1), &of_order(2, [1.0; 2], 0.1));
        assert!(apart.unknowns.is_empty());
        let wanted = [
            "order 1 alone has equation (3)",
            "order 2 alone has equation (3)",
        ];
        assert!(
            apart
                .left_out
                .iter()
                .zip(wanted)
                .all(|(of, begin)| of.starts_with(begin)),
            "{:?}",
            apart.left_out
        );
        let mut held = of_order(1, [1.5; 2], 0.1);
        held.certainty.as_mut().unwrap().covariance[(1, 1)] = 0.0;
        let apart = Difference::between(&of_order(1, [1.0; 2], 0.1), &held);
        let covariance = apart.certainty.unwrap().covariance;
        assert!(covariance[(0, 0)] > 0.0 && covariance[(1, 1)] == 0.0);
        assert_eq!(
            apart.left_out,
            ["order 1 held equation (3): unknowns that are left out, 1"]
        );
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
