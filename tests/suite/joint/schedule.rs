//! The schedule of steps: what is there is accepted and found, what is not is refused.

use super::TURN;
use crate::common::beacon::*;
use courier_sensor::calibration::joint::*;

fn collected(courier: &mut BeaconCourier, half_range_m: f64) -> Box<JointBuffer> {
    let mut buffer = Box::new(JointBuffer::new());
    for (i, reading) in courier
        .readings(1200, half_range_m, TURN)
        .iter()
        .enumerate()
    {
        assert!(buffer.push(reading.sample));
        if i == 999 {
            buffer.hold_out_rest();
        }
    }
    buffer
}

fn schedule(
    courier: &BeaconCourier,
    buffer: &JointBuffer,
    steps: &[Step],
) -> (JointProgress, Vec<StepReport>, Constraints) {
    let mut constraints = courier.constraints();
    let mut entered = [0.0; JOINT_UNKNOWNS];
    for (i, value) in courier.truth().iter().enumerate() {
        match constraints.layout.unknown(i) {
            Unknown::Height | Unknown::Lever(_) => entered[i] = 1.05 * *value as f32,
            _ => {}
        }
    }
    let mut solver = Box::new(JointSolver::new());
    solver.set_priors(&constraints, &entered, &Priors::default());
    let mut progress = JointProgress {
        values: entered,
        accepted: Groups::empty(),
    };
    let mut trial = Trial::idle();
    let reports = steps
        .iter()
        .map(|&step| {
            trial.begin(step, &constraints, &mut solver, &progress);
            loop {
                let sliced = trial.slice(&mut constraints, &mut solver, buffer, &mut progress);
                if let Some(report) = sliced.unwrap() {
                    return report;
                }
            }
        })
        .collect();
    (progress, reports, constraints)
}

#[test]
fn schedule_accepts_what_is_there_and_refuses_what_is_not() {
    let mut courier = BeaconCourier::new(4, 5.0e-6, 0.5e-6);
    let buffer = collected(&mut courier, PITCH);
    let (progress, reports, _) = schedule(&courier, &buffer, &Step::ALL);
    for report in &reports {
        println!("{report:?}");
    }
    let accepted: Vec<bool> = reports.iter().map(|r| r.accepted).collect();
    assert_eq!(accepted, [true, true, true, false, false]);
    assert!(!progress.accepted.intersects(Groups::SENSOR));
    assert!((reports[2].after.whitened_rms - 1.0).abs() < 0.1);
}

#[test]
fn sensors_own_errors_are_found_where_they_are() {
    let mut courier = BeaconCourier::new(5, 5.0e-6, 0.5e-6);
    courier.sensor = [
        0.02, -0.01, 0.1, 0.03, 0.05, 0.02, -0.02, 0.01, 0.01, 0.12, -0.02, 0.04, -0.02, 0.01,
        0.02, -0.01,
    ];
    let buffer = collected(&mut courier, 2.0 * PITCH);
    let (progress, reports, constraints) = schedule(&courier, &buffer, &Step::ALL);
    for report in &reports {
        println!("{report:?}");
    }
    assert!(reports[3].accepted && reports[4].accepted);
    assert!((reports[4].after.whitened_rms - 1.0).abs() < 0.1);
    // A common turn of the diode and of the segments' constants is gauge: only their sum can be compared.
    let truth = courier.truth();
    let sum = |v: &dyn Fn(usize) -> f64| v(48) + v(41) / (2.0 * SPAN);
    assert_eq!(constraints.layout.unknown(48), Unknown::Turn);
    assert_eq!(constraints.layout.unknown(41), Unknown::AngleOffset);
    let off = sum(&|i| f64::from(progress.values[i])) - sum(&|i| truth[i]);
    assert!(off.abs() < 0.3e-3, "{off}");
    let squares: f64 = (0..40)
        .map(|i| (f64::from(progress.values[i]) - truth[i]).powi(2))
        .sum();
    assert!((squares / 40.0).sqrt() < 0.1e-6, "{squares:e}");
}
