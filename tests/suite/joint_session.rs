//! The joint session: a courier under a beacon, from the first pose to the outcome, and everything that is refused.
use crate::common::beacon::*;
use crate::common::normal;
use courier_sensor::calibration::joint::*;
use courier_sensor::calibration::*;
use courier_sensor::frame::Status;
use nalgebra::DMatrix;

fn config() -> JointConfig {
    let noise = ReadingNoise {
        segment_m: 0.1e-6,
        displacement_m: 0.1e-6,
    };
    let default = JointConfig::default();
    JointConfig {
        visits: Visits {
            poses: 400,
            held_out_poses: 120,
            frames_per_pose: 4,
            rest: 0,
            ..default.visits
        },
        noise,
        ..default
    }
}

fn courier(seed: u64) -> BeaconCourier {
    BeaconCourier::new(seed, 5.0e-6, 0.2e-6)
}

fn run(courier: &mut BeaconCourier, config: JointConfig, trouble: &Trouble) -> JointOutcome {
    run_with_steps(courier, config, trouble).0
}

fn run_with_steps(
    courier: &mut BeaconCourier,
    config: JointConfig,
    trouble: &Trouble,
) -> (JointOutcome, Vec<StepReport>) {
    let mut session = Box::new(JointSession::idle());
    let outcome = courier.run(&mut session, config, trouble);
    (outcome, session.reports().to_vec())
}

fn refused(courier: &mut BeaconCourier, config: JointConfig, trouble: &Trouble) -> Refusal {
    let refusal = run(courier, config, trouble).result.expect_err("refused");
    println!("{refusal}");
    refusal
}

#[test]
fn session_finds_height_lever_arm_and_all_coefficients() {
    for plan in [Plan::Random, Plan::Optimal] {
        let mut courier = courier(1);
        let mut config = config();
        config.visits.plan = plan;
        let (outcome, steps) = run_with_steps(&mut courier, config, &Trouble::default());
        let result = outcome.result.unwrap();
        for report in &steps {
            println!(
                "{:?}: accepted {}, {:.3} -> {:.3}",
                report.step, report.accepted, report.before.whitened_rms, report.after.whitened_rms
            );
        }
        let squares: f64 = (0..4)
            .flat_map(|segment| {
                let mut found = [0.0; 10];
                result.model.read_columns(segment, &mut found);
                let k = courier.k[segment];
                (0..10).map(move |i| (f64::from(found[i]) - k[i]).powi(2))
            })
            .sum();
        println!(
            "{plan:?}: coefficients {:.4} um rms, {:?}",
            (squares / 40.0).sqrt() * 1e6,
            outcome.evidence
        );
        assert!((squares / 40.0).sqrt() < 0.05e-6);
        assert!((f64::from(result.geometry.height_m) - courier.height_m).abs() < 5.0e-6);
        let origin: [f64; 2] = std::array::from_fn(|i| {
            f64::from(result.origin_m[i]) + f64::from(result.origin_teeth[i]) * PITCH
        });
        for i in 0..2 {
            assert!((f64::from(result.geometry.lever_m[i]) - courier.lever_m[i]).abs() < 20.0e-6);
            assert!(
                (origin[i] - courier.origin_m[i]).abs() < 40.0e-6,
                "{origin:?}"
            );
        }
    }
}

#[test]
fn lever_arm_off_by_a_fifth_gives_the_same_answer() {
    let find = |factor: f32| {
        let mut config = config();
        config.geometry.lever_m = config.geometry.lever_m.map(|l| l * factor);
        config.geometry.height_m *= factor;
        run(&mut courier(2), config, &Trouble::default())
            .result
            .unwrap()
            .geometry
    };
    let (exact, far) = (find(1.0), find(0.8));
    // The entered lever arm steers the motion, so the data differ; both answers are right within the bound of 6 um rms.
    assert!(
        (exact.lever_m[0] - far.lever_m[0]).abs() < 30.0e-6,
        "{exact:?} {far:?}"
    );
    assert!((exact.height_m - far.height_m).abs() < 5.0e-6);
}

