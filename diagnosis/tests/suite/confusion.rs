//! The diagnosis on a few recordings of the independent rig and on real ones, in the ordinary tests.

use crate::shared::shared;
use diagnosis::verdict::answer::Named;
use diagnosis::{Diagnosis, Options, Verdict, diagnose};
use recording::Recording;
use specimens::rig;
use specimens::{Case, Conditions, Drawn, Kind};

fn on_rig(seed: u64, effects: &[(&str, f64)]) -> Diagnosis {
    let options = rig::Options {
        samples: 6000,
        ..rig::Options::default()
    };
    diagnose(
        &rig::record(seed, effects, &options).0,
        "rig",
        &Options::default(),
    )
}

pub fn names(d: &Diagnosis) -> Vec<&str> {
    d.effects.iter().map(|e| e.name.as_str()).collect()
}

#[test]
fn no_effect_is_no_gap() {
    assert_eq!(on_rig(21, &[]).verdict, Verdict::NoGap);
}

/// One segment beside a reference: where it is across its direction, and how it is turned, only the reference tells.
#[test]
fn one_segment_against_a_reference() {
    for name in ["lateral_dependence", "span_error"] {
        let options = rig::Options {
            samples: 6000,
            beacon: false,
            reference: true,
            segments: 1,
            ..rig::Options::default()
        };
        let recording = rig::record(38, &[(name, 2.0e-6)], &options).0;
        let d = diagnose(&recording, "rig", &Options::default());
        assert_eq!(names(&d), [name], "{:?}", d.verdict);
    }
}

/// The same with a pause at its end, in which the reference is struck now and then.
fn struck_at_rest(recording: &Recording) -> Recording {
    let mut out = recording.clone();
    let last = recording.samples.len() - 1;
    let noise = recording.meta.electronics.quadrature_noise_counts;
    let mut dice = rig::Dice(5);
    for k in 1..=2000 {
        let mut row = recording.samples.row(last);
        row.t_s += f64::from(k) * 1.0e-3;
        row.run = "pause";
        for pair in row.quadrature_counts.iter_mut().flatten() {
            *pair = pair.map(|v| (v + noise.expect("stated") * dice.normal()).round());
        }
        if k % 180 == 0 {
            row.reference[0] = row.reference[0].map(|x| x + 40.0e-6);
        }
        out.samples.push(&row);
    }
    out
}

/// What rests on one place tells no more of it, and is left out of the comparison; a disturbance is one there as well.
#[test]
fn a_burst_at_rest_is_a_burst() {
    let options = rig::Options {
        samples: 6000,
        beacon: false,
        reference: true,
        ..rig::Options::default()
    };
    let quiet = rig::record(38, &[], &options).0;
    let of = |recording| diagnose(recording, "rig", &Options::default());
    assert_eq!(of(&quiet).verdict, Verdict::NoGap);
    assert_eq!(names(&of(&struck_at_rest(&quiet))), ["outlier_bursts"]);
}

/// What a coil of some width loses does not ask which way it is turned: nothing of it is odd in the angle.
#[test]
fn an_angle_may_act_either_way_alike() {
    let options = rig::Options {
        samples: 6000,
        beacon: false,
        reference: true,
        ..rig::Options::default()
    };
    let recording = rig::record(24, &[("wide_coil", 2.0e-6)], &options).0;
    let d = diagnose(&recording, "rig", &Options::default());
    assert_eq!(names(&d), ["angle_dependence"], "{:?}", d.verdict);
}

#[test]
fn single_effects_are_named() {
    for name in [
        "lateral_dependence",
        "velocity_lag",
        "adc_clipping",
        "span_error",
        "cycle_slip",
        "outlier_bursts",
        "excess_noise",
    ] {
        let d = on_rig(22, &[(name, 2.0e-6)]);
        assert_eq!(names(&d), [name], "{:?}", d.verdict);
    }
}

/// A courier of four segments without a beacon.
pub fn four_segments(seed: u64, effects: &[(&str, f64)]) -> Recording {
    let options = rig::Options {
        samples: 6000,
        beacon: false,
        ..rig::Options::default()
    };
    rig::record(seed, effects, &options).0
}

fn with_four_segments(seed: u64, effects: &[(&str, f64)]) -> Diagnosis {
    diagnose(&four_segments(seed, effects), "rig", &Options::default())
}

/// A light that flickers beside the beacon changes the diode's gain: as many lines as the deflection has, none a vibration's.
#[test]
fn a_flickering_lamp_is_located() {
    let d = on_rig(23, &[("lamp_flicker", 2.0e-6)]);
    assert_eq!(d.verdict, Verdict::Unknown, "{:?}", names(&d));
    assert_eq!(d.place[0].coordinate, "frequency", "{:?}", d.place);
}

