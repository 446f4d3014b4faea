//! Surveys that were cut short: too little motion for some answers, and no reason to name what is not there.
//!
//! The courier is `ideal`: equation (3) and noise. Its survey is that of `courier record --survey`, of which a part is kept: the
//! first rows, a piece from the middle, some of its runs, straight flights alone, one long sweep, rests. A courier may be given one
//! effect, to see that what a cut still shows is still found.

use courier::survey::runs;
use courier_sensor::drivers::motion::Target;
use effects::CATALOGUE;
use effects::motion::Pose;
use effects::plant::{Geometry, Scene};
use effects::random::{ChaCha8Rng, SeedableRng, index, log_uniform, uniform};
use hal_sim::courier::Courier;
use hal_sim::presets::ideal;
use hal_sim::trajectory::{OpenLoop, Plan};
use recording::{Recording, Samples};

/// Sizes of effects, rms m over the whole survey: those of the blind check.
const SIZES_M: [f64; 2] = [0.7e-6, 4.0e-6];
/// One sample in so many, as a survey is recorded, or more of them.
const DECIMATIONS: [usize; 4] = [2, 5, 10, 20];
/// Most rows that are kept: a diagnosis of more takes longer and tells no more about cuts.
const MOST_ROWS: usize = 8000;
/// Least.
const LEAST_ROWS: usize = 250;
/// The noise that a recording states is measured: to some percent.
const STATED: [f64; 2] = [0.97, 1.08];

/// What is left of a survey.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// From its beginning to anywhere.
    Beginning,
    /// From anywhere to anywhere.
    Piece,
    /// Some of its runs.
    SomeRuns,
    /// Runs along x and y that do not turn.
    StraightFlights,
    /// One run that is long.
    OneSweep,
    /// Where the courier stands still.
    Rests,
}

/// All kinds.
pub const KINDS: [Kind; 6] = [
    Kind::Beginning,
    Kind::Piece,
    Kind::SomeRuns,
    Kind::StraightFlights,
    Kind::OneSweep,
    Kind::Rests,
];

