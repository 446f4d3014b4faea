//! One sweep of one segment against a reference: what it shows is told, and nothing else.

use diagnosis::{Diagnosis, Options, Verdict, diagnose};
use effects::axis_skew::AxisSkew;
use effects::extra_harmonics::ExtraHarmonics;
use effects::motion::Pose;
use effects::plant::{Geometry, PlantEffect, Scene};
use effects::random::{ChaCha8Rng, SeedableRng};
use hal_sim::courier::Courier;
use hal_sim::presets::ideal;
use hal_sim::trajectory::{OpenLoop, Plan};
use recording::Recording;

/// One sample of the plan in so many: some 400 rows.
const DECIMATION: usize = 2;

/// How a courier of which segments and reference are recorded in part goes along y.
#[derive(Clone, Copy)]
struct Sweep {
    seed: u64,
    bench: OpenLoop,
    /// It turns by this over the way, rad.
    turn_rad: f64,
    /// Segments that were logged: the first of them and, where two, its pair's other one.
    segments: &'static [usize],
    angle_logged: bool,
    commands_logged: bool,
}

/// On a bench that does not turn; segment 2 and the reference's y.
const STRAIGHT: Sweep = Sweep {
    seed: 0,
    bench: OpenLoop::EXACT,
    turn_rad: 0.0,
    segments: &[1],
    angle_logged: false,
    commands_logged: true,
};

impl Sweep {
    /// A sweep of 40 mm.
    fn recorded(self, effect: Option<Box<dyn PlantEffect>>) -> Recording {
        let half = Pose::new(0.0, 0.02, 0.5 * self.turn_rad);
        let plan = Plan::new(Pose::default(), Geometry::PAPER, self.bench, self.seed);
        let mut plan = plan.sweep("sweep", [half.plus(half, -2.0), half], 0.05);
        for run in &mut plan.runs {
            run.times_s = run.times_s.iter().copied().step_by(DECIMATION).collect();
        }
        let mut spec = ideal(self.seed);
        spec.effects.extend(effect);
        let mut courier = Courier::new(spec, self.seed).expect("an inverse");
        let whole = hal_sim::record::record(&mut courier, &plan, true);
        whole.with_rows(|_, row| {
            for segment in (0..4).filter(|s| !self.segments.contains(s)) {
                row.quadrature_counts[segment] = None;
                row.teeth[segment] = None;
            }
            row.electrode_counts = None;
            let theta = row.reference[2].filter(|_| self.angle_logged);
            row.reference = [None, row.reference[1], theta];
            if !self.commands_logged {
                row.commanded = [None; 3];
            }
            true
        })
    }
}

fn answer(recording: &Recording) -> Diagnosis {
    diagnose(recording, "sweep", &Options::default())
}

/// That nothing is found.
fn assert_no_gap(sweep: Sweep) {
    let answer = answer(&sweep.recorded(None));
    assert_eq!(
        (answer.verdict, answer.effects),
        (Verdict::NoGap, vec![]),
        "{}",
        sweep.seed
    );
}

#[test]
fn without_an_effect_one_sweep_has_no_gap() {
    for seed in 0..20 {
        assert_no_gap(Sweep { seed, ..STRAIGHT });
    }
}

/// A courier that turns a little on its way moves its segment, half a span from where the reference measures: no error of the sensor.
#[test]
fn a_courier_that_turns_beside_a_reference_without_an_angle_has_no_gap() {
    for seed in 0..10 {
        let bench = OpenLoop::COURIER;
        let sweep = Sweep {
            seed,
            bench,
            commands_logged: seed % 2 == 0,
            ..STRAIGHT
        };
        assert_no_gap(sweep);
        let turn_rad = [-0.01, 0.004][seed as usize % 2];
        assert_no_gap(Sweep { turn_rad, ..sweep });
    }
}

/// A ruling of another pitch, m rms over 5 mm: 20 µm over the sweep.
fn skewed() -> Option<Box<dyn PlantEffect>> {
    Some(Box::new(AxisSkew {
        skew_rad: 0.0,
        pitch_difference: 5.0e-4,
        bow_per_m: 0.0,
    }))
}

fn names(answer: &Diagnosis) -> Vec<&str> {
    answer.effects.iter().map(|e| e.name.as_str()).collect()
}

/// Where the angle is known, another pitch is no turning, and is named; where it is not, nothing tells the two apart.
#[test]
fn a_ruling_of_another_pitch_is_named_where_the_angle_is_known() {
    for seed in 0..4 {
        let known = Sweep {
            seed,
            bench: OpenLoop::COURIER,
            angle_logged: true,
            ..STRAIGHT
        };
        let told = answer(&known.recorded(skewed()));
        assert_eq!(
            (told.verdict, names(&told)),
            (Verdict::Named, vec!["axis_skew"]),
            "{seed} {:?}",
            told.effects
        );
        let unknown = Sweep {
            angle_logged: false,
            ..known
        };
        let told = answer(&unknown.recorded(skewed()));
        assert_eq!(names(&told), [""; 0], "{seed}");
        // A sensor that cannot turn has no span.
        let mut linear = Sweep { seed, ..STRAIGHT }.recorded(skewed());
        linear.meta.geometry.span_m = None;
        let told = answer(&linear);
        assert_eq!(names(&told), ["axis_skew"], "{seed}");
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
    let answer = answer(
        &Sweep {
            seed: 3,
            ..STRAIGHT
        }
        .recorded(Some(harmonics)),
    );
    assert_eq!(
        (answer.verdict, names(&answer)),
        (Verdict::Named, vec!["extra_harmonics"])
    );
}
