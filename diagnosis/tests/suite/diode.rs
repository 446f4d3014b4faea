//! How the coordination sensor's diode is mounted: what is its own, what the platen's, and what nobody can tell.
use crate::shared::shared;
use specimens::rig;

use diagnosis::{Diagnosis, Options, Verdict, diagnose};
use effects::psd_misalignment::PsdMisalignment;
use hal_sim::courier::Courier;
use hal_sim::presets::ideal;
use hal_sim::trajectory::{OpenLoop, Plan};

fn names(d: &Diagnosis) -> Vec<&str> {
    d.effects.iter().map(|e| e.name.as_str()).collect()
}

/// The same recording seen by a diode that leans in its mount: its axes differ in gain by `gain`, and cross by `slant`.
fn leaning(recording: &recording::Recording, gain: f64, slant: f64) -> recording::Recording {
    let mut out = recording.clone();
    out.samples = recording::Samples::default();
    for i in 0..recording.samples.len() {
        let mut row = recording.samples.row(i);
        if let Some([right, left, up, down]) = row.electrode_counts.filter(|e| *e != [0.0; 4]) {
            let (sums, differences) = ([right + left, up + down], [right - left, up - down]);
            let [x, y] = [0, 1].map(|a| differences[a] / sums[a]);
            let seen = [x * (1.0 + 0.5 * gain) + slant * y, y * (1.0 - 0.5 * gain)];
            let [x, y] = [0, 1].map(|a| 0.5 * sums[a] * seen[a]);
            let [u, v] = [0, 1].map(|a| 0.5 * sums[a]);
            let counts = [u + x, u - x, v + y, v - y];
            row.electrode_counts = Some(counts.map(f64::round));
        }
        out.samples.push(&row);
    }
    out
}

/// Lines that are not square turn and stretch what the platen sensor says; what leans in its mount, what the diode says. The lever
/// arms part the two.
#[test]
fn a_diode_that_leans_is_no_platen_out_of_square() {
    let options = rig::Options {
        samples: 6000,
        ..rig::Options::default()
    };
    let straight = rig::record(41, &[], &options).0;
    let d = diagnose(
        &leaning(&straight, 1.6e-3, 0.8e-3),
        "rig",
        &Options::default(),
    );
    assert_eq!(names(&d), ["psd_misalignment"], "{:?}", d.verdict);
}

/// A courier whose diode is mounted so.
fn mounted(seed: u64, diode: PsdMisalignment) -> Diagnosis {
    let mut spec = ideal(seed);
    spec.effects.push(Box::new(diode));
    let courier = OpenLoop::COURIER;
    let plan = Plan::usual(1200, spec.nominal, &spec.places, courier, seed);
    let mut courier = Courier::new(spec, seed).expect("a waveform with an inverse");
    let recording = hal_sim::record::record(&mut courier, &plan, false);
    diagnose(&recording, "mounted", &Options::default())
}

/// A turn of 4 um at 4 mm, which the platen sensor's own zero of angle takes up: nobody can tell the two apart.
#[test]
fn a_diode_that_is_only_turned_leaves_no_gap() {
    let turned = PsdMisalignment {
        turn_rad: 1.0e-3,
        gain_difference: 0.0,
        centre: [0.002, -0.001],
    };
    let d = mounted(51, turned);
    assert_eq!(d.verdict, Verdict::NoGap, "{:?}", names(&d));
}

/// A spot that a fly-by takes beyond the diode's edge, where its reading stands still.
#[test]
fn a_spot_at_the_edge_of_the_diode_is_no_reading() {
    let aside = PsdMisalignment {
        turn_rad: 0.0,
        gain_difference: 0.0,
        centre: [0.25, 0.0],
    };
    let d = mounted(52, aside);
    assert_eq!(d.verdict, Verdict::NoGap, "{:?}", names(&d));
}

/// The same recording seen by a diode of quadrants: the light goes over from one to the next as a hyperbolic tangent does, which at 0.8 of full
/// scale is a twentieth less than a line.
fn of_quadrants(recording: &recording::Recording) -> recording::Recording {
    const STEEP: f64 = 0.5;
    let mut out = recording.clone();
    out.samples = recording::Samples::default();
    for i in 0..recording.samples.len() {
        let mut row = recording.samples.row(i);
        if let Some([right, left, up, down]) = row.electrode_counts.filter(|e| *e != [0.0; 4]) {
            let bent = |a: f64, b: f64| {
                let (sum, share) = (a + b, (a - b) / (a + b));
                let seen = (STEEP * share).tanh() / STEEP;
                [0.5 * sum * (1.0 + seen), 0.5 * sum * (1.0 - seen)]
            };
            let [[right, left], [up, down]] = [bent(right, left), bent(up, down)];
            row.electrode_counts = Some([right, left, up, down].map(f64::round));
        }
        out.samples.push(&row);
    }
    out
}

/// Named, and a fifth of the gap or less is left in both channels of the diode.
fn bend_is_named(answer: &Diagnosis) {
    assert_eq!(answer.verdict, Verdict::Named, "{:?}", answer.place);
    assert!(
        names(answer).contains(&"psd_nonlinearity"),
        "{:?}",
        names(answer)
    );
    let channels = answer.held_out.channels.iter();
    for c in channels.filter(|c| c.channel != "g_p") {
        let most_m = (0.2 * c.before_rms_m).max(1.1 * c.floor_rms_m);
        assert!(c.after_rms_m < most_m, "{c:?}");
    }
}

#[test]
fn a_diode_of_quadrants_bends_far_and_is_named() {
    let options = rig::Options {
        samples: 5000,
        ..rig::Options::default()
    };
    let recording = of_quadrants(&rig::record(61, &[], &options).0);
    bend_is_named(&diagnose(&recording, "quadrants", &Options::default()));
}

#[test]
fn a_real_diode_of_quadrants_is_named() {
    let Some(recording) = shared("quadrant-diode-aug28") else {
        return;
    };
    bend_is_named(&diagnose(&recording, "diode", &Options::default()));
}
