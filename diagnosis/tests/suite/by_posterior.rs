//! Answers on which the posterior decides, on short recordings of one segment beside a reference.

use crate::beside::direction_beside_noise;
use crate::clip::{AMPLIFIERS, saturated};
use crate::forms::{channel_turns, pairs_that_warm};
use crate::noise::field_beneath_noise;
use crate::rings::{Ring, named, recorded};
use crate::shared::shared;
use crate::whole::gap_with_thirds;
use diagnosis::posterior::form_error::form_error;
use diagnosis::verdict::answer::Verdict;
use diagnosis::{Options, check, diagnose_fully};
use recording::Recording;
use specimens::rig;

/// A short recording of one segment beside a reference.
fn one_segment() -> rig::Options {
    rig::Options {
        samples: 600,
        beacon: false,
        reference: true,
        segments: 1,
        ..rig::Options::default()
    }
}

/// A courier of the independent simulator, on two motions.
fn recordings(seed: u64, effect: &str) -> [Recording; 2] {
    let effects = [(effect, 2.0e-6)];
    [seed, seed + 1000].map(|motion| rig::record_as(seed, motion, &effects, &one_segment()).0)
}

/// What is named has its figures, and a model that leaves on another recording what was claimed.
#[test]
fn what_is_named_has_a_model_that_holds_elsewhere() {
    let [first, second] = recordings(71, "angle_dependence");
    let answer = diagnose_fully(&first, "first", &Options::default());
    assert_eq!(answer.diagnosis.verdict, Verdict::Named);
    let [named] = &answer.diagnosis.effects[..] else {
        panic!("{:?}", answer.diagnosis.effects)
    };
    assert_eq!(named.name, "angle_dependence");
    assert!(named.share > 0.9 && !named.magnitude.is_empty());
    let held_out = &answer.diagnosis.held_out;
    assert!(held_out.whitened_before > 2.0 && held_out.whitened_after < 1.2);
    let there = check(&answer.model.expect("a model"), &second).expect("residuals");
    assert!(there.whitened_after < 0.3 * there.whitened_before);
}

/// What is claimed beside noise that is louder than stated is in floors of the stated noise, as what `check` finds is.
#[test]
fn what_is_claimed_beside_louder_noise_is_found_elsewhere() {
    let [first, second] = recordings(74, "excess_noise");
    let answer = diagnose_fully(&first, "first", &Options::default());
    let [named] = &answer.diagnosis.effects[..] else {
        panic!("{:?}", answer.diagnosis.effects)
    };
    assert_eq!(named.name, "excess_noise");
    let claimed = answer.diagnosis.held_out.whitened_after;
    let there = check(&answer.model.expect("a model"), &second).expect("residuals");
    assert!(claimed > 1.5, "{claimed}");
    let ratio = claimed / there.whitened_after;
    assert!(
        (0.9..1.1).contains(&ratio),
        "{claimed} {}",
        there.whitened_after
    );
}

/// A hum near half the sample rate is as rough as noise, and a line in the spectrum is none.
#[test]
fn a_hum_is_no_noise() {
    for seed in [72, 73] {
        let [first, _] = recordings(seed, "line_pickup");
        let answer = diagnose_fully(&first, "first", &Options::default());
        assert_eq!(answer.diagnosis.verdict, Verdict::Unknown);
        assert_eq!(answer.diagnosis.place[0].coordinate, "frequency");
        assert!(answer.diagnosis.effects.is_empty());
    }
}

/// A vibration is as rough as noise from sample to sample, and no line was looked for when noise is first measured.
#[test]
fn a_fast_vibration_is_looked_for_before_noise_is_told() {
    let options = rig::Options {
        samples: 1500,
        ..rig::Options::default()
    };
    let still = rig::record(41, &[], &options).0;
    let shaken = rig::shake::shaken(&still, 0.31, |_| 6.0e-4);
    assert_eq!(names(&shaken), ["beacon_vibration"]);
}

/// Its noise is stated far too loud, and what the noise would have in common is not there.
#[test]
fn a_real_diode_whose_noise_is_stated_too_loud_is_named() {
    let Some(recording) = shared("quadrant-diode-aug28") else {
        return;
    };
    let answer = diagnose_fully(&recording, "diode", &Options::default());
    assert_eq!(answer.diagnosis.verdict, Verdict::Named);
    let mut effects = answer.diagnosis.effects.iter();
    assert!(effects.any(|effect| effect.name == "psd_nonlinearity"));
}

