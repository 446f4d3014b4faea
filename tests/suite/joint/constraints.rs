//! The three constraints: their derivative, their covariance, their plain sum of squares.

use super::{TURN, fit, samples, values};
use crate::common::beacon::*;
use courier_sensor::calibration::joint::*;

#[test]
fn jacobian_is_the_derivative_and_true_values_leave_no_misclosure() {
    let mut courier = BeaconCourier::new(1, 5.0e-6, 0.0);
    courier.sensor = std::array::from_fn(|i| 0.01 * (i as f64 - 7.0));
    let noise = ReadingNoise {
        segment_m: 1.0e-6,
        displacement_m: 1.0e-6,
    };
    let constraints = Constraints {
        noise,
        ..courier.constraints()
    };
    let truth = values(&courier.truth());
    for reading in courier.readings(20, PITCH, TURN) {
        let m = constraints.misclosure(&truth, &reading.sample);
        assert!(m.iter().all(|m| m.abs() < 60.0e-9), "{m:?}");
        let rows = constraints.rows(&truth, &reading.sample);
        for i in 0..constraints.layout.len() {
            let step = match constraints.layout.unknown(i) {
                Unknown::Height | Unknown::Lever(_) | Unknown::Place(_) => 1.0e-3,
                Unknown::GainDifference | Unknown::Turn | Unknown::Nonlinearity(..) => 0.5,
                _ => 3.0e-5,
            };
            let moved = |by: f32| {
                let mut v = truth;
                v[i] += by;
                constraints.whitened(&v, &truth, &reading.sample)
            };
            let (up, down) = (moved(step), moved(-step));
            for row in 0..3 {
                let numeric = (up[row] - down[row]) / (2.0 * step);
                let analytic = rows.jacobian[row][i];
                let size = rows.jacobian.iter().map(|r| r[i].abs()).fold(0.0, f32::max);
                assert!(
                    (numeric - analytic).abs() < 0.02 * size + 1.0e-4 / step,
                    "{} row {row}: {numeric} {analytic}",
                    constraints.layout.unknown(i)
                );
            }
        }
    }
}

#[test]
fn whitening_is_by_the_true_covariance() {
    let mut courier = BeaconCourier::new(6, 5.0e-6, 1.0e-6);
    let (constraints, truth) = (courier.constraints(), values(&courier.truth()));
    let mut sums = [[0.0f64; 3]; 3];
    const COUNT: usize = 40_000;
    for reading in courier.readings(COUNT, PITCH, TURN) {
        let w = constraints
            .whitened(&truth, &truth, &reading.sample)
            .map(f64::from);
        for (i, row) in sums.iter_mut().enumerate() {
            row.iter_mut()
                .zip(w)
                .for_each(|(sum, other)| *sum += w[i] * other / COUNT as f64);
        }
    }
    for (i, row) in sums.iter().enumerate() {
        for (j, value) in row.iter().enumerate() {
            let wanted = if i == j { 1.0 } else { 0.0 };
            // Scatter of a mean of 40,000 products: 0.7 % on the diagonal, 0.5 % beside it.
            assert!((value - wanted).abs() < 0.03, "{sums:?}");
        }
    }
}

/// Equal weights minimise the plain sum of squares of equations (5) and (11), the paper's J.
#[test]
fn equal_weights_minimise_the_papers_cost() {
    let mut errors = [0.0; 2];
    for seed in 0..20 {
        let mut courier = BeaconCourier::new(300 + seed, 5.0e-6, 1.0e-6);
        let samples = samples(&mut courier, 300);
        let start = values(&courier.truth());
        let mut costs = [0.0; 2];
        for (k, weighting) in [Weighting::Equal, Weighting::Covariance]
            .into_iter()
            .enumerate()
        {
            let constraints = Constraints {
                weighting,
                ..courier.constraints()
            };
            let found = fit(&constraints, &samples, &start, &Priors::default()).found;
            let cost = |values: &Values| -> f64 {
                let of = |sample| {
                    constraints
                        .misclosure(values, sample)
                        .map(|g| f64::from(g).powi(2))
                };
                samples.iter().flat_map(of).sum()
            };
            costs[k] = cost(&found);
            let lever = (0..constraints.layout.len())
                .find(|i| constraints.layout.unknown(*i) == Unknown::Lever(0))
                .unwrap();
            errors[k] += f64::from(found[lever] - start[lever]).powi(2) / 20.0;
            if weighting == Weighting::Equal {
                for column in [0, 9, lever] {
                    let mut aside = found;
                    aside[column] += if column == lever { 1.0e-4 } else { 0.5e-6 };
                    assert!(
                        cost(&aside) > costs[0],
                        "{}",
                        constraints.layout.unknown(column)
                    );
                }
            }
        }
        assert!(costs[0] < costs[1], "{costs:?}");
    }
    println!(
        "l_x: rms {:.1} um by equal weights, {:.1} um by covariance",
        errors[0].sqrt() * 1e6,
        errors[1].sqrt() * 1e6
    );
}
