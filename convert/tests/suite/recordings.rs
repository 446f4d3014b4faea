//! What a recording holds that was made of a log: teeth, noise, amplitude, runs.

use crate::log::{COLUMNS, Logged, PITCH_M, converted, encoder, order, plain, text};

#[test]
fn teeth_noise_and_amplitude_are_those_of_the_encoder() {
    let rows = encoder();
    let made = converted(&text(&rows, &plain()), &order(&COLUMNS)).unwrap();
    assert_eq!(made.told.warnings, []);
    let samples = &made.recording.samples;
    for (row, [.., stage_m]) in rows.iter().enumerate() {
        let off_m = samples.unmodified_m(0, row, PITCH_M).unwrap() - stage_m;
        assert!(off_m.abs() < 0.01 * PITCH_M, "row {row}: {off_m}");
    }
    let electronics = made.recording.meta.electronics;
    let noise = electronics.quadrature_noise_counts.unwrap() / 6.0;
    assert!((noise - 1.0).abs() < 0.1, "{electronics:?}");
    assert!(
        (electronics.amplitude_counts.unwrap() / 8000.0 - 1.0).abs() < 0.01,
        "{electronics:?}"
    );
}

/// Steps of over half a pitch: by the reference where there is one, refused where there is none.
#[test]
fn steps_of_over_half_a_pitch() {
    let quick: Vec<Logged> = encoder().into_iter().step_by(80).collect();
    let made = converted(&text(&quick, &plain()), &order(&COLUMNS)).unwrap();
    for (row, [.., stage_m]) in quick.iter().enumerate() {
        let off_m = made
            .recording
            .samples
            .unmodified_m(0, row, PITCH_M)
            .unwrap()
            - stage_m;
        assert!(off_m.abs() < 0.01 * PITCH_M, "row {row}: {off_m}");
    }
    let alone = converted(&text(&quick, &plain()), &order(&COLUMNS[..3])).unwrap_err();
    assert!(
        alone.contains("column n1, found") && alone.contains("half a pitch"),
        "{alone}"
    );
}

/// A reference that stands still tells no reversal: the segment does.
#[test]
fn runs_are_told_by_what_travels() {
    let standing: Vec<Logged> = encoder()
        .iter()
        .map(|[t_s, s, c, _]| [*t_s, *s, *c, 0.0])
        .collect();
    let runs = |rows: &[Logged]| {
        let made = converted(&text(rows, &plain()), &order(&COLUMNS)).unwrap();
        made.told.runs.len()
    };
    assert_eq!(runs(&standing), runs(&encoder()));
    assert!(runs(&standing) > 1);
}
