//! `diagnose`, `check`, `blind` and `load` end to end, on simulated couriers.

use crate::common::{asked, courier_in, json, json_in};
use serde_json::Value;

/// The steps one by one: the hash is printed first, the answers are where they are said to be, and the scores add up.
#[test]
fn a_blind_check_step_by_step() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let written = courier_in(
        at,
        &["blind", "write", "cases", "--cases", "2", "--seed", "12"],
    );
    assert_eq!(written.code, 0, "{}", written.err);
    let seal = std::fs::read_to_string(at.join("cases/seal.txt")).unwrap();
    assert!(written.err.contains(seal.trim()));
    for case in 0..2 {
        // Nothing in the recordings tells the answer.
        let meta = std::fs::read_to_string(
            at.join(format!("cases/recordings/case_00{case}/recording.toml")),
        )
        .unwrap();
        assert!(!meta.contains("seed"), "{meta}");
    }
    // The diagnosis must do without the answers.
    let answers = at.join("cases/answers.json");
    let aside = at.join("aside.json");
    std::fs::rename(&answers, &aside).unwrap();
    assert_eq!(courier_in(at, &["blind", "diagnose", "cases"]).code, 0);
    std::fs::rename(&aside, &answers).unwrap();
    let words = "blind score cases --quick --json score.json --report score.html";
    let scored = asked(at, words);
    assert_eq!(scored.code, 0, "{}", scored.err);
    assert!(scored.out.lines().count() <= 80, "{}", scored.out);
    for told in [
        "false alarm",
        "wrong culprit",
        "rightly located",
        "in every channel",
        "answered",
        "gap seen",
        "right, by rms",
    ] {
        assert!(scored.out.contains(told), "{told}: {}", scored.out);
    }
    let score = json_in(at.join("score.json"));
    assert_eq!(score["seal"].as_str().unwrap(), seal.trim());
    adds_up(&score);
    assert!(
        std::fs::read_to_string(at.join("score.html"))
            .unwrap()
            .contains("<svg")
    );
    let mut changed = std::fs::read_to_string(&answers).unwrap();
    changed.push(' ');
    std::fs::write(&answers, changed).unwrap();
    courier_in(at, &["blind", "score", "cases"]).refused(&["answers.json", "hash", seal.trim()]);
    courier_in(at, &["blind", "write", "cases"]).refused(&["cases", "empty"]);
}

/// The scores of two cases count each of them once.
fn adds_up(score: &Value) {
    assert_eq!(score["judged"].as_array().unwrap().len(), 2);
    // Every case with one effect is in the table of its effect, in the class of its size.
    let classed: u64 = score["effects"]
        .as_object()
        .unwrap()
        .values()
        .flat_map(|classes| classes.as_array().unwrap())
        .map(|class| class["cases"].as_u64().unwrap())
        .sum();
    let alone = score["judged"].as_array().unwrap().iter();
    let alone = alone.filter(|j| j["case"]["effects"].as_array().unwrap().len() == 1);
    assert_eq!(classed as usize, alone.count());
    let counted: u64 = score["figures"].as_array().unwrap()[..4]
        .iter()
        .map(|f| f["of"].as_u64().unwrap())
        .sum();
    assert_eq!(counted, 2);
    // Every named cause is in the table of its probability.
    let judged = score["judged"].as_array().unwrap().iter();
    let named: usize = judged.map(|j| j["named"].as_array().unwrap().len()).sum();
    let reliability = &score["reliability"];
    let tenths = reliability["tenths"].as_array().unwrap().iter();
    let classed: u64 = tenths.map(|t| t["named"].as_u64().unwrap()).sum();
    assert_eq!(
        [named as u64, reliability["named"].as_u64().unwrap()],
        [classed; 2]
    );
    // A wrong culprit is worse than none, and an alarm for nothing is one.
    for one in score["judged"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|one| one["case"]["kind"] == "none")
    {
        assert_eq!(one["verdict"], "no_gap", "{one}");
    }
}

/// A model goes to a file, is confirmed on a second recording, and is refused where it is none.
#[test]
fn a_diagnosis_is_written_reported_and_checked() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    assert_eq!(
        courier_in(
            at,
            &["blind", "write", "cases", "--cases", "1", "--seed", "4"]
        )
        .code,
        0
    );
    let first = "cases/recordings/case_000";
    let ran = courier_in(
        at,
        &[
            "diagnose", first, "--json", "d.json", "--model", "m.json", "--report", "r.html",
        ],
    );
    assert_eq!(ran.code, 0, "{}", ran.err);
    assert!(ran.out.lines().count() <= 40, "{}", ran.out);
    let diagnosis = json_in(at.join("d.json"));
    for key in [
        "schema",
        "recording",
        "verdict",
        "gap",
        "where",
        "effects",
        "held_out",
        "unexplained",
    ] {
        assert!(diagnosis.get(key).is_some(), "{key}");
    }
    let printed = courier_in(at, &["diagnose", first, "--json", "-"]);
    assert_eq!(json(&printed.out), diagnosis);
    let page = std::fs::read_to_string(at.join("r.html")).unwrap();
    assert!(
        page.contains("<svg") && !page.contains("src=") && !page.contains("http-equiv=\"refresh")
    );
    let checked = courier_in(
        at,
        &[
            "check",
            "m.json",
            "cases/second/case_000",
            "--json",
            "c.json",
        ],
    );
    assert_eq!(checked.code, 0, "{}", checked.err);
    let check = json_in(at.join("c.json"));
    let mut keys: Vec<&String> = check.as_object().unwrap().keys().collect();
    keys.sort();
    assert_eq!(
        keys,
        ["confirmation", "held_out", "model", "recording", "schema"]
    );
    let confirmation = &check["confirmation"];
    let sure = confirmation["probability"].as_f64().unwrap();
    assert_eq!(confirmation["confirmed"].as_bool().unwrap(), sure >= 0.5);
    let first_line = checked.out.lines().next().unwrap();
    assert!(
        first_line.contains("confirmed: ") && first_line.contains("claimed"),
        "{first_line}"
    );
    courier_in(at, &["check", "d.json", first]).refused(&["d.json", "model"]);
    courier_in(at, &["load", "d.json"]).refused(&["d.json", "model"]);
    courier_in(at, &["load", "nowhere.json"]).refused(&["nowhere.json"]);
    courier_in(at, &["diagnose", first, "--without", "gremlins"]).refused(&[
        "gremlins",
        "adc_clipping",
        "span_error",
    ]);
    courier_in(at, &["diagnose", "nowhere"]).refused(&["nowhere"]);
    courier_in(
        at,
        &["diagnose", first, "--report", "no/such/folder/r.html"],
    )
    .refused(&["no/such/folder/r.html"]);
    courier_in(at, &["blind", "diagnose", "nowhere"]).refused(&["nowhere"]);
    courier_in(at, &["blind", "--cases", "0"]).refused(&["--cases", "0"]);
}