pub fn pair(seed: u64, effects: [(&str, f64); 2]) -> Case {
    case(seed, Kind::Pair, &effects)
}

fn case(seed: u64, kind: Kind, effects: &[(&str, f64)]) -> Case {
    let drawn = |(name, size_m): &(&str, f64)| Drawn {
        name: (*name).into(),
        size_m: *size_m,
    };
    Case {
        number: 0,
        seed,
        kind,
        effects: effects.iter().map(drawn).collect(),
        conditions: Conditions::Usual,
    }
}

/// A ruling that is out of square moves the teeth themselves: what repeats with them stays where the readings say.
#[test]
fn harmonics_beside_a_skew_stay_on_their_teeth() {
    let case = pair(19, [("extra_harmonics", 3.5e-6), ("axis_skew", 1.5e-6)]);
    let d = diagnose(&case.recorded(0), "blind", &Options::default());
    assert_eq!(
        names(&d),
        ["extra_harmonics", "axis_skew"],
        "{:?}",
        d.verdict
    );
    assert!(d.held_out.whitened_after < 1.05, "{:?}", d.held_out);
}

/// Each moves the places that the other is evaluated at: to first order the skew takes two fifths of what is left, fitted together
/// nearly all.
#[test]
#[ignore = "nightly: a quarter of a minute"]
fn a_skew_beside_a_gap_of_thirty_floors_is_named() {
    let effects = [("lateral_dependence", 2.932e-6), ("axis_skew", 2.875e-6)];
    let case = pair(3_268_608_699_398_037, effects);
    let d = diagnose(&case.recorded(0), "two", &Options::default());
    assert_eq!(names(&d), ["lateral_dependence", "axis_skew"]);
}

/// It takes two hundredths of the noise, and more of it than any shape without a name.
#[test]
fn what_leads_all_shapes_is_named_beside_another() {
    let effects = [("hysteresis", 1.164e-6), ("psd_nonlinearity", 0.827e-6)];
    let case = pair(1_792_724_269_156_848, effects);
    let d = diagnose(&case.recorded(0), "two", &Options::default());
    assert_eq!(names(&d), ["hysteresis", "psd_nonlinearity"]);
}

/// With four segments alone the teeth that one pair crosses are nearly those beside the other: lateral waves take most of what
/// harmonics leave, and leave a gap that shows.
#[test]
fn harmonics_beside_a_gap_are_no_lateral_waves() {
    let d = with_four_segments(
        42,
        &[("extra_harmonics", 2.0e-6), ("gap_variation", 1.5e-6)],
    );
    let mut found = names(&d);
    found.sort_unstable();
    assert_eq!(
        found,
        ["extra_harmonics", "gap_variation"],
        "{:?}",
        d.verdict
    );
}

pub fn sorted(d: &Diagnosis) -> Vec<&str> {
    let mut found = names(d);
    found.sort_unstable();
    found
}

#[test]
fn an_unlisted_effect_is_unknown() {
    let d = on_rig(23, &[("theta_bend", 2.0e-6)]);
    assert_eq!(d.verdict, Verdict::Unknown);
    assert!(d.place[0].coordinate.starts_with("theta"), "{:?}", d.place);
}

/// Fringes over the deflection are shorter than the waves that every recording is asked for.
#[test]
fn fringes_of_the_coordination_sensor_are_located() {
    let d = on_rig(23, &[("psd_fringes", 2.0e-6)]);
    assert_eq!(d.verdict, Verdict::Unknown);
    assert!(
        d.place[0].coordinate.contains("deflection"),
        "{:?}",
        d.place
    );
}

/// A segment that nothing else can stand for is told, and the channel that shows it.
#[test]
fn the_segment_and_the_channel_of_a_gap_are_told() {
    let d = on_rig(23, &[("one_lateral", 2.0e-6)]);
    assert_eq!(names(&d), ["lateral_dependence"]);
    let first = &d.place[0];
    assert_eq!(first.coordinate, "lateral tooth phase, order 1, segment 2");
    assert_eq!(first.channel, "g_y");
}

/// What nothing explains is looked at more finely: products of two speeds, and high orders that change with temperature.
#[test]
fn what_nothing_explains_is_located_more_finely() {
    is_located("warm_thirds", "temperature and own tooth phase");
}

#[test]
#[ignore = "nightly: half a minute"]
fn products_of_two_speeds_are_located() {
    is_located("speeds_together", "speed");
}

fn is_located(effect: &str, coordinate: &str) {
    let d = on_rig(23, &[(effect, 2.0e-6)]);
    assert_eq!(d.verdict, Verdict::Unknown, "{effect}: {:?}", names(&d));
    assert!(
        d.place[0].coordinate.starts_with(coordinate),
        "{:?}",
        d.place
    );
    assert!(d.place[0].share > 0.9, "{:?}", d.place);
}

