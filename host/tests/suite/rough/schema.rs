//! The shape of `diagnose --json`: every key of the published layout with its type, and no further one but `notes` and what may be
//! told of sizes (an amount's `deviation`, an effect's `total_rms_m` and `total_deviation_m`) and of the geometry (`geometry`, `findings`).

use serde_json::{Value, json};

/// An example of each shape: a list holds one example of its entries, a pair of numbers stands for itself, null for a text or null.
fn shape() -> Value {
    let place = json!([{ "channel": "", "coordinate": "", "share": 0.0 }]);
    json!({
        "schema": 1, "recording": "", "verdict": "",
        "gap": [{ "channel": "", "samples": 0, "real_rms_m": 0.0, "simulated_rms_m": 0.0, "excess_rms_m": 0.0, "excess_ci95_m": [0.0, 0.0] }],
        "where": place,
        "effects": [{ "name": "", "probability": 0.0, "aliases": [""], "break_alias": null,
            "magnitude": [{ "name": "", "value": 0.0, "unit": "" }], "share": 0.0, "gap_after_alone_m": 0.0 }],
        "held_out": { "whitened_before": 0.0, "whitened_after": 0.0,
            "channels": [{ "channel": "", "before_rms_m": 0.0, "after_rms_m": 0.0, "after_ci95_m": [0.0, 0.0], "floor_rms_m": 0.0 }] },
        "unexplained": { "share": 0.0, "where": place },
    })
}

/// The answer must have that shape.
pub fn check(answer: &Value) {
    let mut answer = answer.clone();
    if let Some(notes) = answer.as_object_mut().unwrap().remove("notes") {
        assert!(notes.as_array().unwrap().iter().all(Value::is_string));
    }
    if let Some(geometry) = answer.as_object_mut().unwrap().remove("geometry") {
        for fitted in geometry.as_array().unwrap() {
            assert!(fitted["name"].is_string(), "{fitted}");
            assert!(
                ["stated_m", "found_m", "error_m"]
                    .iter()
                    .all(|key| fitted[key].is_f64()),
                "{fitted}"
            );
        }
    }
    if let Some(findings) = answer.as_object_mut().unwrap().remove("findings") {
        let told = |finding: &Value| finding["sentence"].is_string();
        assert!(findings.as_array().unwrap().iter().all(told), "{findings}");
    }
    for effect in answer["effects"].as_array_mut().unwrap() {
        take_numbers(effect, &["total_rms_m", "total_deviation_m"]);
        for amount in effect["magnitude"].as_array_mut().unwrap() {
            take_numbers(amount, &["deviation"]);
        }
    }
    compare("answer", &answer, &shape());
    let verdict = answer["verdict"].as_str().unwrap();
    let empty = |key: &str| answer[key].as_array().unwrap().is_empty();
    assert_eq!(
        empty("effects"),
        !["named", "alias"].contains(&verdict),
        "{answer}"
    );
    assert_eq!(answer["schema"], 1);
}

/// Takes out keys that may be there; those that are hold sizes.
fn take_numbers(object: &mut Value, keys: &[&str]) {
    for key in keys {
        if let Some(value) = object.as_object_mut().unwrap().remove(*key) {
            assert!(value.as_f64().is_some_and(|v| v >= 0.0), "{key}: {value}");
        }
    }
}

fn compare(at: &str, found: &Value, wanted: &Value) {
    match (found, wanted) {
        (Value::Object(found), Value::Object(wanted)) => {
            let keys = |of: &serde_json::Map<String, Value>| of.keys().cloned().collect::<Vec<_>>();
            let (mut here, mut there) = (keys(found), keys(wanted));
            here.sort();
            there.sort();
            assert_eq!(here, there, "{at}");
            for (key, value) in found {
                compare(&format!("{at}.{key}"), value, &wanted[key]);
            }
        }
        (Value::Array(found), Value::Array(wanted)) => {
            let pair = wanted.len() == 2;
            assert!(!pair || found.len() == 2, "{at}: {found:?}");
            for value in found {
                compare(at, value, &wanted[0]);
            }
        }
        (found, Value::Null) => assert!(found.is_null() || found.is_string(), "{at}: {found}"),
        (found, Value::Number(_)) => {
            assert!(found.as_f64().is_some_and(f64::is_finite), "{at}: {found}")
        }
        (found, Value::String(_)) => assert!(found.is_string(), "{at}: {found}"),
        _ => panic!("{at}: {found}"),
    }
}
