//! Free harmonics over either phase of the own tooth: where the courier is, or what the output says.
use specimens::rig;

use diagnosis::verdict::answer::Verdict;
use recording::{Recording, Samples};
use std::f64::consts::TAU;

/// A recording of positions with 3 µm of order 11 on segment 1, over the phase of the output itself.
fn over_the_output(samples: usize) -> Recording {
    let options = rig::Options {
        samples,
        beacon: false,
        counts: false,
        ..rig::Options::default()
    };
    let (clean, courier) = rig::record(47, &[], &options);
    let mut with = Samples::default();
    for i in 0..clean.samples.len() {
        let mut row = clean.samples.row(i);
        if let Some(position) = &mut row.position_m[0] {
            // p + h(p) is what it was: solved for p.
            let was = *position;
            for _ in 0..30 {
                *position = was - 3.0e-6 * (11.0 * TAU * *position / courier.pitch).sin();
            }
        }
        with.push(&row);
    }
    Recording {
        samples: with,
        ..clean
    }
}

#[test]
fn harmonics_of_the_output_leave_nothing() {
    let answer = diagnosis::diagnose(&over_the_output(6000), "r", &diagnosis::Options::default());
    assert_eq!(answer.verdict, Verdict::Named, "{answer:?}");
    assert_eq!(answer.effects[0].name, "extra_harmonics");
    assert_eq!(answer.effects.len(), 1, "{answer:?}");
    // Over the calibrated phase a tenth of a radian of error is more than one of order 11.
    assert!(answer.held_out.whitened_after < 1.1, "{answer:?}");
}
