//! `cargo xtask blind`: a blind check of nightly size, its figures held against those that were asked for.

use crate::cargo::cargo;
use anyhow::{Context, Result, ensure};
use std::process::Stdio;

/// Couriers of a night: some 180 with one effect, 80 with two, 80 with an unlisted one, 60 with none.
const CASES: &str = "400";
/// Any would do; a caller may give his own.
const SEED: &str = "20260101";

/// Runs `courier blind` and judges its scores.
///
/// # Errors
/// A figure is not reached, or the check cannot be run.
pub fn run(arguments: &[String]) -> Result<()> {
    let cases = arguments.first().map_or(CASES, String::as_str);
    let seed = arguments.get(1).map_or(SEED, String::as_str);
    ensure!(
        arguments.len() <= 2,
        "found {:?}, wanted at most CASES and SEED",
        arguments[2]
    );
    let mut command = cargo(&[
        "run",
        "--quiet",
        "--release",
        "--package",
        "courier",
        "--",
        "blind",
        "--json",
        "-",
    ]);
    let report = crate::arm::root().join("target/blind.html");
    command
        .args(["--cases", cases, "--seed", seed, "--report"])
        .arg(&report);
    let done = command
        .stderr(Stdio::inherit())
        .output()
        .context("courier blind")?;
    ensure!(done.status.success(), "courier blind: {}", done.status);
    let score: serde_json::Value = serde_json::from_slice(&done.stdout).context("the scores")?;
    let mut missed = judge(&score)?;
    missed.extend(judge_reliability(&score["reliability"])?);
    println!("with plots: {}", report.display());
    ensure!(missed.is_empty(), "not reached: {}", missed.join("; "));
    Ok(())
}

/// Prints every figure and returns those that are not reached.
fn judge(score: &serde_json::Value) -> Result<Vec<String>> {
    let mut missed = Vec::new();
    for figure in score["figures"]
        .as_array()
        .context("no figures in the scores")?
    {
        let name = figure["name"].as_str().context("a figure without a name")?;
        let number = |key: &str| {
            figure[key]
                .as_f64()
                .with_context(|| format!("{name}: no {key}"))
        };
        let (count, of, wanted) = (number("count")?, number("of")?, number("wanted")?);
        let at_least = figure["at_least"]
            .as_bool()
            .with_context(|| format!("{name}: no at_least"))?;
        let share = count / of;
        // Nothing looked at is NaN, which reaches nothing.
        let reached = if at_least {
            share >= wanted
        } else {
            share <= wanted
        };
        let bound = if at_least { "at least" } else { "at most" };
        println!(
            "{name}: {count} of {of}, {:.1} %; {bound} {:.1} % wanted",
            100.0 * share,
            100.0 * wanted
        );
        if !reached {
            missed.push(name.to_owned());
        }
    }
    Ok(missed)
}

/// Prints how far the stated probabilities are off and how good they are, and returns the figure if it is not reached. A deviation that may
/// be chance is told, and is no miss.
fn judge_reliability(of: &serde_json::Value) -> Result<Option<String>> {
    let name = "probability of a cause: largest deviation of a tenth";
    let outcome = of["outcome"]
        .as_str()
        .context("no outcome of the stated probabilities")?;
    let scores = ["log_score", "base_log_score"].map(|key| of[key].as_f64().unwrap_or(f64::NAN));
    println!(
        "{name}: {outcome}; {} of {} causes are true; tenth that deviates most: {}; at most {} wanted",
        of["right"], of["named"], of["worst"], of["wanted"]
    );
    println!(
        "mean log score of the stated probabilities: {:.3}; of the share that is true: {:.3}",
        scores[0], scores[1]
    );
    Ok((!matches!(outcome, "reached" | "too_few_cases")).then(|| name.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn probabilities_that_are_off_beyond_chance_are_missed() {
        let missed = |outcome: &str| {
            judge_reliability(&serde_json::json!({ "outcome": outcome }))
                .unwrap()
                .is_some()
        };
        assert!(missed("not_reached") && missed("not_tried"));
        assert!(!missed("reached") && !missed("too_few_cases"));
        assert!(judge_reliability(&serde_json::json!({})).is_err());
    }

    #[test]
    fn a_figure_that_was_not_looked_at_is_missed() {
        let figure = |count, of, wanted, at_least| serde_json::json!({ "name": "f", "count": count, "of": of, "wanted": wanted, "at_least": at_least });
        let missed = |figure| {
            judge(&serde_json::json!({ "figures": [figure] }))
                .unwrap()
                .len()
        };
        assert_eq!(missed(figure(19, 20, 0.95, true)), 0);
        assert_eq!(missed(figure(18, 20, 0.95, true)), 1);
        assert_eq!(missed(figure(0, 0, 0.01, false)), 1);
    }
}
