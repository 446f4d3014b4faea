//! A segment that is read late by a good part of a sampling interval.

use diagnosis::{Options, Verdict, diagnose};
use effects::motion::Pose;
use effects::plant::Geometry;
use effects::velocity_lag::VelocityLag;
use hal_sim::coordination::origin_under;
use hal_sim::courier::Courier;
use hal_sim::presets::ideal;
use hal_sim::trajectory::{OpenLoop, Plan};

/// Sampling intervals of the plan that make one of the recording.
const DECIMATION: usize = 4;
/// How late the segment is read, s.
const LATE_S: f64 = 2.0e-3;
/// Which one.
const SEGMENT: usize = 2;

/// Fly-bys at three speeds, turned ways and a spin, as a survey has them.
fn plan() -> Plan {
    let mut plan = Plan::new(Pose::default(), Geometry::PAPER, OpenLoop::COURIER, 3);
    let both = |half: Pose| [half.plus(half, -2.0), half];
    for speed_m_s in [0.01, 0.05, 0.1] {
        for (name, half) in [
            ("x", Pose::new(0.02, 0.0, 0.0)),
            ("y", Pose::new(0.0, 0.02, 0.0)),
        ] {
            plan = plan.sweep_both_ways(name, both(half), speed_m_s);
        }
    }
    for angle_rad in [0.01, -0.01] {
        let turned =
            both(Pose::new(0.02, 0.012, 0.0)).map(|p| p.plus(Pose::new(0.0, 0.0, angle_rad), 1.0));
        plan = plan.sweep_both_ways("turned", turned, 0.02);
    }
    plan = plan.spin(origin_under(&Geometry::PAPER, Pose::default()), 0.01);
    for run in &mut plan.runs {
        run.times_s = run.times_s.iter().copied().step_by(DECIMATION).collect();
    }
    plan
}

#[test]
fn a_segment_that_is_read_late_is_named_with_its_delay() {
    let mut delay_s = [0.0; 4];
    delay_s[SEGMENT] = LATE_S;
    let mut spec = ideal(3);
    spec.beacon_over = Some(Pose::default());
    spec.effects.push(Box::new(VelocityLag {
        delay_s,
        saturation: 0.0,
        saturation_m_s: 1.0,
    }));
    let mut courier = Courier::new(spec, 3).expect("an inverse");
    let recording = hal_sim::record::record(&mut courier, &plan(), false);
    let answer = diagnose(&recording, "late", &Options::default());
    let names: Vec<&str> = answer.effects.iter().map(|e| e.name.as_str()).collect();
    assert_eq!(answer.verdict, Verdict::Named, "{names:?}");
    assert_eq!(names, ["velocity_lag"]);
    let delay = format!("delay, segment {}", SEGMENT + 1);
    let told = answer.effects[0].magnitude.iter().find(|m| m.name == delay);
    let told_s = told.expect("the delay").value;
    // A fiftieth of it: less than the segment goes in a sample's noise at the middle speed.
    assert!((told_s / LATE_S - 1.0).abs() < 0.02, "{told_s}");
}
