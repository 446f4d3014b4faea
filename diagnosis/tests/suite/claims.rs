//! What is claimed of another recording, beside what another recording shows.

use specimens::rig;

use diagnosis::verdict::answer::HeldOut;
use diagnosis::{Model, Options, check, check_fully, diagnose_fully};
use recording::{Recording, Samples};
use specimens::{Case, Conditions, Drawn, Kind};
use std::f64::consts::TAU;

fn recordings(seed: u64, effects: &[(&str, f64)], beacon: bool) -> [Recording; 2] {
    let options = rig::Options {
        samples: 6000,
        beacon,
        ..rig::Options::default()
    };
    [seed, seed + 1000].map(|motion| rig::record_as(seed, motion, effects, &options).0)
}

fn model(recording: &Recording, name: &str) -> Model {
    let answer = diagnose_fully(recording, "first", &Options::default());
    let model = answer.model.expect("a model");
    let found: Vec<&str> = model.effects.iter().map(|e| e.name.as_str()).collect();
    assert_eq!(found, [name]);
    model
}

/// A vibration swells otherwise on another day: what is claimed is what is left where only its mean is known.
#[test]
fn how_a_vibration_swells_is_not_foretold() {
    let [first, second] = recordings(31, &[], true);
    let swell = |periods: f64, phase: f64| {
        move |progress: f64| 6.0e-4 * (1.0 + 0.4 * (TAU * periods * progress + phase).sin())
    };
    let first = rig::shake::shaken(&first, 0.21, swell(3.0, 0.5));
    let second = rig::shake::shaken(&second, 0.21, swell(4.3, 2.0));
    let model = model(&first, "beacon_vibration");
    let here = check(&model, &second).expect("residuals");
    let after = |held: &HeldOut| held.channels[1].after_rms_m;
    let (claimed, came) = (after(&model.claimed), after(&here));
    assert!((came / claimed - 1.0).abs() < 0.1, "{claimed} {came}");
    assert!(claimed > 1.5 * here.channels[1].floor_rms_m, "{claimed}");
}

/// A drive that is modulated evenly is modulated alike on another day: over tens of beats it is told from a mount that swells by chance.
#[test]
fn how_a_vibration_beats_is_foretold() {
    const BEAT_HZ: f64 = 2.0;
    let recordings = recordings(31, &[], true).map(|recording| {
        let times: Vec<f64> = (0..recording.samples.len())
            .map(|i| recording.samples.row(i).t_s)
            .collect();
        let span_s = times[times.len() - 1] - times[0];
        let size =
            move |progress: f64| 6.0e-4 * (1.0 + 0.4 * (TAU * BEAT_HZ * span_s * progress).sin());
        rig::shake::shaken(&recording, 0.21, size)
    });
    let model = model(&recordings[0], "beacon_vibration");
    let here = check(&model, &recordings[1]).expect("residuals");
    let (claimed, came) = (&model.claimed.channels[1], &here.channels[1]);
    let ratio = came.after_rms_m / claimed.after_rms_m;
    assert!((ratio - 1.0).abs() < 0.1, "{ratio}");
    let excess = |rms_m: f64| rms_m.powi(2) - claimed.floor_rms_m.powi(2);
    let left = excess(claimed.after_rms_m) / excess(claimed.before_rms_m);
    assert!(left < 0.01, "{left}");
    // Nothing but the evenness of the beat speaks for its being there again.
    assert!(claimed.after_ci95_m[1] > 1.5 * claimed.floor_rms_m);
}

/// What drives a mount keeps no time from run to run: on another recording each may begin anywhere in its period.
#[test]
fn a_vibration_keeps_no_phase_from_run_to_run() {
    let [first, second] = recordings(31, &[], true);
    let [first, second] = [first, second].map(|r| rig::shake::shaken(&r, 0.21, |_| 6.0e-4));
    let mut waited = second.clone();
    waited.samples = Samples::default();
    let (mut run, mut wait_s) = (None, 0.0);
    for index in 0..second.samples.len() {
        let mut row = second.samples.row(index);
        if run.is_some_and(|run| run != row.run) {
            wait_s += 0.0137;
        }
        run = Some(row.run);
        row.t_s += wait_s;
        waited.samples.push(&row);
    }
    let model = model(&first, "beacon_vibration");
    let [before, here] = [&second, &waited].map(|r| check(&model, r).expect("residuals"));
    let ratio = here.whitened_after / before.whitened_after;
    assert!((ratio - 1.0).abs() < 0.02, "{ratio}");
    assert!(here.whitened_after < 1.05, "{}", here.whitened_after);
}

