//! A segment whose readings come milliseconds late.

use diagnosis::{Options, check, diagnose_fully};
use effects::motion::Pose;
use effects::plant::Geometry;
use effects::velocity_lag::VelocityLag;
use hal_sim::courier::Courier;
use hal_sim::presets::ideal;
use hal_sim::trajectory::{OpenLoop, Plan};
use recording::Recording;

/// Sweeps along x and y at three speeds, turned to either side, every second millisecond.
fn recording(delay_s: [f64; 4], noise_seed: u64) -> Recording {
    let mut plan = Plan::new(
        Pose::default(),
        Geometry::PAPER,
        OpenLoop::COURIER,
        noise_seed,
    );
    for (number, speed_m_s) in [0.01, 0.05, 0.2].into_iter().enumerate() {
        let half_m = [0.004, 0.008, 0.016][number];
        for (side, turn_rad) in [("left", 0.004), ("right", -0.004)] {
            for (axis, x_m, y_m) in [("x", half_m, 0.0), ("y", 0.0, half_m)] {
                let ends = [
                    Pose::new(-x_m, -y_m, turn_rad),
                    Pose::new(x_m, y_m, turn_rad),
                ];
                plan = plan.sweep_both_ways(&format!("{axis}_{side}_{number}"), ends, speed_m_s);
            }
        }
    }
    let mut spec = ideal(11);
    spec.effects.push(Box::new(VelocityLag {
        delay_s,
        saturation: 0.0,
        saturation_m_s: 1.0,
    }));
    let mut courier = Courier::new(spec, noise_seed).unwrap();
    let whole = hal_sim::record::record(&mut courier, &plan, false);
    whole.with_rows(|k, _| k % 2 == 0)
}

/// Four millimetres of way lie between what the segments say, where the courier is fast. On another recording the delay is the same.
#[test]
fn a_segment_that_comes_20_ms_late_is_named_with_its_delay_and_claimed() {
    let answer = diagnose_fully(
        &recording([0.0, 0.0, 0.02, 0.0], 11),
        "late",
        &Options::default(),
    );
    let effects = &answer.diagnosis.effects;
    assert_eq!(effects.len(), 1, "{effects:?}");
    assert_eq!(effects[0].name, "velocity_lag");
    let amount = |segment: usize| {
        let name = format!("delay, segment {segment}");
        let found = effects[0].magnitude.iter().find(|m| m.name == name);
        found.map_or(0.0, |m| m.value)
    };
    // No motion tells what all segments are late by, and little what both of a pair are.
    assert!(
        (amount(3) - amount(1) - 0.02).abs() < 50.0e-6,
        "{effects:?}"
    );
    let model = answer.model.expect("a model");
    let came = check(&model, &recording([0.0, 0.0, 0.02, 0.0], 12)).unwrap();
    let ratio = came.whitened_after / model.claimed.whitened_after;
    assert!((ratio - 1.0).abs() < 0.1, "{came:?}, {:?}", model.claimed);
    assert!(came.whitened_before > 100.0, "{came:?}");
}