/// A small delay is hidden by noise that is stated a quarter too loud, and is named by the noise that the readings allow. A courier without
/// it shows no gap by that noise either. What is told of it stays over the stated noise.
#[test]
fn noise_that_is_stated_too_loud_hides_nothing() {
    let stated_too_loud = |effects: &[(&str, f64)]| {
        let options = rig::Options {
            samples: 1500,
            ..one_segment()
        };
        let mut recording = rig::record(76, effects, &options).0;
        let noise = &mut recording.meta.electronics.quadrature_noise_counts;
        *noise = noise.map(|counts| 1.25 * counts);
        recording
    };
    let slow = stated_too_loud(&[("velocity_lag", 5.0e-8)]);
    let answer = diagnose_fully(&slow, "slow", &Options::default());
    let named: Vec<&str> = answer
        .diagnosis
        .effects
        .iter()
        .map(|e| e.name.as_str())
        .collect();
    assert_eq!(named, ["velocity_lag"]);
    let held_out = &answer.diagnosis.held_out;
    assert!(held_out.whitened_before < 1.0 && held_out.whitened_after < held_out.whitened_before);
    let answer = diagnose_fully(&stated_too_loud(&[]), "none", &Options::default());
    assert_eq!(answer.diagnosis.verdict, Verdict::NoGap);
}

/// A delay beside harmonics is nothing that these lack: the delay's own columns take what they leave.
#[test]
fn what_a_form_leaves_is_taken_by_what_acts_beside_it() {
    let effects = [("extra_harmonics", 2.0e-6), ("velocity_lag", 1.0e-6)];
    let both = rig::record(75, &effects, &one_segment()).0;
    let found = form_error(&both, "extra_harmonics").expect("rows");
    let found = found.expect("harmonics");
    let beside = found.beside.as_ref().expect("a fit");
    let takes = |name: &str| {
        let mut each = beside.taken.iter();
        each.find(|taken| taken.block == name)
            .map_or(0.0, |taken| taken.squares / beside.squares)
    };
    assert!(found.explained > found.left, "{found:?}");
    assert!(takes("velocity_lag") > 0.8, "{beside:?}");
    assert!(takes("angle_dependence") < 0.5, "{beside:?}");
}

/// A channel that turns with the angle is one effect in a fuller form. A change with the angle and a wrong span predict the same of it, and Occam's
/// factor alone is for these two.
#[test]
fn fewer_effects_that_do_the_same_are_told() {
    let [first, _] = channel_turns(14);
    assert_eq!(names(&first), ["angle_dependence"]);
}

fn names(recording: &Recording) -> Vec<String> {
    let answer = diagnose_fully(recording, "first", &Options::default());
    let effects = answer.diagnosis.effects.iter();
    let mut names: Vec<String> = effects.map(|e| e.name.clone()).collect();
    names.sort_unstable();
    names
}

/// Noise of twelve times the stated one, by which amounts stray: most of what they leave is rough, and a pattern is left as well.
#[test]
#[ignore = "nightly: half a minute"]
fn noise_beneath_a_pattern_is_told() {
    assert_eq!(
        names(&direction_beside_noise().recorded(0)),
        ["excess_noise", "hysteresis"]
    );
}

/// A field of displaced teeth is the pattern beneath the noise.
#[test]
#[ignore = "nightly: half a minute"]
fn a_field_beneath_noise_is_told() {
    assert_eq!(
        names(&field_beneath_noise()),
        ["excess_noise", "tooth_variation"]
    );
}

/// Shapes over the temperature and the tooth phase do what pairs that warm do, and are no cause.
#[test]
#[ignore = "nightly: a quarter of a minute"]
fn a_fuller_form_takes_the_place_of_shapes() {
    let [first, _] = pairs_that_warm(16);
    assert_eq!(names(&first), ["thermal_drift"]);
}

/// Harmonics describe what a soft clip does to the phase as well as its own form does, and bend no figure.
#[test]
#[ignore = "nightly: a quarter of a minute"]
fn what_bends_the_figure_is_a_clip() {
    for (name, amplifier) in AMPLIFIERS {
        assert_eq!(names(&saturated(amplifier)), ["adc_clipping"], "{name}");
    }
}

/// Third harmonics that equation (3) lacks are a gap's own, and are told where no harmonics are found beside it.
#[test]
#[ignore = "nightly: a quarter of a minute"]
fn a_gap_holds_what_equation_3_lacks() {
    let [first, _] = gap_with_thirds();
    let answer = diagnose_fully(&first, "first", &Options::default());
    let left = answer.diagnosis.held_out.whitened_after;
    assert_eq!(answer.diagnosis.effects[0].name, "gap_variation");
    assert!(left < 1.1, "{left}");
}

/// A ring at one speed: what follows its poles has lines in the spectrum, which speak against no field.
#[test]
fn a_ring_at_one_speed_is_named() {
    let ring = Ring::draw(1, 0.01, 0.03);
    let recording = recorded(&ring, 1, 3.4, false);
    let answer = diagnose_fully(&recording, "ring", &Options::default());
    named(&answer.diagnosis);
}

/// Harmonics that grow with the speed are in no catalogue. A pair's wander may take any course, the speed's as well, and is not told for it.
#[test]
fn what_follows_the_speed_is_put_down_to_no_wander() {
    let options = rig::Options {
        counts: false,
        ..one_segment()
    };
    let (recording, _) = rig::record_as(81, 81, &[("speed_harmonics", 3.0e-6)], &options);
    let answer = diagnose_fully(&recording, "speed", &Options::default());
    assert_eq!(answer.diagnosis.verdict, Verdict::Unknown);
    let place = &answer.diagnosis.place[0].coordinate;
    assert!(place.starts_with("speed"), "{place}");
}
