//! What shows only once another is fitted with it: a small effect beside a great one, and lines that wind beside their skew.

use diagnosis::blind::{Case, Drawn, Kind};
use diagnosis::{Diagnosis, Options, diagnose};
use effects::plant::{Instant, PlantEffect, SEGMENTS, SegmentPoint};
use hal_sim::courier::Courier;
use hal_sim::presets::ideal;
use hal_sim::trajectory::{OpenLoop, Plan};

fn names(d: &Diagnosis) -> Vec<&str> {
    d.effects.iter().map(|e| e.name.as_str()).collect()
}

fn told(seed: u64, effects: [(&str, f64); 2]) -> Diagnosis {
    let drawn = |(name, size_m): (&str, f64)| Drawn {
        name: name.into(),
        size_m,
    };
    let case = Case {
        number: 0,
        seed,
        kind: Kind::Pair,
        effects: effects.map(drawn).into(),
    };
    diagnose(&case.recorded(0), "two", &Options::default())
}

/// Each moves the places that the other is evaluated at: to first order the skew takes two fifths of what is left, fitted together
/// nearly all.
#[test]
fn a_skew_beside_a_gap_of_thirty_floors_is_named() {
    let effects = [("lateral_dependence", 2.932e-6), ("axis_skew", 2.875e-6)];
    let d = told(3_268_608_699_398_037, effects);
    assert_eq!(names(&d), ["lateral_dependence", "axis_skew"]);
}

/// It takes two hundredths of the noise, and more of it than any shape without a name.
#[test]
fn what_leads_all_shapes_is_named_beside_another() {
    let effects = [("hysteresis", 1.164e-6), ("psd_nonlinearity", 0.827e-6)];
    let d = told(1_792_724_269_156_848, effects);
    assert_eq!(names(&d), ["hysteresis", "psd_nonlinearity"]);
}

/// Lines out of square, and bowed: each segment passes them where it is.
struct Bowed {
    skew_rad: f64,
    bow_per_m: f64,
}

impl PlantEffect for Bowed {
    fn scale(&mut self, factor: f64) {
        self.skew_rad *= factor;
        self.bow_per_m *= factor;
    }

    fn platen(&mut self, at: &Instant, points: &mut [SegmentPoint; SEGMENTS]) {
        for s in [0, 2] {
            let across_m = points[s].across_m + at.geometry.across_offset_m(s);
            points[s].own_m += across_m * (self.skew_rad + self.bow_per_m * across_m);
        }
    }
}

#[test]
fn lines_that_wind_are_told_with_their_skew() {
    for (seed, bow_per_m) in [(3, 0.001), (4, -0.0015)] {
        let mut spec = ideal(seed);
        spec.effects.push(Box::new(Bowed {
            skew_rad: 2.0e-3,
            bow_per_m,
        }));
        let plan = Plan::usual(1500, spec.nominal, &spec.places, OpenLoop::COURIER, seed);
        let mut courier = Courier::new(spec, seed).expect("a waveform with an inverse");
        let recording = hal_sim::record::record(&mut courier, &plan, false);
        let d = diagnose(&recording, "bowed", &Options::default());
        assert_eq!(names(&d), ["axis_skew"], "{:?}", d.held_out);
        // As asked: within 10 % of the best possible, which is the floor. Without shapes for the bow it is `unknown`.
        assert!(d.held_out.whitened_after < 1.1, "{:?}", d.held_out);
    }
}
