//! Too little motion, too few samples, dead and clipped channels: `insufficient_data` with the limit.

use super::field::{diagnose, sound, with_lateral};
use recording::{Recording, Row};

/// Both couriers must be told to be insufficient after the same change.
fn insufficient(change: impl Fn(usize, &mut Row) -> bool, words: &[&str]) {
    for of in [sound(), with_lateral()] {
        diagnose(&of.with_rows(&change)).insufficient(words);
    }
}

#[test]
fn too_few_samples() {
    insufficient(|i, _| i % 20 == 0, &["samples", "200"]);
    // Shorter than one block of the comparison.
    insufficient(
        |i, _| i < 7,
        &["samples: 7", "what lacks: 193 samples more"],
    );
}

#[test]
fn too_little_motion() {
    let at_rest = |row: &Row| row.run == "still" || row.run == "spin";
    insufficient(
        |i, row| {
            let keep = at_rest(row) || i % 2 == 0 && row.run == "flyby_y_slow";
            row.quadrature_counts[0] = Some([120.0, 20000.0]);
            row.teeth[0] = Some(3);
            keep
        },
        &["sixteenths of the tooth phase", "segment 1", "12"],
    );
    // Along one axis only.
    insufficient(
        |_, row| row.run.starts_with("flyby_x") || row.run == "still",
        &[
            "segment 2",
            "12",
            "what lacks: a run along y over 2.0 mm or more, at ",
        ],
    );
    // Fly-bys at one angle: the segments of an axis are not told apart.
    insufficient(
        |_, row| row.run.starts_with("flyby"),
        &[
            "deviation of the angle",
            "at least 1 mrad",
            "what lacks: a turn by 1.7 mrad or more",
        ],
    );
}

#[test]
fn dead_and_frozen_channels() {
    let pair = |row: &mut Row, s: usize, to: [Option<f64>; 2]| {
        let [sine, cosine] = row.quadrature_counts[s].unwrap();
        row.quadrature_counts[s] = Some([to[0].unwrap_or(sine), to[1].unwrap_or(cosine)]);
        true
    };
    insufficient(
        |_, row| pair(row, 1, [Some(0.0), None]),
        &["spread of q2s", "counts"],
    );
    insufficient(
        |_, row| pair(row, 2, [None, Some(32767.0)]),
        &["spread of q3c", "counts"],
    );
    insufficient(
        |_, row| {
            row.teeth[1] = Some(0);
            true
        },
        &["segment 2's tooth changes", "n2"],
    );
    let sound = sound();
    let stuck = sound.samples.row(900);
    let (counts, teeth) = (stuck.quadrature_counts[2], stuck.teeth[2]);
    let frozen = sound.with_rows(|i, row| {
        if i > 900 {
            (row.quadrature_counts[2], row.teeth[2]) = (counts, teeth);
        }
        true
    });
    diagnose(&frozen).insufficient(&["segment 3 moves"]);
}

#[test]
fn dead_electrodes() {
    for value in [0.0, 30000.0] {
        insufficient(
            |_, row| {
                let electrodes = row.electrode_counts.as_mut().unwrap();
                if electrodes.iter().any(|e| *e != 0.0) {
                    electrodes[0] = value;
                }
                true
            },
            &["psd_xp", "counts"],
        );
    }
}

#[test]
fn clipped_throughout() {
    let clipped = |of: &Recording, level: f64| {
        let top = level * of.meta.electronics.amplitude_counts.unwrap();
        of.with_rows(|_, row| {
            row.quadrature_counts[1] =
                row.quadrature_counts[1].map(|p| p.map(|v| v.clamp(-top, top)));
            true
        })
    };
    // What is left of the segment tells four places of a tooth: nothing is named.
    for (of, level) in [(sound(), 0.2), (with_lateral(), 0.02), (sound(), 0.3)] {
        diagnose(&clipped(&of, level)).insufficient(&["q2", "top"]);
    }
    // Over-range at its tips is an effect that has a name.
    assert_eq!(diagnose(&clipped(&sound(), 0.9)).names(), ["adc_clipping"]);
}

#[test]
fn nothing_to_form_a_residual_of() {
    let no_reference = "segments recorded without a reference of the same coordinate";
    insufficient(
        |_, row| {
            (row.quadrature_counts[3], row.teeth[3]) = (None, None);
            true
        },
        &[no_reference, "3", "4"],
    );
    insufficient(
        |i, row| {
            let s = i % 2;
            (row.quadrature_counts[s], row.teeth[s]) = (None, None);
            true
        },
        &["all that a residual is formed of: 0", "200"],
    );
}
