//! The motions that a diagnosis wants, as runs to record: both directions, three speeds, turned to either side, turning, still.

use crate::recorder::Run;
use courier_sensor::drivers::motion::Target;

/// Length of the fly-bys, metres: forty teeth.
const FLYBY_M: f32 = 40.0e-3;
/// Their speeds, m/s: slow ones are a quarter as long.
const SPEEDS_M_S: [f32; 3] = [0.01, 0.05, 0.2];
/// Angle of the turned fly-bys, and half of the spin's, radians.
const TURN_RAD: f32 = 8.727e-3;
/// Arm at which an angle counts as a distance, metres: the motion controller's.
const ARM_M: f32 = 0.1;
/// A move that starts and ends at rest with this peak speed takes so much longer than an even one, and a rest after it.
const EASE: f32 = 1.875;
const REST_S: f32 = 0.05;

/// Runs about a place: some 25 s of motion.
#[must_use]
pub fn runs(centre: Target) -> Vec<Run> {
    let mut runs = Vec::new();
    for speed in SPEEDS_M_S {
        let half_m = 0.5 * if speed < 0.02 { FLYBY_M / 4.0 } else { FLYBY_M };
        let name = |axis| format!("flyby_{axis}_{:.0}mm_s", 1.0e3 * speed);
        there_and_back(
            &mut runs,
            &name("x"),
            about(centre, [half_m, 0.0, 0.0]),
            speed,
        );
        there_and_back(
            &mut runs,
            &name("y"),
            about(centre, [0.0, half_m, 0.0]),
            speed,
        );
    }
    let half_m = 0.5 * FLYBY_M;
    for (side, turn_rad) in [("left", TURN_RAD), ("right", -TURN_RAD)] {
        let turned = Target {
            theta_rad: centre.theta_rad + turn_rad,
            ..centre
        };
        let speed = SPEEDS_M_S[1];
        there_and_back(
            &mut runs,
            &format!("turned_{side}"),
            about(turned, [0.7 * half_m, half_m, 0.0]),
            speed,
        );
    }
    there_and_back(
        &mut runs,
        "spin",
        about(centre, [0.0, 0.0, TURN_RAD]),
        SPEEDS_M_S[0] / 2.0,
    );
    runs.push(Run {
        name: "still".into(),
        from: Some(centre),
        to: None,
        seconds: 0.5,
    });
    runs
}

fn about(centre: Target, [x_m, y_m, theta_rad]: [f32; 3]) -> [Target; 2] {
    [-1.0, 1.0].map(|side| Target {
        x_m: centre.x_m + side * x_m,
        y_m: centre.y_m + side * y_m,
        theta_rad: centre.theta_rad + side * theta_rad,
    })
}

fn there_and_back(runs: &mut Vec<Run>, name: &str, [from, to]: [Target; 2], speed_m_s: f32) {
    let distance_m = (to.x_m - from.x_m)
        .hypot(to.y_m - from.y_m)
        .max(ARM_M * (to.theta_rad - from.theta_rad).abs());
    let seconds = f64::from(EASE * distance_m / speed_m_s + REST_S);
    let run = |name: String, from, to| Run {
        name,
        from: Some(from),
        to: Some((to, speed_m_s)),
        seconds,
    };
    runs.push(run(name.to_owned(), from, to));
    runs.push(run(format!("{name}_back"), to, from));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_stay_about_their_place_and_return() {
        let centre = Target {
            x_m: 0.1,
            y_m: -0.2,
            theta_rad: 0.0,
        };
        let runs = runs(centre);
        assert_eq!(runs.len(), 19);
        for run in &runs {
            let (to, speed) = run.to.unwrap_or((centre, 0.1));
            let far =
                [run.from.unwrap(), to].map(|at| (at.x_m - centre.x_m).hypot(at.y_m - centre.y_m));
            assert!(
                far.iter().all(|far| *far < 0.026) && speed > 0.0 && run.seconds < 5.0,
                "{run:?}"
            );
        }
        let total: f64 = runs.iter().map(|run| run.seconds).sum();
        assert!((15.0..35.0).contains(&total), "{total}");
    }
}
