//! The paper's synthetic problem: errors against their predicted covariance, f32 against f64.

use super::{Fit, fit, samples, values};
use crate::common::beacon::*;
use crate::common::normal;
use courier_sensor::calibration::joint::*;
use nalgebra::{DMatrix, DVector};
use rand::RngExt;

struct Fitted {
    errors: Vec<f64>,
    covariance: DMatrix<f64>,
    free: Vec<usize>,
    report: FitReport,
}

/// The paper's synthetic problem from stated relative errors of height and lever arm.
fn synthetic(seed: u64, initial: f64) -> Fitted {
    let mut courier = BeaconCourier::new(seed, 5.0e-6, 1.0e-6);
    let samples = samples(&mut courier, 1000);
    let constraints = courier.constraints();
    let truth = courier.truth();
    let mut start = values(&truth);
    let layout = &constraints.layout;
    for i in 0..layout.len() {
        let sign = if courier.rng.random::<bool>() {
            1.0
        } else {
            -1.0
        };
        match layout.unknown(i) {
            Unknown::Coefficient { .. } => start[i] += (3.0e-6 * normal(&mut courier.rng)) as f32,
            Unknown::Height | Unknown::Lever(_) => start[i] *= (1.0 + sign * initial) as f32,
            Unknown::ParityOffset | Unknown::AngleOffset => start[i] = 0.0,
            Unknown::Place(_) => start[i] = 0.0,
            _ => {}
        }
    }
    let Fit {
        solver,
        found,
        report,
    } = fit(&constraints, &samples, &start, &Priors::default());
    let free: Vec<usize> = solver.free().iter().map(|&i| i.into()).collect();
    let errors = free
        .iter()
        .map(|&i| f64::from(found[i]) - truth[i])
        .collect();
    let covariance = DMatrix::from_fn(free.len(), free.len(), |i, j| {
        f64::from(solver.estimator().covariance(i, j))
    });
    Fitted {
        errors,
        covariance,
        free,
        report,
    }
}

/// The paper's synthetic problem: 1000 poses within two pitches and 1.5°, 1 um noise on every reading, 3 um initial errors
/// of the coefficients. The estimator must reach the Cramér-Rao bound, which is its predicted covariance where the mean
/// squared normalised error is one; the bound, not the estimator, keeps the lever arm above 12 um.
#[test]
fn synthetic_problem_of_the_paper() {
    let layout = BeaconCourier::new(0, 1e-6, 1e-6).constraints().layout;
    const SEEDS: u64 = 50;
    const NAMES: [&str; 5] = ["h", "l_x, l_y", "coefficients", "offsets", "beacon's place"];
    let (mut nees, mut worst, mut squares, mut bound, mut counts) =
        (0.0, [0.0f64; 5], [0.0; 5], [0.0; 5], [0.0; 5]);
    for seed in 0..SEEDS {
        let fitted = synthetic(seed, 0.05);
        assert!(
            fitted.report.settled && fitted.report.rank == 47,
            "{:?}",
            fitted.report
        );
        let e = DVector::from_vec(fitted.errors.clone());
        nees += (e.transpose() * fitted.covariance.clone().try_inverse().unwrap() * &e)[(0, 0)]
            / e.len() as f64
            / SEEDS as f64;
        for (column, &i) in fitted.free.iter().enumerate() {
            let kind = match layout.unknown(i) {
                Unknown::Height => 0,
                Unknown::Lever(_) => 1,
                Unknown::Coefficient { .. } => 2,
                Unknown::ParityOffset | Unknown::AngleOffset => 3,
                _ => 4,
            };
            worst[kind] = worst[kind].max(fitted.errors[column].abs());
            squares[kind] += fitted.errors[column].powi(2);
            bound[kind] += fitted.covariance[(column, column)];
            counts[kind] += 1.0;
        }
    }
    println!("synthetic joint calibration, {SEEDS} seeds: mean squared normalised error {nees:.3}");
    for kind in 0..5 {
        let (rms, bound) = (
            (squares[kind] / counts[kind]).sqrt() * 1e6,
            (bound[kind] / counts[kind]).sqrt() * 1e6,
        );
        println!(
            "  {}: worst {:.3} um, rms {rms:.3} um, Cramér-Rao bound {bound:.3} um",
            NAMES[kind],
            worst[kind] * 1e6
        );
        // A rms of n numbers scatters by 1 / sqrt(2 n).
        assert!(rms / bound < 1.05 + 3.0 / (2.0 * counts[kind]).sqrt());
    }
    assert!((0.9..1.1).contains(&nees), "{nees}");
    assert!(worst[0] < 12.0e-6);
    assert!(worst[1] < 4.0 * (bound[1] / counts[1]).sqrt());
}

#[test]
fn twenty_percent_initial_errors_give_the_same_answer() {
    for seed in 0..5 {
        let (near, far) = (synthetic(seed, 0.05), synthetic(seed, 0.2));
        for (column, (a, b)) in near.errors.iter().zip(&far.errors).enumerate() {
            let deviation = near.covariance[(column, column)].sqrt();
            assert!((a - b).abs() < 0.03 * deviation, "{a:e} {b:e}");
        }
    }
}

