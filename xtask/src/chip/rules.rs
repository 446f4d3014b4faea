//! What trips each rule of the model: the mutations that break it, and the model's own tests in a module of its name. A rule that nothing
//! trips is no rule.

use super::model;
use super::mutations::MUTATIONS;
use anyhow::{Result, ensure};
use std::path::Path;

/// A rule, and what trips it.
#[derive(Debug)]
struct Tripped {
    rule: String,
    mutations: Vec<&'static str>,
    tests: Vec<String>,
}

/// Prints them all.
///
/// # Errors
/// A rule that nothing trips, a mutation that names a rule which is none, or the model cannot be asked.
pub fn check(program: &Path) -> Result<()> {
    let rules = model::rules(program)?;
    let strange = MUTATIONS.iter().find(|mutation| {
        let rule = mutation.rule();
        rule.is_some_and(|rule| !rules.iter().any(|known| known == rule))
    });
    if let Some(mutation) = strange {
        anyhow::bail!(
            "{} shows {:?}, which is no rule",
            mutation.name,
            mutation.shows
        );
    }
    let all = tripped(rules, &model::tests_of_rules()?);
    for Tripped {
        rule,
        mutations,
        tests,
    } in &all
    {
        let all = mutations
            .iter()
            .copied()
            .chain(tests.iter().map(String::as_str));
        println!("chip: rule {rule}: {}", all.collect::<Vec<_>>().join(", "));
    }
    judge(&all)
}

fn tripped(rules: Vec<String>, tests: &[String]) -> Vec<Tripped> {
    let of = |rule: String| {
        let module = format!("::{}::", rule.replace('-', "_"));
        let breaks = MUTATIONS.iter().filter(|it| it.rule() == Some(&*rule));
        Tripped {
            mutations: breaks.map(|mutation| mutation.name).collect(),
            tests: tests
                .iter()
                .filter(|test| test.contains(&module))
                .cloned()
                .collect(),
            rule,
        }
    };
    rules.into_iter().map(of).collect()
}

fn judge(all: &[Tripped]) -> Result<()> {
    let nothing = |it: &&Tripped| it.mutations.is_empty() && it.tests.is_empty();
    let idle: Vec<&str> = all.iter().filter(nothing).map(|it| &*it.rule).collect();
    ensure!(
        idle.is_empty(),
        "found rules that no mutation and no test of the model trips: {}",
        idle.join(", ")
    );
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rule_that_nothing_trips_is_told() {
        let rules = ["flash-data-cache", "spi-fifo", "idle"].map(ToOwned::to_owned);
        let tests = ["spi::spi_fifo::a_read".to_owned()];
        let all = tripped(rules.to_vec(), &tests);
        assert_eq!(all[0].mutations, ["1-data-cache"]);
        assert_eq!(all[1].tests, tests);
        assert!(judge(&all[..2]).is_ok());
        assert!(judge(&all).unwrap_err().to_string().ends_with("idle"));
    }
}
