//! What is read.

use super::{META, folder, read};
use recording::{Column, Recording};
use std::path::Path;

#[test]
fn columns_in_any_order_and_empty_fields() {
    let recording = read(
        META,
        b"\xef\xbb\xbfq1c, n1 ,t_s,extra,run,q1s\r\n-5,7,0.5,x,there,32767\r\n,,1.5,,back,\r\n",
    )
    .unwrap();
    let samples = &recording.samples;
    assert_eq!(samples.len(), 2);
    assert_eq!(samples.quadrature_counts(0, 0), Some([32767.0, -5.0]));
    assert_eq!((samples.teeth(0, 0), samples.teeth(0, 1)), (Some(7), None));
    assert_eq!((samples.run(0), samples.run(1)), ("there", "back"));
    assert_eq!(samples.unmodified_m(0, 1, 1e-3), None);
    assert!((samples.unmodified_m(0, 0, 1e-3).unwrap() - 7.25e-3).abs() < 1e-7);
    assert!(!samples.has(Column::Temperature));
    assert_eq!(
        recording.warnings,
        ["samples.csv: column \"extra\" is not known and is left aside"]
    );
}

#[test]
fn an_unknown_key_is_a_warning() {
    let recording = read(
        &META.replace("schema = 1\n", "schema = 1\nowner = 3\n"),
        b"t_s,p1_m\n0,1e-3\n",
    )
    .unwrap();
    assert_eq!(
        recording.warnings,
        ["recording.toml: key owner is not known and is left aside"]
    );
}

#[test]
fn what_is_no_folder() {
    let folder = folder(META.as_bytes(), b"t_s,p1_m\n0,0\n");
    let error = |path: &Path| Recording::read(path).unwrap_err();
    assert_eq!(error(&folder.path().join("none")).found, "no such file");
    assert_eq!(error(&folder.path().join("samples.csv")).found, "a file");
    std::fs::remove_file(folder.path().join("samples.csv")).unwrap();
    assert_eq!(error(folder.path()).file, folder.path().join("samples.csv"));
    std::fs::create_dir(folder.path().join("samples.csv")).unwrap();
    assert_eq!(error(folder.path()).found, "no regular file");
    std::fs::remove_file(folder.path().join("recording.toml")).unwrap();
    assert_eq!(
        error(folder.path()).file,
        folder.path().join("recording.toml")
    );
}

#[test]
fn a_million_rows() {
    use std::fmt::Write as _;
    let mut text = String::from("t_s,run,p1_m,ref_x_m\n");
    for index in 0..1_000_000 {
        writeln!(text, "{}.{:03},a,0.0001,0.0002", index / 1000, index % 1000).unwrap();
    }
    let recording = read(META, text.as_bytes()).unwrap();
    assert_eq!(recording.samples.len(), 1_000_000);
    assert_eq!(recording.samples.stretches().len(), 1);
}

/// The real recordings are not part of the project: they are looked for in `$COURIER_SHARED/data` or `../shared/data`.
#[test]
fn real_recordings() {
    let shared = std::env::var_os("COURIER_SHARED").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared"),
        std::path::PathBuf::from,
    );
    for (name, rows) in [
        ("ess-rotary-normal", 4535),
        ("ess-rotary-drive-divided", 3935),
    ] {
        let path = shared.join("data").join(name);
        if !path.exists() {
            eprintln!(
                "SKIPPED: no recording at {}; set COURIER_SHARED to the folder that holds data/",
                path.display()
            );
            continue;
        }
        let recording = Recording::read(&path).unwrap();
        assert_eq!(
            (recording.samples.len(), recording.warnings.len()),
            (rows, 0)
        );
        assert!(recording.samples.has(Column::Reference(0)) && recording.samples.has_segment(0));
        println!("{name}: {} stretches", recording.samples.stretches().len());
    }
}
