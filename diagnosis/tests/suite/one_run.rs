//! One sweep of one segment against a reference: what it shows is told, and nothing else.

use diagnosis::{Diagnosis, Options, Verdict, diagnose};
use effects::extra_harmonics::ExtraHarmonics;
use effects::motion::Pose;
use effects::plant::{Geometry, PlantEffect, Scene};
use effects::random::{ChaCha8Rng, SeedableRng};
use hal_sim::courier::Courier;
use hal_sim::presets::ideal;
use hal_sim::trajectory::{OpenLoop, Plan};
use recording::{Recording, Samples};

/// One sample of the plan in so many: some 400 rows.
const DECIMATION: usize = 2;

/// A sweep of 40 mm along x on a bench that does not turn, of which segment 1 and the reference were logged.
fn sweep(seed: u64, effect: Option<Box<dyn PlantEffect>>) -> Recording {
    let half = Pose::new(0.02, 0.0, 0.0);
    let plan = Plan::new(Pose::default(), Geometry::PAPER, OpenLoop::EXACT, seed);
    let mut plan = plan.sweep("sweep", [half.plus(half, -2.0), half], 0.05);
    for run in &mut plan.runs {
        run.times_s = run.times_s.iter().copied().step_by(DECIMATION).collect();
    }
    let mut spec = ideal(seed);
    spec.effects.extend(effect);
    let mut courier = Courier::new(spec, seed).expect("an inverse");
    let mut recording = hal_sim::record::record(&mut courier, &plan, true);
    let whole = std::mem::take(&mut recording.samples);
    let mut samples = Samples::default();
    for index in 0..whole.len() {
        let mut row = whole.row(index);
        for segment in 1..4 {
            row.quadrature_counts[segment] = None;
            row.teeth[segment] = None;
        }
        row.electrode_counts = None;
        row.reference = [row.reference[0], None, None];
        samples.push(&row);
    }
    Recording {
        samples,
        ..recording
    }
}

fn answer(recording: &Recording) -> Diagnosis {
    diagnose(recording, "sweep", &Options::default())
}

#[test]
fn without_an_effect_one_sweep_has_no_gap() {
    for seed in 0..20 {
        let answer = answer(&sweep(seed, None));
        assert_eq!(
            (answer.verdict, answer.effects),
            (Verdict::NoGap, vec![]),
            "{seed}"
        );
    }
}

#[test]
fn harmonics_that_one_sweep_passes_many_times_are_named() {
    let scene = Scene {
        geometry: Geometry::PAPER,
        duration_s: 1.0,
        amplitude_counts: 20_000.0,
    };
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let harmonics = ExtraHarmonics::draw(&scene, &mut rng, 3.0e-6);
    let answer = answer(&sweep(3, Some(harmonics)));
    let names: Vec<&str> = answer.effects.iter().map(|e| e.name.as_str()).collect();
    assert_eq!(
        (answer.verdict, names),
        (Verdict::Named, vec!["extra_harmonics"])
    );
}