#[test]
fn platen_with_bad_teeth_is_calibrated_none_the_less() {
    let mut courier = BeaconCourier {
        structure: |rng| std::array::from_fn(|_| 1.9e-6 * normal(rng)),
        ..courier(3)
    };
    let mut config = config();
    config.visits.poses = 1000;
    let (outcome, steps) = run_with_steps(&mut courier, config, &Trouble::default());
    let result = outcome.result.unwrap();
    let last = steps.iter().rev().find(|r| r.accepted).unwrap();
    println!("{last:?}");
    assert!((last.after.whitened_rms - 1.0).abs() < 0.15);
    assert!((f64::from(result.geometry.lever_m[0]) - courier.lever_m[0]).abs() < 120.0e-6);
}

#[test]
fn beacon_refusals() {
    let gone = Trouble {
        status: |_| Status::BEACON_MISSING,
        ..Trouble::default()
    };
    assert!(matches!(
        refused(&mut courier(4), config(), &gone),
        Refusal::BadFrames {
            status: Status::BEACON_MISSING,
            pose: 0,
            ..
        }
    ));
    let comes_and_goes = Trouble {
        status: |n| {
            if n % 5 == 4 {
                Status::BEACON_MISSING
            } else {
                Status::empty()
            }
        },
        ..Trouble::default()
    };
    assert!(matches!(
        refused(&mut courier(4), config(), &comes_and_goes),
        Refusal::BadFrames {
            status: Status::BEACON_MISSING,
            ..
        }
    ));
    let stray = Trouble {
        status: |n| {
            if n > 50 {
                Status::BEACON_SATURATED
            } else {
                Status::empty()
            }
        },
        ..Trouble::default()
    };
    assert!(matches!(
        refused(&mut courier(4), config(), &stray),
        Refusal::BadFrames {
            status: Status::BEACON_SATURATED,
            ..
        }
    ));
    let second = Trouble {
        light: |n| if n > 30 { 15_000 } else { 8000 },
        ..Trouble::default()
    };
    match refused(&mut courier(4), config(), &second) {
        Refusal::Light {
            light_counts,
            reference_counts,
            ..
        } => assert_eq!((light_counts, reference_counts), (60_000.0, 32_000.0)),
        other => panic!("{other}"),
    }
    let seldom = Trouble {
        status: |n| {
            if n % 20 == 9 {
                Status::BEACON_MISSING
            } else {
                Status::empty()
            }
        },
        ..Trouble::default()
    };
    let outcome = run(&mut courier(4), config(), &seldom);
    assert!(
        outcome.result.is_ok() && outcome.evidence.lost == 26,
        "{:?}",
        outcome.evidence
    );
}

#[test]
fn motion_and_geometry_refusals() {
    let mut still = config();
    still.visits.range.turn_rad = 0.0;
    match refused(&mut courier(5), still, &Trouble::default()) {
        Refusal::NoRotation {
            turn_rad,
            wanted_rad,
        } => assert!(turn_rad < wanted_rad),
        other => panic!("{other}"),
    }
    let mut wrong_sign = config();
    wrong_sign.geometry.lever_m[0] *= -1.0;
    match refused(&mut courier(5), wrong_sign, &Trouble::default()) {
        Refusal::Geometry {
            name: Length::LeverX,
            entered_m,
            found_m,
            ..
        } => assert!(entered_m == -0.09 && found_m > 0.0),
        other => panic!("{other}"),
    }
    let mut millimetres = config();
    millimetres.geometry.lever_m[0] = 90.0;
    let error = JointSession::idle().start(&mut millimetres).unwrap_err();
    assert_eq!(error.to_string(), "lever_m[0] is 90, wanted -1 to 1");
    let mut session = Box::new(JointSession::idle());
    session.start(&mut config()).unwrap();
    assert_eq!(session.start(&mut config()), Err(StartError::Busy));
    session.abort();
    assert_eq!(session.outcome().unwrap().result, Err(Refusal::Aborted));
}

