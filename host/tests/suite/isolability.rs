//! `courier isolability`: what it tells of the paper's motions, and what it refuses.

use crate::common::{courier, entry};
use serde_json::Value;

fn told(options: &[&str]) -> Value {
    courier(&[&["isolability", "--json"], options].concat()).json()
}

/// Of a group against all others: its first entry.
fn angle(answer: &Value, group: &str) -> f64 {
    let found = entry(answer, "angles", "group", group);
    found["angle_deg"].as_f64().unwrap()
}

/// Lateral terms from g_p alone at ±0.5°: 0.1° to 0.6° from the rest, and what would part them is named.
#[test]
fn the_papers_failure_is_foretold_and_explained() {
    let answer = told(&[]);
    for key in [
        "motion",
        "condition_number",
        "undetermined_directions",
        "gauge",
        "parameters",
        "angles",
        "remedies",
    ] {
        assert!(
            !answer[key].is_null() || key == "condition_number",
            "{key}: {answer}"
        );
    }
    assert!(angle(&answer, "lateral terms") < 1.0, "{answer}");
    let remedies = answer["remedies"].as_array().unwrap();
    assert!(
        remedies
            .iter()
            .any(|remedy| remedy["group"] == "lateral terms"),
        "{answer}"
    );
    let parameter = &answer["parameters"][0];
    for key in ["name", "unit", "deviation_with_prior", "prior", "rests_on"] {
        assert!(!parameter[key].is_null(), "{key}: {parameter}");
    }
}

#[test]
fn under_a_beacon_everything_is_told_apart() {
    let answer = told(&["--beacon"]);
    assert_eq!(answer["undetermined_directions"], 0);
    assert!(angle(&answer, "lateral terms") > 10.0, "{answer}");
    // 1000 random poses are the reference; the chosen ones need fewer, but no plan a third.
    let chosen = told(&["--beacon", "--plan", "optimal", "--poses", "333"]);
    let poses = |answer: &Value| answer["needed"]["poses"].as_u64().unwrap();
    let least = chosen["needed"]["least_of_any_motion"].as_u64().unwrap();
    assert_eq!(poses(&answer), 1000);
    assert!(
        (333..400).contains(&least) && least < poses(&chosen),
        "{chosen}"
    );
    assert!((800..900).contains(&poses(&chosen)), "{chosen}");
    let still = told(&["--beacon", "--turn-deg", "0"]);
    assert!(
        still["undetermined_directions"].as_u64().unwrap() > 0,
        "{still}"
    );
}

#[test]
fn wrong_options_are_one_line() {
    let cases: [(&[&str], &str); 6] = [
        (&["--plan", "best"], "best"),
        (&["--poses", "0"], "1..=20000"),
        (
            &["--turn-deg", "90"],
            "--turn-deg: found 90, wanted 0 to 2.8",
        ),
        (&["--travel", "nan"], "--travel: found NaN"),
        (&["--noise-um", "0"], "--noise-um: found 0"),
        (&["--sim"], "needs no board"),
    ];
    for (options, wanted) in cases {
        courier(&[&["isolability"], options].concat()).refused(&[wanted]);
    }
}