/// What a cable drags after the courier remembers millimetres of its way, in any direction: neither a speed nor a deflection.
#[test]
#[ignore = "nightly: half a minute to two"]
fn what_is_dragged_over_millimetres_lies_over_the_direction() {
    for (seed, size_m) in [
        (3_212_813_317_399_476, 2.610e-6),
        (90_379_183_017_123, 2.322e-6),
    ] {
        let case = case(seed, Kind::Unlisted, &[("cable_drag", size_m)]);
        let d = diagnose(&case.recorded(0), "dragged", &Options::default());
        assert_eq!(d.verdict, Verdict::Unknown, "{:?}", names(&d));
        assert!(
            d.place[0].coordinate.starts_with("direction"),
            "{:?}",
            d.place
        );
        assert!(d.place[0].share > 0.5, "{:?}", d.place);
    }
}

/// What a recording would be if a segment had crept so far, and the room had cooled meanwhile, but for a swing of its own.
fn creeping(still: &recording::Recording, creep_m: f64, swing_k: f64) -> recording::Recording {
    let mut out = still.clone();
    out.samples = recording::Samples::default();
    let last = still.samples.len() - 1;
    let [begin_s, end_s] = [0, last].map(|i| still.samples.row(i).t_s);
    for i in 0..=last {
        let mut row = still.samples.row(i);
        let progress = (row.t_s - begin_s) / (end_s - begin_s);
        let relaxed = 1.0 - (-3.0 * progress).exp();
        row.temperature_c = Some(23.0 - 3.0 * relaxed - swing_k * (6.0 * progress).sin());
        row.position_m[0] = row.position_m[0].map(|p| p + creep_m * relaxed);
        out.samples.push(&row);
    }
    out
}

/// A segment that creeps while the room cools: that is no thermal drift for certain.
#[test]
fn a_creep_while_the_room_cools_may_follow_the_clock() {
    let options = rig::Options {
        samples: 6000,
        counts: false,
        ..rig::Options::default()
    };
    let still = rig::record(61, &[], &options).0;
    let recording = creeping(&still, 8.0e-6, 0.2);
    let d = diagnose(&recording, "creeping", &Options::default());
    let over_time = || d.place[0].coordinate.starts_with("time");
    // The room only cools: a course of the segment's own and the temperature's differ by 1.2 % of the amplitude here, and are told as an
    // alias where that is within what the drift's form may lack.
    let either = |effect: &Named| effect.aliases.iter().any(|a| a == "quadrature_drift");
    assert!(
        d.verdict == Verdict::Unknown && over_time()
            || d.verdict == Verdict::Alias && d.effects.iter().all(either),
        "{:?} {:?} {:?}",
        d.verdict,
        names(&d),
        d.place
    );
}

/// What follows the clock that much better than the thermometer follows no thermometer. Wanted, and not met: both are an `alias` today, since forms
/// may lack more than tells the two apart.
#[test]
#[ignore = "nightly: half a minute; wanted, not met"]
fn a_creep_while_the_room_cools_is_no_thermal_drift() {
    let options = rig::Options {
        samples: 6000,
        counts: false,
        ..rig::Options::default()
    };
    for (seed, swing_k) in [(61, 0.2), (63, 0.4)] {
        let still = rig::record(seed, &[], &options).0;
        let recording = creeping(&still, 8.0e-6, swing_k);
        let d = diagnose(&recording, "creeping", &Options::default());
        assert_eq!(d.verdict, Verdict::Unknown, "{:?}", names(&d));
        assert!(d.place[0].coordinate.starts_with("time"), "{:?}", d.place);
    }
}

/// The rig's field bus is 34 ms late. Wanted, and not met: `hysteresis` is named for it, of which the shaft's one speed either way makes nearly the same.
#[test]
#[ignore = "nightly: a quarter of a minute; wanted, not met"]
fn a_real_delay_is_named_or_an_alias() {
    for folder in ["ess-rotary-normal", "ess-rotary-drive-divided"] {
        let Some(recording) = shared(folder) else {
            return;
        };
        let d = diagnose(&recording, folder, &Options::default());
        let delay = "velocity_lag".to_owned();
        let told = |e: &Named| e.name == delay || e.aliases.contains(&delay);
        assert!(d.effects.iter().any(told), "{folder}: {:?}", names(&d));
    }
}

