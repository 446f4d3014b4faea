//! Motions drawn at random: kinds, order, length, speed, repetition.

use super::chance::chance;
use super::courier;
use effects::motion::Pose;
use effects::plant::Geometry;
use effects::random::{ChaCha8Rng, index, log_uniform, uniform};
use hal_sim::coordination::origin_under;
use hal_sim::courier::Courier;
use hal_sim::trajectory::{OpenLoop, Plan};

/// Rows of a recording before it is cut: small ones are cheap, and what goes wrong with little data is looked for.
pub const ROWS: [f64; 2] = [150.0, 600.0];
/// A diagnosis wants 200.
pub const ENOUGH_ROWS: [f64; 2] = [230.0, 500.0];
/// Most runs.
const MOST_RUNS: usize = 9;
/// Speeds, m/s.
const SPEEDS_M_S: [f64; 2] = [2.0e-3, 0.3];
/// Lengths of sweeps, m: a tenth of a tooth to half a platen.
const LENGTHS_M: [f64; 2] = [1.0e-4, 0.3];
/// Still poses of a run.
const POSES: [f64; 2] = [1.0, 400.0];

/// The courier and what it does, in so many rows.
pub fn courier_and_plan(rows: [f64; 2], rng: &mut ChaCha8Rng) -> (Courier, Plan) {
    let seed = (uniform(rng, 0.0, 1.0) * 2.0_f64.powi(52)) as u64;
    let home = Pose::new(
        uniform(rng, -0.05, 0.05),
        uniform(rng, -0.05, 0.05),
        uniform(rng, -0.02, 0.02),
    );
    let home = if chance(rng, 0.5) {
        Pose::default()
    } else {
        home
    };
    let open_loop = if chance(rng, 0.8) {
        OpenLoop::COURIER
    } else {
        OpenLoop::EXACT
    };
    let mut plan = Plan::new(home, Geometry::PAPER, open_loop, seed);
    for _ in 0..1 + index(rng, MOST_RUNS) {
        plan = with_run(plan, home, rng);
    }
    thin(&mut plan, rows, rng);
    relabel(&mut plan, rng);
    let spec = courier::spec(plan.duration_s(), rng);
    let courier = Courier::new(spec, seed).unwrap_or_else(|error| panic!("{error}"));
    (courier, plan)
}

/// A further run. Every second one is from a plan that people use, the rest are sweeps from anywhere to anywhere.
pub fn with_run(plan: Plan, home: Pose, rng: &mut ChaCha8Rng) -> Plan {
    let speed_m_s = log_uniform(rng, SPEEDS_M_S[0], SPEEDS_M_S[1]);
    let length_m = log_uniform(rng, LENGTHS_M[0], LENGTHS_M[1]);
    let half = 0.5 * length_m;
    let origin_m = origin_under(&Geometry::PAPER, Pose::default());
    let angle_rad = if chance(rng, 0.2) {
        0.0
    } else {
        uniform(rng, 0.0, 0.03)
    };
    let poses = log_uniform(rng, POSES[0], POSES[1]) as usize;
    let about = |offset: Pose| [home.plus(offset, -1.0), home.plus(offset, 1.0)];
    match index(rng, 9) {
        0 => plan.sweep_both_ways("flyby_x", about(Pose::new(half, 0.0, 0.0)), speed_m_s),
        1 => plan.sweep_both_ways("flyby_y", about(Pose::new(0.0, half, 0.0)), speed_m_s),
        2 => plan.sweep("one_way", about(Pose::new(half, 0.0, 0.0)), speed_m_s),
        3 => plan.sweep(
            "slanted",
            about(Pose::new(half, 0.7 * half, angle_rad)),
            speed_m_s,
        ),
        4 => plan.scatter(poses, home, length_m, angle_rad),
        5 => plan.beacon(poses, origin_m, angle_rad),
        6 => plan.spin(origin_m, angle_rad),
        7 => plan.still(home, uniform(rng, 0.01, 1.0)),
        _ => plan.sweep(
            "turning",
            about(Pose::new(0.0, 0.0, angle_rad.max(1.0e-4))),
            speed_m_s,
        ),
    }
}

/// Every n-th sample, so that all runs together have some hundred.
fn thin(plan: &mut Plan, rows: [f64; 2], rng: &mut ChaCha8Rng) {
    let wanted = log_uniform(rng, rows[0], rows[1]);
    let every = (plan.samples() as f64 / wanted).ceil().max(1.0) as usize;
    for run in &mut plan.runs {
        let kept = run.times_s.iter().copied().step_by(every);
        run.times_s = kept.collect();
    }
}

/// Labels that repeat, that are all alike, or that are missing.
pub fn relabel(plan: &mut Plan, rng: &mut ChaCha8Rng) {
    let mode = index(rng, 5);
    for (number, run) in plan.runs.iter_mut().enumerate() {
        run.name = match mode {
            0 => String::new(),
            1 => "all".into(),
            2 => format!("{} {number}", run.name),
            _ => continue,
        };
    }
}
