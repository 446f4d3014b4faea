//! What the model of the chip has to say in `cargo xtask bench --json`.

use super::mutate::{self, Score};
use super::{build, prepare};
use crate::arm::{self, output, say};
use crate::firmware;
use anyhow::{Context, Result};
use serde_json::{Map, Value, json};
use std::process::Command;

/// Keys of what the check `time` measures.
const TIMES: [&str; 5] = [
    "sample_cycles_worst",
    "sample_mapped_cycles_worst",
    "rate_max_hz",
    "frames_not_taken_up",
    "terms_beside_map",
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
    let times = output(Command::new(&model).arg(&image).args(["time", "--json"]))
        .and_then(|said| last_object(&said))
        .inspect_err(|why| say(&format!("the times on the model are not known: {why:#}")))
        .unwrap_or_default();
    let Score { tried, caught } = mutate::score(&arm, &model)?;
    let mut object: Map<String, Value> = TIMES
        .iter()
        .map(|key| {
            (
                (*key).to_owned(),
                times.get(*key).cloned().unwrap_or(Value::Null),
            )
        })
        .collect();
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
