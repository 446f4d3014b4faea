//! A field that shifts both channels of a pair: by the place, or with a logged column.

use diagnosis::{Diagnosis, Options, Verdict, diagnose};
use recording::{Logged, Recording};
use specimens::{Case, Conditions, Drawn, Kind, rig};
use std::f64::consts::TAU;

/// Where two sources stand, m, and how far from the sensor's plane.
const SOURCES: [([f64; 2], f64); 2] = [([0.030, -0.045], 0.050), ([-0.040, 0.020], 0.060)];

/// What the sources do to a pair at a place, apart from their strengths.
fn fields([x, y]: [f64; 2]) -> [f64; 2] {
    SOURCES.map(|([a, b], away)| {
        let r = (x - a).hypot(y - b) / away;
        (1.0 + r * r).powf(-1.5)
    })
}

/// Offsets of the sine and the cosine of each segment at each sample, of the amplitude.
type Offsets = Vec<[[f64; 2]; 4]>;

/// Scales offsets about their means so that they displace by `size_m` rms, and adds them to the counts.
fn shifted(recording: &Recording, mut offsets: Offsets, size_m: f64) -> Recording {
    let count = offsets.len() as f64;
    let mut square = 0.0;
    for s in 0..4 {
        for channel in 0..2 {
            let mean = offsets.iter().map(|o| o[s][channel]).sum::<f64>() / count;
            offsets.iter_mut().for_each(|o| o[s][channel] -= mean);
            square += offsets.iter().map(|o| o[s][channel].powi(2)).sum::<f64>();
        }
    }
    // An offset turns its pair by itself times the cosine of the phase, or the sine.
    let rms = (square / count / 8.0).sqrt();
    let scale = size_m * TAU / recording.meta.geometry.pitch_m / rms;
    let amplitude = recording.meta.electronics.amplitude_counts.expect("counts");
    let mut out = recording.clone();
    let whole = std::mem::take(&mut out.samples);
    for (i, offsets) in offsets.iter().enumerate() {
        let mut row = whole.row(i);
        for (s, offset) in offsets.iter().enumerate() {
            let [sine, cosine] = row.quadrature_counts[s].expect("counts");
            let by = offset.map(|o| amplitude * scale * o);
            let moved = [sine + by[0], cosine + by[1]].map(f64::round);
            // Where the phase goes past half a turn the tooth count follows.
            let past = (sine.atan2(cosine) - moved[0].atan2(moved[1])) / TAU;
            row.quadrature_counts[s] = Some(moved);
            row.teeth[s] = row.teeth[s].map(|n| n + past.round() as i32);
        }
        out.samples.push(&row);
    }
    for logged in whole.logged() {
        out.samples.log(logged.clone());
    }
    out
}

/// The usual runs of a courier without an effect.
fn quiet(seed: u64) -> Recording {
    let options = rig::Options {
        samples: 5000,
        ..rig::Options::default()
    };
    rig::record(seed, &[], &options).0
}

/// Strengths by segment, channel and source.
fn strengths(seed: u64) -> [[[f64; 2]; 2]; 4] {
    let mut dice = rig::Dice(seed);
    [(); 4].map(|()| [(); 2].map(|()| [(); 2].map(|()| dice.normal())))
}

/// The same with a field over the places.
fn by_place(seed: u64, size_m: f64) -> Recording {
    let recording = quiet(seed);
    let strengths = strengths(seed);
    let samples = &recording.samples;
    let pitch_m = recording.meta.geometry.pitch_m;
    let at = |s: usize, i: usize| samples.unmodified_m(s, i, pitch_m).expect("a position");
    let offsets = (0..samples.len()).map(|i| {
        let place = [0.5 * (at(0, i) + at(2, i)), 0.5 * (at(1, i) + at(3, i))];
        let fields = fields(place);
        strengths.map(|channels| channels.map(|k| k[0] * fields[0] + k[1] * fields[1]))
    });
    shifted(&recording, offsets.collect(), size_m)
}

/// The usual runs with the drive's current logged, which a drive of many frequencies draws.
fn with_drive(seed: u64) -> (Recording, Vec<f64>) {
    let mut recording = quiet(seed);
    let mut dice = rig::Dice(seed ^ 0xd1ce);
    let drive_a: Vec<f64> = (0..recording.samples.len())
        .map(|_| 3.0 * dice.normal())
        .collect();
    recording.samples.log(Logged {
        name: "aux_drive_a".into(),
        values: drive_a.clone(),
    });
    (recording, drive_a)
}

