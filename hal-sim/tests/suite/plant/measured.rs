//! The `measured` preset: a file of real waveforms, or a named error. Reads the shared data where they are; elsewhere says
//! so and tests only what needs none.

use hal_sim::courier::Courier;
use hal_sim::presets::{DEFAULT_RMS_M, MeasuredWaveforms, measured};
use std::io::Write;

fn written(text: &str) -> tempfile::NamedTempFile {
    let mut file = tempfile::NamedTempFile::new().unwrap();
    file.write_all(text.as_bytes()).unwrap();
    file
}

#[test]
fn bad_files_are_named_with_row_and_column() {
    let rows = |bad: &str| {
        let mut text = String::from("code,a,b\n");
        (0..20).for_each(|i| {
            text += &format!(
                "{i},{},{}\n",
                (f64::from(i) * 0.3).sin(),
                if i == 7 { bad } else { "1" }
            )
        });
        written(&text)
    };
    let message = |file: &tempfile::NamedTempFile| {
        measured(Some(file.path()), DEFAULT_RMS_M, 1)
            .err()
            .unwrap()
            .to_string()
    };
    let not_a_number = message(&rows("x"));
    assert!(
        not_a_number.contains("row 9, column `b`: found `x`"),
        "{not_a_number}"
    );
    assert!(message(&rows("nan")).contains("found `nan`"));
    assert!(message(&rows("1")).contains("column `b`: all values are equal"));
    assert!(message(&written("code,a\n0,1\n1,2\n")).contains("2 rows of 1 waveforms"));
    let ragged = message(&written("code,a,b\n0,1\n"));
    assert!(
        ragged.contains("record") && !ragged.contains('\n'),
        "{ragged}"
    );
    assert!(
        measured(Some("nowhere.csv".as_ref()), DEFAULT_RMS_M, 1)
            .err()
            .unwrap()
            .to_string()
            .contains("nowhere.csv")
    );
    let good = rows("2");
    assert!(measured(Some(good.path()), f64::NAN, 1).is_err());
    assert!(measured(Some(good.path()), DEFAULT_RMS_M, 1).is_ok());
}

#[test]
fn every_measured_waveform_makes_a_courier_at_the_stated_rms() {
    let path = MeasuredWaveforms::default_path();
    let Ok(file) = MeasuredWaveforms::read(&path) else {
        eprintln!("SKIPPED: {} is absent; set COURIER_SHARED", path.display());
        return;
    };
    assert_eq!(file.waveforms.len(), 61);
    let mut refused = Vec::new();
    for seed in 0..60 {
        let spec = file.courier(DEFAULT_RMS_M, seed).unwrap();
        for waveform in &spec.waveforms {
            assert!((waveform.rms_m() / DEFAULT_RMS_M - 1.0).abs() < 0.01);
        }
        if let Err(reason) = Courier::new(spec, seed) {
            refused.push(reason.to_string());
        }
    }
    assert!(refused.is_empty(), "{} of 60: {refused:?}", refused.len());
}
