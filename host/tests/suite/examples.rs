//! What a stranger does first, with the data in `examples/`.

use crate::common::{asked, courier_in, json_in};
use std::path::{Path, PathBuf};

fn examples() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples")
}

/// The options of the example's log, as examples/README.md has them.
const COLUMNS: &str = "--column t_s=time:ms --column q1s=sin --column q1c=cos --column ref_x_m=stage:mm --column temp_c=board:C --pitch 1.016mm";

/// Three commands, without an error: a log becomes a recording, a calibrated residual, and a named cause.
#[test]
fn from_a_log_to_a_diagnosis_in_three_commands() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let log = examples().join("encoder-log/log.csv");
    std::fs::copy(&log, at.join("log.csv")).unwrap();
    let made = asked(at, &format!("convert log.csv my-encoder {COLUMNS}")).quiet();
    assert!(
        made.contains("counts rms a channel, measured")
            && made.contains("courier replay my-encoder"),
        "{made}"
    );
    let replayed = asked(at, "replay my-encoder").quiet();
    assert!(replayed.contains("segment_1"), "{replayed}");
    asked(at, "diagnose my-encoder --json answer.json").quiet();
    let answer = json_in(at.join("answer.json"));
    assert_eq!(answer["verdict"], "named", "{answer:#}");
    assert_eq!(answer["effects"][0]["name"], "velocity_lag", "{answer:#}");
    let noise = recording::Recording::read(at.join("my-encoder"))
        .unwrap()
        .meta
        .electronics
        .quadrature_noise_counts
        .unwrap();
    // The simulated board's 20 counts, as its noise is stated.
    assert!((noise / 20.0 - 1.0).abs() < 0.05, "{noise}");
}

/// Without options the log's columns are listed with a command line that begins to fit; nothing is written.
#[test]
fn a_log_without_options_is_listed() {
    let folder = tempfile::tempdir().unwrap();
    let log = examples().join("encoder-log/log.csv");
    let told = courier_in(folder.path(), &["convert", log.to_str().unwrap()]).quiet();
    for part in [
        "stage",
        "highest",
        "--column q1s=sin --column q1c=cos --column ref_x_m=stage:UNIT",
        "--pitch LENGTH",
    ] {
        assert!(told.contains(part), "{part}: {told}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn a_conversion_writes_nothing_that_it_should_not() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    std::fs::copy(examples().join("encoder-log/log.csv"), at.join("log.csv")).unwrap();
    asked(at, &format!("convert log.csv made {COLUMNS} --dry-run")).quiet();
    assert!(!at.join("made").exists());
    for (words, wanted) in [
        (
            "convert log.csv made --column q1s=sinus",
            "no column \"sinus\"",
        ),
        (
            "convert log.csv made --column q9s=sin",
            "no column of a recording",
        ),
        ("convert log.csv made", "nothing for any segment"),
        ("convert none.csv", "none.csv"),
        ("convert log.csv made --pitch 1kg", "a length as in 1.016mm"),
        (
            "convert log.csv made --runs sometimes",
            "rests, reversals, one or column:NAME",
        ),
        ("convert log.csv made --rate-hz 0", "--rate-hz: found 0"),
        ("convert log.csv . --column q1s=sin", "found the log in it"),
    ] {
        asked(at, words).refused(&[wanted]);
    }
    assert!(!at.join("made").exists());
    asked(at, &format!("convert log.csv made {COLUMNS} --runs one")).quiet();
    let first = std::fs::read(at.join("made/samples.csv")).unwrap();
    asked(at, &format!("convert log.csv made {COLUMNS}")).refused(&["--force replaces"]);
    assert_eq!(std::fs::read(at.join("made/samples.csv")).unwrap(), first);
    asked(at, &format!("convert log.csv made {COLUMNS} --force")).quiet();
    assert_ne!(std::fs::read(at.join("made/samples.csv")).unwrap(), first);
}

/// What is in the folder is what the command beside it makes today.
#[test]
fn the_survey_is_as_it_is_made() {
    let folder = tempfile::tempdir().unwrap();
    let page = std::fs::read_to_string(examples().join("README.md")).unwrap();
    let texts = page.split(['`', '\n']);
    let recorded = |text: &&str| text.contains("record survey-lateral");
    let (_, words) = texts
        .into_iter()
        .find(recorded)
        .unwrap()
        .split_once("courier ")
        .unwrap();
    let words: Vec<&str> = words.split_whitespace().collect();
    courier_in(folder.path(), &words).quiet();
    for file in ["recording.toml", "samples.csv"] {
        let [there, made] = [examples(), folder.path().to_owned()]
            .map(|at| std::fs::read(at.join("survey-lateral").join(file)).unwrap());
        assert!(
            there == made,
            "{file} differs: `cargo xtask examples` makes it anew"
        );
    }
}
