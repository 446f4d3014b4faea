//! Clips of one end: rails that an offset has pushed the wave against.
mod rig;

use diagnosis::{Answer, Diagnosis, Options, diagnose_fully};
use effects::sensor::Clip;
use recording::{Recording, Row, Samples};

fn names(d: &Diagnosis) -> Vec<&str> {
    d.effects.iter().map(|e| e.name.as_str()).collect()
}

/// A recording of the rig with its rows changed.
fn changed(recording: &Recording, change: impl Fn(&mut Row)) -> Recording {
    let mut samples = Samples::default();
    for i in 0..recording.samples.len() {
        let mut row = recording.samples.row(i);
        change(&mut row);
        samples.push(&row);
    }
    Recording {
        samples,
        ..recording.clone()
    }
}

/// Rails of sine and cosine of segments 1 and 4, of the amplitude: one end, one channel at both ends but not alike.
const RAILS: [(usize, [[f64; 2]; 2]); 2] = [
    (0, [[-2.0, 0.86], [-2.0, 2.0]]),
    (3, [[-2.0, 2.0], [-0.90, 0.84]]),
];

fn cut(recording: &Recording) -> Recording {
    let amplitude = recording.meta.electronics.amplitude_counts.unwrap();
    changed(recording, |row| {
        for (s, rails) in RAILS {
            let between = |channel: usize, value: f64| {
                let [low, high] = rails[channel].map(|r| (r * amplitude).round());
                value.clamp(low, high)
            };
            row.quadrature_counts[s] =
                row.quadrature_counts[s].map(|p| [between(0, p[0]), between(1, p[1])]);
        }
    })
}

#[test]
fn a_clip_of_one_end_is_named_and_its_ends_are_told() {
    let options = rig::Options {
        samples: 6000,
        ..rig::Options::default()
    };
    let recording = cut(&rig::record(31, &[], &options).0);
    let Answer {
        diagnosis: d,
        model,
        ..
    } = diagnose_fully(&recording, "one end", &Options::default());
    assert_eq!(names(&d), ["adc_clipping"], "{:?}", d.verdict);
    assert!(d.held_out.whitened_after < 1.1, "{:?}", d.held_out);
    // The model carries the ends: those that cut within the pair's own gain of what was drawn, the others open.
    let found = &model.expect("a model").survey.clip;
    for (s, rails) in RAILS {
        let told = found[s].expect("a clip").rails;
        for (told, drawn) in told.as_flattened().iter().zip(rails.as_flattened()) {
            if drawn.abs() > 1.0 {
                assert_eq!(told.abs(), Clip::OPEN, "segment {}: {told}", s + 1);
            } else {
                assert!((told / drawn - 1.0).abs() < 0.01, "{told} for {drawn}");
            }
        }
    }
    assert_eq!([found[1], found[2]], [None; 2]);
}
