//! What the model of the chip has to say in `cargo xtask bench --json`.

use super::mutate::{self, Score};
use super::{build, prepare};
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
    prepare()?;
    let arm = arm::ensure()?;
    let image = firmware::build(&arm, "g474")?;
    let model = build()?;
    let mut object = Map::new();
    for (check, keys) in MEASURED {
        let figures = output(Command::new(&model).arg(&image).args([check, "--json"]))
            .and_then(|said| last_object(&said))
            .inspect_err(|why| {
                say(&format!(
                    "what the check {check} measures is not known: {why:#}"
                ))
            })
            .unwrap_or_default();
        for key in keys {
            let value = figures.get(*key).cloned().unwrap_or(Value::Null);
            object.insert((*key).to_owned(), value);
        }
    }
    let Score { tried, caught } = mutate::score(&arm, &model)?;
    object.insert("mutations".into(), json!(tried));
    object.insert("mutations_caught".into(), json!(caught));
    Ok(Value::Object(object))
}

/// The object on the last line of what a program said.
fn last_object(said: &str) -> Result<Map<String, Value>> {
    let last = said.lines().last().unwrap_or_default();
    serde_json::from_str(last).with_context(|| format!("found {last:?}, wanted a JSON object"))
}

#[cfg(test)]
mod tests {
    use super::last_object;

    #[test]
    fn the_last_line_counts_and_must_be_an_object() {
        let said = "chip: time: 1200 cycles\n{\"rate_max_hz\": 60000}\n";
        let object = last_object(said).expect("an object");
        assert_eq!(object["rate_max_hz"], 60_000);
        assert!(last_object("chip: time: 1200 cycles\n").is_err());
        assert!(last_object("").is_err());
    }
}
