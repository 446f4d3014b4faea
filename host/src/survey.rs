//! Motions as runs to record. A diagnosis wants both directions, three speeds, turned to either side, turning, still; a tooth map
//! wants its area gone over in all directions and angles.

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

/// Half the width of a map's area, and the largest angle either way: the joint calibration's, 2 pitches across and 1.5 degrees.
const MAP_REACH_M: f32 = 1.016e-3;
/// See [`MAP_REACH_M`].
const MAP_TURN_RAD: f32 = 26.18e-3;
/// Sweeps of a map, and their speed, m/s: slow enough that a delay does not count.
const MAP_SWEEPS: u32 = 60;
/// See [`MAP_SWEEPS`].
const MAP_SPEED_M_S: f32 = 0.01;
/// Steps of an even cover of x, y and angle (Roberts 2018: powers of the generalised golden ratio).
const EVEN: [f32; 3] = [0.819_173, 0.671_044, 0.549_700];

/// Runs for a tooth map about a place where the coordination sensor stands under a beacon: from pose to pose, turned about that
/// sensor; some 40 s of motion. `lever_m` is where it sits from the middle of the platen sensor.
#[must_use]
pub fn under_beacon(centre: Target, lever_m: [f32; 2]) -> Vec<Run> {
    let pose = |k: u32| {
        let [x, y, turn] = EVEN.map(|step| 2.0 * (k as f32 * step).fract() - 1.0);
        let turn_rad = MAP_TURN_RAD * turn;
        let theta_rad = centre.theta_rad + turn_rad;
        let [before, after] = [centre.theta_rad, theta_rad].map(|angle| turned(lever_m, angle));
        Target {
            x_m: centre.x_m + MAP_REACH_M * x + before[0] - after[0],
            y_m: centre.y_m + MAP_REACH_M * y + before[1] - after[1],
            theta_rad,
        }
    };
    let mut runs = Vec::new();
    for k in 0..MAP_SWEEPS {
        sweep(
            &mut runs,
            format!("sweep_{k}"),
            [pose(k), pose(k + 1)],
            MAP_SPEED_M_S,
        );
    }
    runs
}

fn turned([x, y]: [f32; 2], angle_rad: f32) -> [f32; 2] {
    let (sine, cosine) = angle_rad.sin_cos();
    [cosine * x - sine * y, sine * x + cosine * y]
}

fn about(centre: Target, [x_m, y_m, theta_rad]: [f32; 3]) -> [Target; 2] {
    [-1.0, 1.0].map(|side| Target {
        x_m: centre.x_m + side * x_m,
        y_m: centre.y_m + side * y_m,
        theta_rad: centre.theta_rad + side * theta_rad,
    })
}

fn there_and_back(runs: &mut Vec<Run>, name: &str, [from, to]: [Target; 2], speed_m_s: f32) {
    sweep(runs, name.to_owned(), [from, to], speed_m_s);
    sweep(runs, format!("{name}_back"), [to, from], speed_m_s);
}

fn sweep(runs: &mut Vec<Run>, name: String, [from, to]: [Target; 2], speed_m_s: f32) {
    let distance_m = (to.x_m - from.x_m)
        .hypot(to.y_m - from.y_m)
        .max(ARM_M * (to.theta_rad - from.theta_rad).abs());
    let seconds = f64::from(EASE * distance_m / speed_m_s + REST_S);
    runs.push(Run {
        name,
        from: Some(from),
        to: Some((to, speed_m_s)),
        seconds,
    });
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

    /// Whatever the angle, the coordination sensor stays within the area's width of its place.
    #[test]
    fn a_map_s_sweeps_keep_the_beacon_over_the_sensor_and_follow_each_other() {
        let centre = Target {
            x_m: 0.022,
            y_m: 0.025,
            theta_rad: 0.0,
        };
        let lever_m = [0.09, 0.005];
        let runs = under_beacon(centre, lever_m);
        let sensor = |at: Target| {
            let [x, y] = turned(lever_m, at.theta_rad);
            [at.x_m + x, at.y_m + y]
        };
        let home = sensor(centre);
        let mut angles = Vec::new();
        for pair in runs.windows(2) {
            let (to, _) = pair[0].to.unwrap();
            assert_eq!(pair[1].from, Some(to));
            let off = [0, 1].map(|axis| (sensor(to)[axis] - home[axis]).abs());
            assert!(off.iter().all(|off| *off < 1.001 * MAP_REACH_M), "{off:?}");
            angles.push(to.theta_rad);
        }
        let [least, most] = [f32::min as fn(f32, f32) -> f32, f32::max]
            .map(|pick| angles.iter().copied().reduce(pick).unwrap());
        assert!(
            least < -0.9 * MAP_TURN_RAD && most > 0.9 * MAP_TURN_RAD,
            "{least} {most}"
        );
        let total: f64 = runs.iter().map(|run| run.seconds).sum();
        assert!((20.0..60.0).contains(&total), "{total}");
    }
}
