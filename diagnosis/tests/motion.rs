//! What is told of a sample's motion must not hold that sample's own noise.
mod rig;

use diagnosis::motion::Motion;
use diagnosis::observe::Observations;

/// A column made of a sample's own noise would rebuild the residual held out as well: a false alarm "speed".
#[test]
fn speed_and_acceleration_are_the_neighbours() {
    let options = rig::Options {
        samples: 4000,
        ..rig::Options::default()
    };
    let mut clean = Observations::new(&rig::record(43, &[], &options).0).unwrap();
    // Segment 1 gathers speed, 5 m/s² throughout, with 0.1 µm of noise.
    let mut dice = rig::Dice(5);
    let mut start_s = 0.0;
    for i in 0..clean.len() {
        if i == 0 || clean.stretch[i] != clean.stretch[i - 1] {
            start_s = clean.t_s[i];
        }
        clean.position_m[0][i] = 2.5 * (clean.t_s[i] - start_s).powi(2) + 0.1e-6 * dice.normal();
    }
    let motion = Motion::new(&clean, &clean.position_m);
    let moving: Vec<usize> = (0..clean.len())
        .filter(|&i| motion.acceleration_m_s2[0][i] != 0.0 && motion.speed_m_s[0][i] != 0.0)
        .step_by(7)
        .collect();
    assert!(moving.len() > 50);
    let mut compared = 0;
    for i in moving {
        let mut other = clean.clone();
        other.position_m[0][i] += 0.3e-6;
        let moved = Motion::new(&other, &other.position_m);
        let (before, after) = (&motion.acceleration_m_s2[0], &moved.acceleration_m_s2[0]);
        assert!((motion.speed_m_s[0][i] - moved.speed_m_s[0][i]).abs() < 1.0e-9);
        // A larger misfit may call the same curvature noise, and it is then zero.
        if after[i] != 0.0 {
            assert!((before[i] - after[i]).abs() < 1.0e-6 * before[i].abs());
            compared += 1;
        }
        if compared > 20 {
            break;
        }
    }
    assert!(compared > 10);
}