/// A third cannot be reached here: at ±1.5° random poses are already within a factor of two of the best possible design.
#[test]
fn chosen_poses_come_near_the_bound_of_all_plans() {
    let config = config();
    let courier = courier(6);
    let constraints = Constraints {
        geometry: config.geometry,
        noise: config.noise,
        ..courier.constraints()
    };
    let values = entered(&constraints.layout, &config.model, &config.geometry);
    let start = Sample::ZERO;
    let mut solver = Box::new(JointSolver::new());
    solver.set_priors(&constraints, &values, &Priors::default());
    let optimum = least_variance_sum(&constraints, &values, &config);
    for seed in 0..3 {
        let mut planner = Planner::new(config.visits.range, seed);
        solver.begin_plan(&constraints, &values, Groups::PAPER);
        for _ in 0..1000 {
            let pose = about_sensor(config.geometry.lever_m, planner.centred(false));
            solver.add_to_plan(
                &constraints,
                &values,
                &foreseen_under_beacon(&constraints, &values, &start, &pose),
            );
        }
        let target = solver.rms_deviation_m(&constraints);
        solver.begin_plan(&constraints, &values, Groups::PAPER);
        let mut count = 0;
        while solver.rms_deviation_m(&constraints) > target {
            let pose = solver.choose(&constraints, &values, &start, &mut planner);
            solver.add_to_plan(
                &constraints,
                &values,
                &foreseen_under_beacon(&constraints, &values, &start, &pose),
            );
            count += 1;
        }
        let least = optimum / (8.0 * f64::from(target * target));
        println!(
            "joint: {count} chosen poses reach the {:.4} um rms of 1000 random ones; no plan needs fewer than {least:.0}",
            target * 1e6
        );
        assert!(f64::from(count) < 1.05 * least);
    }
}

/// Lower bound of (number of poses) * (sum of the coefficients' variances) over all plans of this range: the A-optimal
/// approximate design by the multiplicative algorithm (Silvey, Titterington and Torsney 1978) over random poses, half of them
/// turned fully, and from it the bound by convexity.
fn least_variance_sum(constraints: &Constraints, values: &Values, config: &JointConfig) -> f64 {
    const UNKNOWNS: usize = 47;
    const COEFFICIENTS: usize = 40;
    let mut planner = Planner::new(config.visits.range, 77);
    let jacobians: Vec<DMatrix<f64>> = (0..1500)
        .map(|i| {
            let pose = about_sensor(config.geometry.lever_m, planner.centred(i % 2 == 0));
            let rows = constraints.rows(
                values,
                &foreseen_under_beacon(constraints, values, &Sample::ZERO, &pose),
            );
            // Lengths in units that make all columns about equally long.
            let unit = |j: usize| if j < COEFFICIENTS { 1.0 } else { 30.0 };
            DMatrix::from_fn(3, UNKNOWNS, |r, j| {
                f64::from(rows.jacobian[r][j]) * 1e-6 * unit(j)
            })
        })
        .collect();
    let mut weights = vec![1.0 / jacobians.len() as f64; jacobians.len()];
    let mut bound = 0.0f64;
    for _ in 0..80 {
        let mut information = DMatrix::zeros(UNKNOWNS, UNKNOWNS);
        for (j, w) in jacobians.iter().zip(&weights) {
            information += j.transpose() * j * *w;
        }
        let covariance = information.try_inverse().unwrap();
        let variance: f64 = (0..COEFFICIENTS).map(|i| covariance[(i, i)]).sum();
        let picked = covariance.columns(0, COEFFICIENTS).into_owned();
        let gains: Vec<f64> = jacobians
            .iter()
            .map(|j| (j * &picked).norm_squared())
            .collect();
        bound = bound.max(variance * variance / gains.iter().copied().fold(0.0, f64::max));
        for (w, gain) in weights.iter_mut().zip(&gains) {
            *w *= (gain / variance).sqrt();
        }
        let total: f64 = weights.iter().sum();
        weights.iter_mut().for_each(|w| *w /= total);
    }
    bound * 1e-12
}
