//! A segment that gives no signal over a part of its way.

use diagnosis::{Diagnosis, Options, Verdict, diagnose};
use effects::motion::Pose;
use effects::plant::Geometry;
use hal_sim::courier::Courier;
use hal_sim::presets::ideal;
use hal_sim::trajectory::{OpenLoop, Plan};

/// What is left of the amplitude at the end.
const LEFT: f64 = 0.03;
/// Pitches from the middle beyond which it is gone.
const END_PITCHES: i32 = 4;

/// Sweeps of 12 mm along both axes and one that turns; segment 2 loses its amplitude near their end, if it does.
fn answer(lost: bool) -> Diagnosis {
    let mut plan = Plan::new(Pose::default(), Geometry::PAPER, OpenLoop::COURIER, 7);
    for half in [
        Pose::new(6.0e-3, 0.0, 0.0),
        Pose::new(0.0, 6.0e-3, 0.0),
        Pose::new(6.0e-3, 4.0e-3, 0.01),
    ] {
        plan = plan.sweep_both_ways("sweep", [half.plus(half, -2.0), half], 0.05);
    }
    let mut courier = Courier::new(ideal(7), 7).expect("an inverse");
    let whole = hal_sim::record::record(&mut courier, &plan, false);
    let recording = whole.with_rows(|_, row| {
        row.electrode_counts = None;
        if lost && row.teeth[1].is_some_and(|n| n >= END_PITCHES) {
            let fainter = |pair: [f64; 2]| pair.map(|counts| (LEFT * counts).round());
            row.quadrature_counts[1] = row.quadrature_counts[1].map(fainter);
        }
        true
    });
    diagnose(&recording, "sweeps", &Options::default())
}

#[test]
fn is_located_though_all_else_agrees() {
    let whole = answer(false);
    assert_eq!(whole.verdict, Verdict::NoGap, "{:?}", whole.notes);
    let answer = answer(true);
    assert_eq!(answer.verdict, Verdict::Unknown);
    assert_eq!(answer.effects, []);
    let [lost] = answer.without_signal[..] else {
        panic!("{:?}", answer.without_signal);
    };
    assert_eq!(lost.segment, 2);
    assert!(lost.place_m[0] > 3.0e-3, "{lost:?}");
    assert_eq!(answer.place[0].coordinate, "signal amplitude, segment 2");
    assert_eq!(answer.unexplained.place, answer.place);
}