/// The same recording after a restart of the board: its tooth counts begin elsewhere.
fn restarted(recording: &Recording, teeth: [i32; 4]) -> Recording {
    let mut out = recording.clone();
    out.samples = Samples::default();
    for index in 0..recording.samples.len() {
        let mut row = recording.samples.row(index);
        for (segment, n) in row.teeth.iter_mut().enumerate() {
            *n = n.map(|n| n + teeth[segment]);
        }
        out.samples.push(&row);
    }
    out
}

/// A platen that grows moves what is far from the counts' zero by much, and where that zero is says nothing.
#[test]
fn where_the_tooth_counts_begin_is_nothing_to_a_check() {
    let [first, second] = recordings(31, &[("thermal_drift", 2.0e-6)], true);
    let model = model(&first, "thermal_drift");
    let here = check(&model, &second).expect("residuals");
    let there = check(&model, &restarted(&second, [70, -50, 70, -50])).expect("residuals");
    for (a, b) in here.channels.iter().zip(&there.channels) {
        let ratio = b.after_rms_m / a.after_rms_m;
        assert!((ratio - 1.0).abs() < 0.01, "{}: {ratio}", a.channel);
    }
    let colder = |model: &Model, recording| {
        check_fully(model, recording).map(|c| c.warmer_or_colder.is_some())
    };
    assert_eq!(colder(&model, &first), Ok(false));
    let mut elsewhere = model;
    elsewhere.normal.temperatures_c = elsewhere.normal.temperatures_c.map(|t| t.map(|t| t + 5.0));
    assert_eq!(colder(&elsewhere, &first), Ok(true));
}

/// A drift that is bent itself, and no body that follows late: the bend is there at other temperatures as well.
#[test]
fn a_drift_that_bends_is_carried_to_other_temperatures() {
    a_bent_drift(44, -5.0);
}

fn a_bent_drift(seed: u64, warmer_k: f64) {
    let recorded = |motion, warmer_k| {
        let options = rig::Options {
            samples: 6000,
            warmer_k,
            ..rig::Options::default()
        };
        rig::record_as(seed, motion, &[("bent_warmth", 3.0e-6)], &options).0
    };
    let model = model(&recorded(seed, 0.0), "thermal_drift");
    assert!(model.inputs.bend_goes_on, "{seed}");
    let came = check(&model, &recorded(seed + 1000, warmer_k)).expect("residuals");
    let mut held_at_the_ends = model.clone();
    held_at_the_ends.inputs.bend_goes_on = false;
    let held = check(&held_at_the_ends, &recorded(seed + 1000, warmer_k)).expect("residuals");
    // As asked: within 10 %.
    let ratio = came.whitened_after / model.claimed.whitened_after;
    assert!((ratio - 1.0).abs() < 0.1, "{seed}: {ratio}");
    let without = held.whitened_after / model.claimed.whitened_after;
    assert!(without > 1.2, "{seed}: {without}");
}

/// Mounts that the board warms through, and another recording on a colder and a warmer day: what lies behind the board must not pass for a
/// bend of the drift, which would be carried on to where nothing was measured.
#[test]
fn a_drift_that_lags_is_carried_to_other_temperatures() {
    a_late_drift(41, -6.0);
}

fn a_late_drift(seed: u64, warmer_k: f64) {
    let recorded = |motion, warmer_k| {
        let options = rig::Options {
            samples: 6000,
            warmer_k,
            ..rig::Options::default()
        };
        rig::record_as(seed, motion, &[("late_warmth", 3.0e-6)], &options).0
    };
    let model = model(&recorded(seed, 0.0), "thermal_drift");
    let came = check_fully(&model, &recorded(seed + 1000, warmer_k)).expect("residuals");
    assert!(came.warmer_or_colder.is_some());
    // As asked: within 10 %.
    for (claimed, c) in model.claimed.channels.iter().zip(&came.held_out.channels) {
        let ratio = c.after_rms_m / claimed.after_rms_m;
        assert!((ratio - 1.0).abs() < 0.1, "{seed} {}: {ratio}", c.channel);
    }
}