#[test]
fn device_f32_agrees_with_f64_on_the_same_rows() {
    let mut courier = BeaconCourier::new(3, 5.0e-6, 1.0e-6);
    let samples = samples(&mut courier, 1000);
    let constraints = courier.constraints();
    let priors = Priors {
        coefficient_m: 1.0,
        ..Priors::default()
    };
    let truth = values(&courier.truth());
    let Fit { solver, found, .. } = fit(&constraints, &samples, &truth, &priors);
    // A Gauss-Newton step in f64 from where f32 came to rest says how far off that is.
    let free: Vec<usize> = solver.free().iter().map(|&i| i.into()).collect();
    let (mut matrix, mut rhs) = (Vec::new(), Vec::new());
    for rows in samples.iter().map(|s| constraints.rows(&found, s)) {
        for (row, w) in rows.jacobian.iter().zip(rows.misclosure) {
            matrix.extend(free.iter().map(|&i| f64::from(row[i])));
            rhs.push(-f64::from(w));
        }
    }
    let jacobian = DMatrix::from_row_slice(3000, free.len(), &matrix);
    let lengths: Vec<f64> = jacobian.column_iter().map(|c| c.norm()).collect();
    let scaled = DMatrix::from_fn(3000, free.len(), |i, j| jacobian[(i, j)] / lengths[j]);
    let step = scaled
        .svd(true, true)
        .solve(&DVector::from_vec(rhs), 0.0)
        .unwrap();
    let squares: f64 = (0..40).map(|i| (step[i] / lengths[i]).powi(2)).sum();
    let apart = (squares / 8.0).sqrt();
    println!(
        "joint: f32 against f64 on the same rows, calibrated positions {:.3} nm rms apart",
        apart * 1e9
    );
    assert!(apart < 20.0e-9);
}

#[test]
fn lateral_terms_are_within_three_deviations_and_a_tenth_of_a_micrometre() {
    let mut squares = 0.0;
    for seed in 0..10 {
        let fitted = synthetic(100 + seed, 0.05);
        for segment in 0..4 {
            for column in [10 * segment + 8, 10 * segment + 9] {
                let (error, deviation) = (
                    fitted.errors[column],
                    fitted.covariance[(column, column)].sqrt(),
                );
                squares += error * error / 80.0;
                // 80 draws: one beyond three deviations is expected in four runs of this test.
                assert!(error.abs() < 3.5 * deviation);
            }
        }
    }
    println!("lateral coefficients: {:.4} um rms", squares.sqrt() * 1e6);
    assert!(squares.sqrt() < 0.1e-6);
}

/// Whether the lever arm's scatter is the bound's needs many seeds: the rms of n numbers scatters by 1 / sqrt(2 n), 2.5 % for the
/// two components of 400. Over 50 seeds, as above, it is 10 % for l_x, which carries the sum.
#[test]
#[ignore = "nightly: a quarter of a minute"]
fn lever_arm_reaches_its_bound_within_five_percent() {
    const SEEDS: u64 = 400;
    const THREADS: u64 = 2;
    let layout = BeaconCourier::new(0, 1e-6, 1e-6).constraints().layout;
    let is_lever = |&i: &usize| matches!(layout.unknown(i), Unknown::Lever(_));
    let of_thread = |thread: u64| {
        let mut sums = [[0.0; 2]; 2];
        for seed in (thread..SEEDS).step_by(THREADS as usize) {
            let fitted = synthetic(1000 + seed, 0.05);
            let levers = (0..fitted.free.len()).filter(|c| is_lever(&fitted.free[*c]));
            for (sum, c) in sums.iter_mut().zip(levers) {
                sum[0] += fitted.errors[c].powi(2) / SEEDS as f64;
                sum[1] += fitted.covariance[(c, c)] / SEEDS as f64;
            }
        }
        sums
    };
    let parts: Vec<_> = std::thread::scope(|scope| {
        let of_thread = &of_thread;
        let threads: Vec<_> = (0..THREADS)
            .map(|t| scope.spawn(move || of_thread(t)))
            .collect();
        threads.into_iter().map(|t| t.join().unwrap()).collect()
    });
    let mut ratios = [0.0; 2];
    for (axis, ratio) in ratios.iter_mut().enumerate() {
        let [square, bound] = [0, 1].map(|k| parts.iter().map(|sums| sums[axis][k]).sum::<f64>());
        *ratio = square / bound;
        println!(
            "l_{}: rms {:.2} um over {SEEDS} seeds, Cramér-Rao bound {:.2} um",
            ["x", "y"][axis],
            square.sqrt() * 1e6,
            bound.sqrt() * 1e6
        );
    }
    let pooled = (0.5 * (ratios[0] + ratios[1])).sqrt();
    assert!((0.95..1.05).contains(&pooled), "{pooled}");
}