/// The same with a field that follows the drive's current.
fn by_column(seed: u64, size_m: f64) -> Recording {
    let (recording, drive_a) = with_drive(seed);
    let strengths = strengths(seed);
    let offsets = drive_a.iter();
    let offsets = offsets.map(|a| strengths.map(|c| c.map(|k| k[0] * a)));
    shifted(&recording, offsets.collect(), size_m)
}

fn names(d: &Diagnosis) -> Vec<&str> {
    d.effects.iter().map(|e| e.name.as_str()).collect()
}

fn of(recording: &Recording) -> Diagnosis {
    diagnose(recording, "rig", &Options::default())
}

/// Over places that are passed again and again.
#[test]
fn a_field_over_the_places_is_named() {
    let d = of(&drawn(5008, &[1.5e-6]));
    let left = d.held_out.whitened_after;
    assert_eq!(names(&d), ["stray_field"], "{:?}, {left}", d.verdict);
    assert!(left < 1.1, "{left}");
    let place = &d.place.first().expect("a place").coordinate;
    assert_eq!(place, "place on the platen and own tooth phase");
}

#[test]
fn a_field_that_follows_a_logged_column_is_named() {
    let d = of(&by_column(41, 1.0e-6));
    let left = d.held_out.whitened_after;
    assert_eq!(names(&d), ["stray_field"], "{:?}, {left}", d.verdict);
    assert!(left < 1.1, "{left}");
    let told = &d.effects[0].magnitude[0].name;
    assert!(told.contains("with aux_drive_a"), "{told}");
}

#[test]
fn a_column_that_nothing_follows_names_nothing() {
    assert_eq!(of(&with_drive(43).0).verdict, Verdict::NoGap);
}

/// On one way each place has its own time: a pair that wanders does as well there, and only ways that come back part the two.
#[test]
fn on_one_way_alone_a_field_is_not_told_from_a_wander() {
    let both = by_place(32, 4.0e-6);
    let mut one = both.clone();
    one.samples = Default::default();
    for i in (0..both.samples.len()).filter(|i| both.samples.run(*i) == "flyby_x") {
        one.samples.push(&both.samples.row(i));
    }
    assert!(one.samples.len() > 300, "{}", one.samples.len());
    let d = of(&one);
    assert_ne!(names(&d), ["stray_field"], "{:?}", d.verdict);
}

/// Answers to twenty recordings, sizes from 0.7 to 4 µm; gives those whose effects are not as wanted.
fn wrong_of_twenty(record: impl Fn(u64, f64) -> Recording, wanted: &[&str]) -> Vec<String> {
    let mut wrong = Vec::new();
    for k in 0..20 {
        let d = of(&record(k, 0.7e-6 * (4.0_f64 / 0.7).powf(k as f64 / 19.0)));
        let (found, left) = (names(&d), d.held_out.whitened_after);
        println!("{k}: {:?} {found:?}, {left:.3}", d.verdict);
        if found != wanted {
            wrong.push(format!("{k}: {found:?}"));
        }
    }
    wrong
}

#[test]
#[ignore = "nightly: some minutes"]
fn twenty_fields_that_follow_a_column_are_named() {
    let wrong = wrong_of_twenty(|k, size_m| by_column(7000 + k, size_m), &["stray_field"]);
    assert!(wrong.is_empty(), "{wrong:?}");
}

#[test]
#[ignore = "nightly: ten minutes"]
fn twenty_fields_over_the_places_are_named() {
    let wrong = wrong_of_twenty(|k, size_m| drawn(5000 + k, &[size_m]), &["stray_field"]);
    assert!(wrong.is_empty(), "{wrong:?}");
}

#[test]
#[ignore = "nightly: some minutes"]
fn of_twenty_couriers_without_a_field_none_is_named() {
    let wrong = wrong_of_twenty(|k, _| drawn(6000 + k, &[]), &[]);
    assert!(wrong.is_empty(), "{wrong:?}");
}

/// A courier of the simulator with fields over the places of these sizes.
fn drawn(seed: u64, sizes_m: &[f64]) -> Recording {
    let field = |size_m: &f64| Drawn {
        name: "stray_field".into(),
        size_m: *size_m,
    };
    let case = Case {
        number: 0,
        seed,
        kind: Kind::Single,
        effects: sizes_m.iter().map(field).collect(),
        conditions: Conditions::Usual,
    };
    case.recorded(0)
}