/// What holds the coils follows the board within seconds, the courier itself within a minute or more.
#[test]
fn a_courier_that_warms_through_slowly_is_followed() {
    a_slow_drift(43);
}

fn a_slow_drift(seed: u64) {
    let options = rig::Options {
        mount_s: 60.0,
        ..rig::Options::default()
    };
    let recorded = |motion| rig::record_as(seed, motion, &[("late_warmth", 3.0e-6)], &options).0;
    let model = model(&recorded(seed), "thermal_drift");
    let claimed = model.claimed.whitened_after;
    assert!(claimed < 1.05, "{seed}: {claimed}");
    let came = check(&model, &recorded(seed + 1000)).expect("residuals");
    let excess = |rms: f64| rms.powi(2) - 1.0;
    let left = excess(came.whitened_after) / excess(came.whitened_before);
    assert!(left < 0.1, "{seed}: {left}");
}

#[test]
#[ignore = "nightly: half a minute"]
fn drifts_of_further_couriers_are_carried_over_as_well() {
    a_bent_drift(45, 5.0);
    a_bent_drift(46, 5.0);
    a_late_drift(42, 6.0);
    a_slow_drift(44);
}

/// A coil of some width loses amplitude as a sinc does, which is no parabola of the angle beyond a degree.
#[test]
fn a_wide_coil_is_followed_to_the_largest_angles() {
    let options = rig::Options {
        samples: 6000,
        ..rig::Options::default()
    };
    let [first, second] =
        [43, 1043].map(|motion| rig::record_as(43, motion, &[("wide_coil", 2.5e-6)], &options).0);
    let model = model(&first, "angle_dependence");
    // As asked: within 10 % of the best possible, which is the floor, and another recording within 10 % of that.
    let claimed = model.claimed.whitened_after;
    assert!(claimed < 1.1, "{claimed}");
    let came = check(&model, &second).expect("residuals");
    let ratio = came.whitened_after / claimed;
    assert!((ratio - 1.0).abs() < 0.1, "{ratio}");
}

/// One segment that counts a tooth more than its partner, as after a slip, turns no courier and moves no lateral phase.
#[test]
fn a_tooth_between_the_segments_of_a_pair_is_nothing_to_a_check() {
    for commanded in [true, false] {
        let options = rig::Options {
            samples: 6000,
            beacon: true,
            commanded,
            ..rig::Options::default()
        };
        let effects = [("lateral_dependence", 3.0e-6)];
        let [first, second] =
            [35, 1035].map(|motion| rig::record_as(35, motion, &effects, &options).0);
        let model = model(&first, "lateral_dependence");
        let here = check(&model, &second).expect("residuals");
        for teeth in [[1, 0, 0, 0], [0, 0, 0, -2]] {
            let there = check(&model, &restarted(&second, teeth)).expect("residuals");
            for (a, b) in here.channels.iter().zip(&there.channels) {
                let ratio = b.after_rms_m / a.after_rms_m;
                assert!(
                    (ratio - 1.0).abs() < 0.01,
                    "{teeth:?} {}: {ratio}",
                    a.channel
                );
            }
        }
    }
}

/// What was fitted and what is written down are one model.
#[test]
fn a_model_leaves_on_its_own_recording_what_was_claimed() {
    for (name, beacon) in [("angle_dependence", false), ("thermal_drift", true)] {
        let [first, _] = recordings(33, &[(name, 3.0e-6)], beacon);
        let model = model(&first, name);
        let again = check(&model, &first).expect("residuals");
        for (claimed, c) in model.claimed.channels.iter().zip(&again.channels) {
            let ratio = c.after_rms_m / claimed.after_rms_m;
            assert!((ratio - 1.0).abs() < 0.05, "{name} {}: {ratio}", c.channel);
        }
    }
}

fn remanent() -> Case {
    let effects = vec![Drawn {
        name: "hysteresis".into(),
        size_m: 1.5e-6,
    }];
    Case {
        number: 0,
        seed: 1,
        kind: Kind::Single,
        effects,
        conditions: Conditions::Usual,
    }
}

