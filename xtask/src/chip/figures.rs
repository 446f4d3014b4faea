//! What the model of the chip has to say in `cargo xtask bench --json`.

use super::model;
use super::mutate::{self, Tools};
use super::score::Score;
use crate::arm::{self, output, say};
use crate::firmware;
use anyhow::{Context, Result};
use serde_json::{Map, Value, json};
use std::process::Command;

/// Checks that measure, and the keys of what they do. `stream` takes a minute of the board's, three of this machine's.
const MEASURED: [(&str, &[&str]); 2] = [
    (
        "time",
        &[
            "sample_cycles_worst",
            "sample_mapped_cycles_worst",
            "rate_max_hz",
            "terms_beside_map",
        ],
    ),
    ("stream", &["frames_not_taken_up"]),
];

/// The object `chip`: what is not measured is null.
///
/// # Errors
/// The image or the model cannot be built.
pub fn json() -> Result<Value> {
    model::prepare()?;
    let arm = arm::ensure()?;
    let image = firmware::build(&arm, "g474")?;
    let program = model::build()?;
    let measured = MEASURED.map(|(check, _)| {
        output(Command::new(&program).arg(&image).args([check, "--json"]))
            .and_then(|said| last_object(&said))
            .inspect_err(|why| {
                say(&format!(
                    "what the check {check} measures is not known: {why:#}"
                ))
            })
            .unwrap_or_default()
    });
    let tools = Tools {
        arm: &arm,
        model: &program,
    };
    Ok(object(&measured, mutate::score(tools)?))
}

/// What the checks measured, by their keys, and the score of the mutations.
fn object(measured: &[Map<String, Value>; MEASURED.len()], score: Score) -> Value {
    let mut object = Map::new();
    for ((_, keys), figures) in MEASURED.iter().zip(measured) {
        for key in *keys {
            let value = figures.get(*key).cloned().unwrap_or(Value::Null);
            object.insert((*key).to_owned(), value);
        }
    }
    let Score { tried, caught } = score;
    object.insert("mutations".into(), json!(tried));
    object.insert("mutations_caught".into(), json!(caught));
    Value::Object(object)
}

/// The object on the last line of what a program said.
fn last_object(said: &str) -> Result<Map<String, Value>> {
    let last = said.lines().last().unwrap_or_default();
    serde_json::from_str(last).with_context(|| format!("found {last:?}, wanted a JSON object"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_figure_has_its_key_and_what_is_not_measured_is_null() {
        let time = last_object("{\"sample_cycles_worst\": 1464, \"terms_beside_map\": 8}");
        let measured = [time.expect("an object"), Map::new()];
        let score = Score {
            tried: 26,
            caught: 25,
        };
        let found = object(&measured, score);
        let wanted = json!({
            "sample_cycles_worst": 1464,
            "sample_mapped_cycles_worst": null,
            "rate_max_hz": null,
            "terms_beside_map": 8,
            "frames_not_taken_up": null,
            "mutations": 26,
            "mutations_caught": 25,
        });
        assert_eq!(found, wanted);
    }

    #[test]
    fn the_last_line_counts_and_must_be_an_object() {
        let said = "chip: time: 1200 cycles\n{\"rate_max_hz\": 60000}\n";
        let object = last_object(said).expect("an object");
        assert_eq!(object["rate_max_hz"], 60_000);
        assert!(last_object("chip: time: 1200 cycles\n").is_err());
        assert!(last_object("").is_err());
    }
}