/// A cut survey and what is in it.
pub struct Cut {
    /// What is left.
    pub kind: Kind,
    /// Name and size, rms m, of the effect, if there is one.
    pub effect: Option<(&'static str, f64)>,
    /// The rest of the survey.
    pub recording: Recording,
}

/// The cut of a number: the same one on every machine, with an effect or without any.
///
/// # Panics
/// Never: the preset's waveforms have an inverse.
#[must_use]
pub fn draw(number: u64, with_effect: bool) -> Cut {
    let mut rng = ChaCha8Rng::seed_from_u64(number);
    let kind = KINDS[index(&mut rng, KINDS.len())];
    let decimation = DECIMATIONS[index(&mut rng, DECIMATIONS.len())];
    let plan = survey(number, &mut rng);
    let mut spec = ideal(number);
    spec.beacon_over = (index(&mut rng, 4) > 0).then(|| Pose::new(0.0, 0.0, 0.0));
    let mut effect = None;
    if with_effect {
        let entry = &CATALOGUE[index(&mut rng, CATALOGUE.len())];
        let size_m = log_uniform(&mut rng, SIZES_M[0], SIZES_M[1]);
        let scene = Scene {
            geometry: spec.geometry,
            duration_s: plan.duration_s(),
            amplitude_counts: spec.electronics.amplitude_counts,
        };
        spec.effects.push((entry.draw)(&scene, &mut rng, size_m));
        effect = Some((entry.name, size_m));
    }
    let mut courier = Courier::new(spec, number).unwrap_or_else(|error| panic!("{error}"));
    // As a board does: teeth are counted at every sample, and some of these are sent.
    let whole = hal_sim::record::record(&mut courier, &plan, false);
    let whole = whole.with_rows(|sample, _| sample % decimation == 0);
    let mut recording = kept(&whole, kind, &mut rng);
    let electronics = &mut recording.meta.electronics;
    for noise in [
        &mut electronics.quadrature_noise_counts,
        &mut electronics.psd_noise_counts,
    ] {
        let stated = uniform(&mut rng, STATED[0], STATED[1]);
        *noise = noise.map(|counts| stated * counts);
    }
    Cut {
        kind,
        effect,
        recording,
    }
}

/// The motions of `courier record --survey`.
fn survey(seed: u64, rng: &mut ChaCha8Rng) -> Plan {
    let centre = Target {
        x_m: uniform(rng, -2.0e-3, 2.0e-3) as f32,
        y_m: uniform(rng, -2.0e-3, 2.0e-3) as f32,
        theta_rad: 0.0,
    };
    let pose = |t: Target| Pose::new(f64::from(t.x_m), f64::from(t.y_m), f64::from(t.theta_rad));
    let mut plan = Plan::new(Pose::default(), Geometry::PAPER, OpenLoop::COURIER, seed);
    for run in runs(centre) {
        let from = pose(run.from.unwrap_or(centre));
        plan = match run.to {
            Some((to, speed_m_s)) => plan.sweep(&run.name, [from, pose(to)], f64::from(speed_m_s)),
            None => plan.still(from, run.seconds),
        };
    }
    plan
}

fn kept(whole: &Recording, kind: Kind, rng: &mut ChaCha8Rng) -> Recording {
    let length = whole.samples.len();
    let rows = (log_uniform(rng, LEAST_ROWS as f64, MOST_ROWS as f64) as usize).min(length);
    let names = whole.samples.run_names();
    let name = |i: usize| whole.samples.run(i);
    let all = 0..length;
    let chosen: Vec<usize> = match kind {
        Kind::Beginning => all.take(rows).collect(),
        Kind::Piece => all.skip(index(rng, length - rows + 1)).take(rows).collect(),
        Kind::SomeRuns => {
            let used: Vec<bool> = names.iter().map(|_| index(rng, 3) == 0).collect();
            all.filter(|&i| used[whole.samples.run_number(i)]).collect()
        }
        Kind::StraightFlights => {
            let axes: &[&str] =
                [&["flyby_x"][..], &["flyby_y"], &["flyby_x", "flyby_y"]][index(rng, 3)];
            all.filter(|&i| axes.iter().any(|axis| name(i).starts_with(axis)))
                .collect()
        }
        Kind::OneSweep => {
            let moving: Vec<&String> = names.iter().filter(|n| *n != "still").collect();
            let one = moving[index(rng, moving.len())];
            all.filter(|&i| name(i) == one).collect()
        }
        Kind::Rests => {
            // The pause at either end of a move, and the rest at the end.
            let edge = |i: usize| {
                let near = |k: usize| whole.samples.run_number(k) != whole.samples.run_number(i);
                (i.saturating_sub(15)..(i + 15).min(length)).any(near)
            };
            all.filter(|&i| name(i) == "still" || edge(i)).collect()
        }
    };
    let mut samples = Samples::default();
    for &i in chosen.iter().take(MOST_ROWS) {
        samples.push(&whole.samples.row(i));
    }
    Recording {
        samples,
        ..whole.clone()
    }
}

/// What a diagnosis makes of a cut.
pub struct Answer {
    /// The effect that is there is among those named, or among those that explain the same.
    pub found: bool,
    /// What is named and is not there, as a line to look at.
    pub wrong: Option<String>,
}

/// Diagnoses it.
#[must_use]
pub fn answer(cut: &Cut) -> Answer {
    let diagnosis = diagnosis::diagnose(&cut.recording, "cut", &diagnosis::Options::default());
    let there = |name: &str| cut.effect.is_some_and(|(effect, _)| name == effect);
    let is_there = |e: &&diagnosis::verdict::answer::Named| {
        there(&e.name) || e.aliases.iter().any(|alias| there(alias))
    };
    let (right, stray): (Vec<_>, Vec<_>) = diagnosis.effects.iter().partition(is_there);
    let told = |e: &&diagnosis::verdict::answer::Named| format!("{} {:.2}", e.name, e.probability);
    let stray: Vec<String> = stray.iter().map(told).collect();
    let wrong = diagnosis.verdict == diagnosis::Verdict::Named && !stray.is_empty();
    Answer {
        found: !right.is_empty(),
        wrong: wrong.then(|| {
            format!(
                "{:?}, {} rows: {}; {:.3} before",
                cut.kind,
                cut.recording.samples.len(),
                stray.join(", "),
                diagnosis.held_out.whitened_before
            )
        }),
    }
}
