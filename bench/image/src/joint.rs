//! The joint calibration: one pose's rows, a solution, and the whole schedule over 1000 poses.

use crate::counter::{Statistics, measure};
use cases::joint::Problem;
use core::hint::black_box;
use cortex_m::singleton;
use cortex_m_semihosting::hprintln;
use courier_sensor::calibration::Session;
use courier_sensor::calibration::joint::{
    Groups, JOINT_UNKNOWNS, JointBuffer, JointEstimator, JointProgress, JointSession, JointSolver,
    Step, Trial, Values,
};
use courier_sensor::lsq::Estimator;

/// Unknowns of the paper's joint step, and with the coordination sensor's own errors.
const SIZES: [(usize, [&str; 4]); 2] = [
    (
        47,
        [
            "joint_row_47_p",
            "joint_row_47_x",
            "joint_row_47_y",
            "joint_solve_47",
        ],
    ),
    (
        62,
        [
            "joint_row_62_p",
            "joint_row_62_x",
            "joint_row_62_y",
            "joint_solve_62",
        ],
    ),
];

/// Prints every row.
///
/// # Panics
/// On a second call.
pub fn run() {
    hprintln!("bytes joint_session {}", size_of::<JointSession>());
    hprintln!("bytes platen_session {}", size_of::<Session>());
    let buffer = singleton!(: JointBuffer = JointBuffer::new()).expect("called once");
    let mut problem = Problem::new(5);
    problem.fill(buffer);
    let estimator = singleton!(: JointEstimator = Estimator::blank()).expect("called once");
    for (unknowns, names) in SIZES {
        rows(&problem, buffer, estimator, unknowns, names);
    }
    let solver = singleton!(: JointSolver = JointSolver::new()).expect("called once");
    schedule(&mut problem, buffer, solver);
}

/// Each constraint's row into a factor of so many unknowns, and its solution. The first as many poses as unknowns fill it.
fn rows(
    problem: &Problem,
    buffer: &JointBuffer,
    estimator: &mut JointEstimator,
    unknowns: usize,
    names: [&str; 4],
) {
    let mut linearising = Statistics::default();
    let mut entering = [Statistics::default(); 3];
    estimator.reset(unknowns);
    for (n, sample) in buffer.fitted().enumerate() {
        let (constraints, values) = (black_box(&problem.constraints), &problem.entered);
        let (taken, rows) = measure(|| constraints.rows(values, &sample));
        linearising.add(taken);
        for (row, entering) in rows.jacobian.iter().zip(&mut entering) {
            let (taken, entered) = measure(|| estimator.rows.enter(&row[..unknowns], 1.0e-3));
            assert!(entered.is_ok());
            if n >= unknowns {
                entering.add(taken);
            }
        }
    }
    linearising.print("joint_linearise");
    for (statistics, name) in entering.iter().zip(names) {
        statistics.print(name);
    }
    for i in 0..unknowns {
        // As the priors do: what the poses do not tell.
        let mut row: Values = [0.0; JOINT_UNKNOWNS];
        row[i] = 1.0;
        assert!(estimator.rows.enter(&row[..unknowns], 0.0).is_ok());
    }
    let mut solving = Statistics::default();
    let (taken, solved) = measure(|| estimator.solve_equilibrated().is_ok());
    assert!(solved);
    solving.add(taken);
    solving.print(names[3]);
}

/// All steps; a slice is what the main loop does between two looks at everything else.
fn schedule(problem: &mut Problem, buffer: &JointBuffer, solver: &mut JointSolver) {
    let constraints = &mut problem.constraints;
    solver.set_priors(constraints, &problem.entered, &problem.priors);
    let mut progress = JointProgress {
        values: problem.entered,
        accepted: Groups::empty(),
    };
    let (mut slices, mut trial) = (Statistics::default(), Trial::idle());
    for step in Step::ALL {
        trial.begin(step, constraints, solver, &progress);
        loop {
            let slice = || trial.slice(constraints, solver, buffer, &mut progress);
            let (taken, sliced) = measure(slice);
            slices.add(taken);
            if let Some(report) = sliced.expect("the problem can be solved") {
                hprintln!("step {:?} accepted {}", step, report.accepted);
                break;
            }
        }
    }
    slices.print("joint_slice");
}
