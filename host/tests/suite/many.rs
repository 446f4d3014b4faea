//! `courier diagnose A B … --out DIR`: a row a recording, the same however it was ended and resumed.

use crate::common::{Ran, asked};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Stdio};

/// Segment 1 beside a reference, to and fro over eight millimetres, with a wave of so many micrometres.
fn recording(folder: &Path, courier_id: &str, wave_um: f64) {
    std::fs::create_dir(folder).unwrap();
    let meta = format!(
        "schema = 1\ncourier_id = \"{courier_id}\"\n[geometry]\npitch_m = 1e-3\n[electronics]\nposition_noise_m = 1e-7\n"
    );
    std::fs::write(folder.join("recording.toml"), meta).unwrap();
    let mut rows = String::from("t_s,run,p1_m,ref_x_m\n");
    let mut noise = 1_u32;
    for k in 0..1200 {
        let place_m = 4.0e-3 * (1.0 - (0.01 * f64::from(k)).cos());
        noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let error_m = 1.0e-6 * wave_um * (3.0 * std::f64::consts::TAU * place_m / 1.0e-3).sin()
            + 3.0e-7 * (f64::from(noise) / f64::from(u32::MAX) - 0.5);
        let run = k / 300;
        rows += &format!(
            "{:e},r{run},{:e},{place_m:e}\n",
            1.0e-3 * f64::from(k),
            place_m + error_m
        );
    }
    std::fs::write(folder.join("samples.csv"), rows).unwrap();
}

/// Six recordings; two of them cannot be read.
fn fleet() -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    for (name, courier_id, wave_um) in [
        ("a", "7", 0.0),
        ("b", "7", 2.0),
        ("c", "8", 0.5),
        ("d", "", 1.0),
    ] {
        recording(&folder.path().join(name), courier_id, wave_um);
    }
    recording(&folder.path().join("e"), "8", 1.0);
    std::fs::write(folder.path().join("e/samples.csv"), "t_s,p1_m\n0,1\n0,1\n").unwrap();
    (folder, "a b c d e f".to_owned())
}

/// Every row by its recording.
fn rows(table: &Path) -> BTreeMap<String, Value> {
    let files = |folder: &Path| -> Vec<_> {
        std::fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().path())
            .collect()
    };
    let parts = files(table)
        .into_iter()
        .flat_map(|partition| files(&partition));
    let parts = parts.filter(|file| file.extension().is_some_and(|ending| ending == "jsonl"));
    let mut rows = BTreeMap::new();
    for part in parts {
        let row: Value = serde_json::from_str(&std::fs::read_to_string(part).unwrap()).unwrap();
        let before = rows.insert(row["recording"].as_str().unwrap().to_owned(), row);
        assert_eq!(before, None, "two rows of one recording");
    }
    rows
}

fn diagnosed(folder: &Path, recordings: &str, table: &str) -> Ran {
    asked(
        folder,
        &format!("diagnose {recordings} --out {table} --json"),
    )
}

#[test]
fn each_recording_has_a_row_and_a_failure_is_one() {
    let (folder, all) = fleet();
    let at = folder.path();
    let done = diagnosed(at, &all, "t").json();
    assert_eq!(done["recordings"], 6);
    assert_eq!(done["verdicts"]["failed"], 2);
    let rows = rows(&at.join("t"));
    assert_eq!(
        rows.keys().collect::<Vec<_>>(),
        ["a", "b", "c", "d", "e", "f"]
    );
    // As the command says of the one alone.
    let alone = asked(at, "diagnose b --json").json();
    assert_eq!(rows["b"]["verdict"], alone["verdict"]);
    assert_eq!(
        serde_json::from_str::<Value>(rows["b"]["answer"].as_str().unwrap()).unwrap(),
        alone
    );
    assert_eq!(rows["b"]["samples"], 1200);
    assert!(
        rows["b"]["gap_m"].as_f64().unwrap() > 1.0e-6,
        "{}",
        rows["b"]
    );
    assert_eq!(rows["a"]["verdict"], "no_gap");
    assert_eq!(
        rows["e"]["error"],
        "e/samples.csv: row 3, column t_s, found \"0\", wanted a time after the row before, 0 s"
    );
    assert_eq!(
        rows["f"]["error"],
        "f: found no such file, wanted a folder with recording.toml and samples.csv"
    );
    for partition in [
        "courier_id=7",
        "courier_id=8",
        "courier_id=__HIVE_DEFAULT_PARTITION__",
    ] {
        assert!(at.join("t").join(partition).is_dir(), "{partition}");
    }
    // All rows have the same columns.
    let names = |row: &Value| row.as_object().unwrap().keys().cloned().collect::<Vec<_>>();
    assert!(rows.values().all(|row| names(row) == names(&rows["a"])));
}

