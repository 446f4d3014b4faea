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

/// The index stands in the recording as it was logged; a column that is only called so is as often the number of a row.
#[test]
fn an_index_is_kept_where_it_was_asked_for() {
    let mut named = String::from("t,sin,cos,index,name\n");
    for (row, [t_s, sine, cosine, _]) in encoder().iter().enumerate() {
        let level = ["0.1", "3.2", ""][row % 3];
        named += &format!("{t_s},{sine},{cosine},{level},a\n");
    }
    let named = named.as_bytes();
    let columns = ["t_s=t:s", "q1s=sin", "q1c=cos"];
    let made = converted(named, &order(&columns)).unwrap();
    assert_eq!(made.recording.samples.logged(), []);
    assert_eq!(made.told.left_aside, ["index", "name"]);
    let with =
        |index: &'static str| converted(named, &order(&[columns.as_slice(), &[index]].concat()));
    let made = with("index=index").unwrap();
    let kept = &made.recording.samples.logged()[0];
    assert_eq!(
        (kept.name.as_str(), &kept.values[..2]),
        ("aux_index", [0.1, 3.2].as_slice())
    );
    assert!(kept.values[2].is_nan());
    let told = made.told.columns.last().unwrap();
    assert_eq!(
        (told.name, told.values, told.range),
        ("aux_index", 2667, [0.1, 3.2])
    );
    let refused = with("index=name").unwrap_err();
    assert!(
        refused.contains("row 2, column name, found \"a\", wanted a number"),
        "{refused}"
    );
    let refused = with("index=index*2").unwrap_err();
    assert!(
        refused.contains("wanted the name of a column alone"),
        "{refused}"
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