/// The flaw that is known is the clip. Beside it an error changes with the direction: the shaft turns at one speed either way, at which a delay and
/// play do nearly the same.
#[test]
fn a_real_clip_is_named() {
    let Some(recording) = shared("ess-rotary-normal") else {
        return;
    };
    let d = diagnose(&recording, "normal", &Options::default());
    let mut found = names(&d);
    found.sort_unstable();
    assert!(
        found == ["adc_clipping", "velocity_lag"] || found == ["adc_clipping", "hysteresis"],
        "{found:?}"
    );
    assert!(
        d.held_out.channels[0].after_rms_m < 1.25e-6,
        "{:?}",
        d.held_out
    );
    let without = diagnose(
        &recording,
        "normal",
        &Options {
            without: vec!["adc_clipping".into()],
            ..Options::default()
        },
    );
    assert_eq!(without.verdict, Verdict::Unknown);
    assert!(
        without
            .place
            .iter()
            .any(|w| w.coordinate.ends_with("orders 4, 8, 12, 16")),
        "{:?}",
        without.place
    );
}

#[test]
fn where_the_clip_is_gone_it_is_not_named() {
    let Some(recording) = shared("ess-rotary-drive-divided") else {
        return;
    };
    let d = diagnose(&recording, "divided", &Options::default());
    assert!(!names(&d).contains(&"adc_clipping"), "{:?}", d.effects);
}

/// A recording that cannot answer says which limit it violates, with both numbers, and names nothing.
#[test]
fn what_cannot_answer_says_so() {
    let good = rig::record(
        24,
        &[],
        &rig::Options {
            samples: 6000,
            ..rig::Options::default()
        },
    )
    .0;
    let told = |recording: &recording::Recording| {
        let d = diagnose(recording, "bad", &Options::default());
        assert_eq!(d.verdict, Verdict::InsufficientData, "{d:?}");
        assert!(d.effects.is_empty());
        d.notes.join(" ")
    };
    let with = |change: &dyn Fn(usize, &mut recording::Row) -> bool| {
        good.with_rows(|i, row| change(i, row))
    };
    assert!(told(&with(&|i, _| i < 150)).contains("samples"));
    let dead = with(&|_, row| {
        row.quadrature_counts[1] = row.quadrature_counts[1].map(|pair| [0.0, pair[1]]);
        true
    });
    assert!(told(&dead).contains("q2s"));
    let mut loud = good.clone();
    let of_beacon = &mut loud.meta.electronics.psd_noise_counts;
    *of_beacon = of_beacon.map(|n| 10.0 * n);
    assert!(told(&loud).contains("stated noise"));
    let of_pairs = &mut loud.meta.electronics.quadrature_noise_counts;
    *of_pairs = of_pairs.map(|n| 10.0 * n);
    assert!(told(&loud).contains("stated noise"));
}

/// A part of a burst leaves the phase nearly where it is, and shows in the amplitude: taken for undisturbed, such samples made a gap of their own
/// that followed the signal's amplitude.
#[test]
fn bursts_leave_no_gap_that_follows_the_amplitude() {
    for number in [49, 55] {
        let case = Case::draw(number, 6058, Conditions::Drawn);
        let acts: Vec<&str> = case.effects.iter().map(|e| e.name.as_str()).collect();
        assert_eq!(acts, ["outlier_bursts"]);
        let answer = diagnose(&case.recorded(0), "bursts", &Options::default());
        let named: Vec<&str> = answer.effects.iter().map(|e| e.name.as_str()).collect();
        assert_eq!(named, acts, "{number}: {:?}", answer.place);
    }
}

/// Rounding to the codes that are left looks like louder noise of that pair, and is none. On the second courier a field over the platen describes a
/// part of it, and what that field leaves looks like louder noise.
#[test]
fn codes_that_are_missing_are_no_louder_noise() {
    for (number, seed) in [(87, 6060), (48, 6064)] {
        let case = Case::draw(number, seed, Conditions::Drawn);
        let acts: Vec<&str> = case.effects.iter().map(|e| e.name.as_str()).collect();
        assert_eq!(acts, ["missing_codes"]);
        let answer = diagnose(&case.recorded(0), "codes", &Options::default());
        assert_eq!(answer.verdict, Verdict::Unknown);
        let first = &answer.place[0].coordinate;
        assert!(first.contains("missing codes"), "{first}");
    }
}

/// Teeth that are displaced by a thirtieth of what is usual, over more of the platen than can be told tooth by tooth: fitted to a part of the
/// recording as if they were of the usual size, they predict the rest worse than nothing does.
#[test]
fn a_small_field_over_many_teeth_is_named() {
    let case = Case::draw(55, 6059, Conditions::Drawn);
    let acts: Vec<&str> = case.effects.iter().map(|e| e.name.as_str()).collect();
    assert_eq!(acts, ["tooth_variation"]);
    let answer = diagnose(&case.recorded(0), "field", &Options::default());
    let named: Vec<&str> = answer.effects.iter().map(|e| e.name.as_str()).collect();
    assert_eq!(named, acts, "{:?}", answer.place);
}