/// Remanence of a few micrometres on an open-loop courier: fly-bys and small steps creep across by as much as it takes to turn it over, and
/// the readings hide ways of its own size.
#[test]
fn what_a_segment_remembers_of_its_way_is_claimed_and_comes() {
    let case = remanent();
    let model = model(&case.recorded(0), "hysteresis");
    let came = check(&model, &case.recorded(1)).expect("residuals");
    // As asked: within 10 % of the best possible, which is the floor, and another recording within 10 % of that.
    let claimed = model.claimed.whitened_after;
    assert!(claimed < 1.1, "{claimed}");
    let ratio = came.whitened_after / claimed;
    assert!((ratio - 1.0).abs() < 0.1, "{ratio}");
}

/// A recording that begins with fly-bys: the segments across them bring along what they were moved before, and keep it. On another day
/// it is another memory.
#[test]
fn what_a_segment_brought_along_is_not_carried_over() {
    let late = [0, 1].map(|motion| {
        let recording = remanent().recorded(motion);
        let runs: Vec<usize> = (0..recording.samples.len())
            .filter(|&i| !recording.samples.row(i).run.starts_with("scatter"))
            .collect();
        let mut samples = Samples::default();
        for i in runs {
            samples.push(&recording.samples.row(i));
        }
        Recording {
            samples,
            ..recording
        }
    });
    let model = model(&late[0], "hysteresis");
    let came = check(&model, &late[1]).expect("residuals");
    let claimed = model.claimed.whitened_after;
    let ratio = came.whitened_after / claimed;
    assert!(claimed < 1.05, "{claimed}");
    assert!((ratio - 1.0).abs() < 0.05, "{ratio}");
}

/// Between two fly-bys the segments across them go some micrometres that nothing records, and keep what that left for the whole of the next.
#[test]
#[ignore = "nightly: half a minute"]
fn what_a_segment_brought_along_to_each_fly_by_is_its_own() {
    let effects = vec![Drawn {
        name: "hysteresis".into(),
        size_m: 3.914e-6,
    }];
    let case = Case {
        number: 72,
        seed: 473_747_393_215_269,
        kind: Kind::Single,
        effects,
        conditions: Conditions::Usual,
    };
    let model = model(&case.recorded(0), "hysteresis");
    let came = check(&model, &case.recorded(1)).expect("residuals");
    let ratio = came.whitened_after / model.claimed.whitened_after;
    assert!((ratio - 1.0).abs() < 0.1, "{ratio}");
}

/// Bursts of a few micrometres beside harmonics that reach thirty at the largest angles: of what the baseline alone leaves they do not
/// stand out.
#[test]
fn bursts_beside_a_great_gap_are_told_from_it_in_a_check() {
    let effects = [
        ("angle_dependence", 1.4042e-6),
        ("outlier_bursts", 1.363e-6),
    ];
    let effects = effects.map(|(name, size_m)| Drawn {
        name: name.into(),
        size_m,
    });
    let case = Case {
        number: 26,
        seed: 95_744_297_432_415,
        kind: Kind::Pair,
        effects: effects.to_vec(),
        conditions: Conditions::Usual,
    };
    let answer = diagnose_fully(&case.recorded(0), "first", &Options::default());
    let model = answer.model.expect("a model");
    let came = check(&model, &case.recorded(1)).expect("residuals");
    let ratio = came.whitened_after / model.claimed.whitened_after;
    assert!((ratio - 1.0).abs() < 0.1, "{ratio}");
}

/// Teeth that four segments read in common, each of them an unknown: of the gap little more is left than the noise, and so it is on
/// another day's paths.
#[test]
#[ignore = "nightly: half a minute to two"]
fn a_field_is_known_tooth_by_tooth() {
    for (seed, size_m) in [(45, 0.7e-6), (46, 1.0e-6)] {
        let [first, second] = recordings(seed, &[("tooth_variation", size_m)], true);
        let model = model(&first, "tooth_variation");
        assert!(model.inputs.teeth.is_some());
        let gap = |whitened: f64| whitened * whitened - 1.0;
        let claimed = model.claimed.whitened_after;
        // A mesh over the centre leaves a sixteenth.
        let left = gap(claimed) / gap(model.claimed.whitened_before);
        assert!(left < 0.015, "{seed}: {left}");
        let came = check_fully(&model, &second).expect("residuals");
        let ratio = came.held_out.whitened_after / claimed;
        assert!((ratio - 1.0).abs() < 0.1, "{seed}: {ratio}");
        // A check that looks at little confirms little.
        let (unknown, samples) = (came.unknown, came.samples);
        assert!(4 * unknown < samples, "{seed}: {unknown} of {samples}");
    }
}
