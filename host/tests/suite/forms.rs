//! A recording's form: `courier convert RECORDING OUT`, and what a build without Parquet says.

use crate::common::asked;
use std::path::Path;

fn with_survey() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let survey = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/survey-lateral");
    std::fs::create_dir(folder.path().join("s")).unwrap();
    for name in ["recording.toml", "samples.csv"] {
        std::fs::copy(survey.join(name), folder.path().join("s").join(name)).unwrap();
    }
    folder
}

#[test]
fn a_recording_is_written_again_as_it_is() {
    let folder = with_survey();
    let told = asked(folder.path(), "convert s again").quiet();
    assert!(
        told.contains("a recording of 10016 samples, with t_s, q1s"),
        "{told}"
    );
    for name in ["recording.toml", "samples.csv"] {
        let read = |of: &str| std::fs::read(folder.path().join(of).join(name)).unwrap();
        assert!(read("s") == read("again"), "{name}");
    }
}

#[test]
fn what_cannot_be_done_with_a_recording_is_told_in_a_line() {
    let folder = with_survey();
    for (line, wanted) in [
        (
            "convert s",
            "courier: s: found a recording, wanted where to write it: a folder, or a file whose name ends in .parquet or .mcap",
        ),
        (
            "convert s again --pitch 1mm",
            "courier: s: found options of a log beside a recording, wanted none of them",
        ),
        (
            "convert s again --compact",
            "courier: again: found another form, wanted a file whose name ends in .parquet, which --compact is of",
        ),
        (
            "convert s s",
            "s: found the log in it, wanted another folder for the recording",
        ),
    ] {
        asked(folder.path(), line).refused(&[wanted]);
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

/// The same of MCAP, and a monitor's file.
#[test]
#[cfg(not(feature = "mcap"))]
fn a_build_without_mcap_says_how_to_have_it() {
    let folder = with_survey();
    let wanted =
        "wanted a folder, or a courier with MCAP: `cargo install --path host --features mcap`";
    for line in [
        "convert s a.mcap",
        "convert a.mcap again",
        "replay a.mcap",
        "record a.mcap",
    ] {
        asked(folder.path(), line).refused(&["a.mcap: found the name of an MCAP file", wanted]);
    }
    asked(folder.path(), "monitor --seconds 1 --mcap a.mcap").refused(&["a.mcap: found --mcap, wanted a courier with MCAP: `cargo install --path host --features mcap`"]);
    asked(folder.path(), "monitor --seconds 1 --serve").refused(&[
        "found --serve, wanted a courier with MCAP: `cargo install --path host --features mcap`",
    ]);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

/// Each way in and out of a build without the feature.
#[test]
#[cfg(not(feature = "parquet"))]
fn a_build_without_parquet_says_how_to_have_it() {
    let folder = with_survey();
    for line in [
        "convert s a.parquet",
        "convert s a.parquet --compact",
        "convert a.parquet again",
        "replay a.parquet",
        "diagnose a.parquet",
        "map a.parquet",
        "compare a.parquet a.parquet",
        "encoder a.parquet",
        "record a.parquet",
        "demo --record a.parquet",
    ] {
        asked(folder.path(), line).refused(&["a.parquet: found the name of a Parquet file, wanted a folder, or a courier with Parquet: `cargo install --path host --features parquet`"]);
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}