#[test]
fn what_is_there_stays_and_what_has_changed_is_done_again() {
    let (folder, all) = fleet();
    let at = folder.path();
    // Two programs that fill one table.
    diagnosed(at, "a b c", "t").json();
    diagnosed(at, "d e f", "t").json();
    let again = diagnosed(at, &all, "t").json();
    assert_eq!(
        (&again["already"], &again["verdicts"]),
        (&Value::from(6), &serde_json::json!({}))
    );
    // One is mended, of one the courier is another.
    let (mended, other) = (at.join("e"), at.join("a"));
    std::fs::remove_dir_all(&mended).unwrap();
    recording(&mended, "8", 0.0);
    std::fs::remove_dir_all(&other).unwrap();
    recording(&other, "9", 0.0);
    let again = diagnosed(at, &all, "t").json();
    assert_eq!(again["already"], 4);
    assert_eq!(again["verdicts"], serde_json::json!({"no_gap": 2}));
    let rows = rows(&at.join("t"));
    assert_eq!(rows.len(), 6);
    assert_eq!(rows["e"]["error"], Value::Null);
    // Another catalogue is another question.
    let without = asked(at, "diagnose a --out t --without velocity_lag --json").json();
    assert_eq!(without["already"], 0);
}

#[test]
fn killed_at_any_point_and_resumed_the_table_is_the_same() {
    let (folder, all) = fleet();
    let at = folder.path();
    diagnosed(at, &all, "whole").json();
    let count = |table: &Path| match table.is_dir() {
        true => rows_there(table),
        false => 0,
    };
    // Killed once so many rows are there; the last time it may have ended by itself.
    for wanted in 0..6 {
        let mut words = vec!["diagnose"];
        words.extend(all.split(' '));
        words.extend(["--out", "cut", "--jobs", "1"]);
        let mut child = Command::new(env!("CARGO_BIN_EXE_courier"))
            .args(words)
            .current_dir(at)
            .stdout(Stdio::null())
            .spawn()
            .unwrap();
        while count(&at.join("cut")) <= wanted && child.try_wait().unwrap().is_none() {
            std::thread::yield_now();
        }
        child.kill().unwrap();
        child.wait().unwrap();
    }
    diagnosed(at, &all, "cut").json();
    assert_eq!(rows(&at.join("cut")), rows(&at.join("whole")));
}

/// Row for row as if nothing had been there: what is known by its content is not diagnosed again.
#[test]
fn what_was_renamed_or_copied_keeps_its_answer_under_its_own_name() {
    let (folder, all) = fleet();
    let at = folder.path();
    let in_table = |name: &str| rows(&at.join(name));
    let done = |words: &str, table: &str| {
        let done = diagnosed(at, words, table).json();
        let counts = ["already", "taken_over"].map(|count| done[count].as_u64().unwrap());
        (counts, done["verdicts"].clone())
    };
    let copied = |from: &str, to: &str| {
        std::fs::create_dir(at.join(to)).unwrap();
        for file in ["recording.toml", "samples.csv"] {
            std::fs::copy(at.join(from).join(file), at.join(to).join(file)).unwrap();
        }
    };
    done(&all, "t");
    // Both paths are there: two rows. What failed says so of its new path.
    copied("a", "a2");
    std::fs::rename(at.join("b"), at.join("b2")).unwrap();
    std::fs::rename(at.join("e"), at.join("e2")).unwrap();
    let all = "a a2 b2 c d e2 f";
    let failed = serde_json::json!({"failed": 1});
    assert_eq!(done(all, "t"), ([4, 2], failed));
    assert_eq!(done(all, "t"), ([7, 0], serde_json::json!({})));
    let of_b2 = in_table("t")["b2"]["answer"].as_str().unwrap().to_owned();
    assert!(of_b2.contains("\"recording\":\"b2\""), "{of_b2}");
    // In one run as well, where one comes after the other.
    let whole = asked(at, &format!("diagnose {all} --out whole --jobs 1 --json")).json();
    assert_eq!(
        (&whole["already"], &whole["taken_over"]),
        (&Value::from(0), &Value::from(1))
    );
    assert_eq!(in_table("t"), in_table("whole"));
    // Killed when the new row was written and the old one not yet taken away.
    copied("b2", "b3");
    assert_eq!(done("b3", "t"), ([0, 1], serde_json::json!({})));
    std::fs::remove_dir_all(at.join("b2")).unwrap();
    assert_eq!(
        done("a a2 b3 c d e2 f", "t"),
        ([7, 0], serde_json::json!({}))
    );
    assert_eq!(
        in_table("t").keys().collect::<Vec<_>>(),
        ["a", "a2", "b3", "c", "d", "e2", "f"]
    );
    // Other options, another answer.
    let without = asked(at, "diagnose a --out t --without velocity_lag --json").json();
    assert_eq!(without["taken_over"], 0);
}

/// Files of the table that are whole.
fn rows_there(table: &Path) -> usize {
    let partitions = std::fs::read_dir(table).into_iter().flatten().flatten();
    let files = partitions.flat_map(|partition| {
        std::fs::read_dir(partition.path())
            .into_iter()
            .flatten()
            .flatten()
    });
    files
        .filter(|file| file.file_name().to_string_lossy().ends_with(".jsonl"))
        .count()
}

#[test]
fn what_makes_no_table_is_refused() {
    let (folder, _) = fleet();
    let at = folder.path();
    std::fs::write(at.join("file"), "mine").unwrap();
    asked(at, "diagnose a b").refused(&["--out"]);
    asked(at, "diagnose a --out file").refused(&["file: found a file, wanted a folder"]);
    asked(at, "diagnose a b --out t --report r.html").refused(&["--report"]);
    asked(at, "diagnose a --jobs 2").refused(&["--out"]);
    asked(at, "diagnose a --out t --json=t/told.json").refused(&["t/told.json"]);
}
