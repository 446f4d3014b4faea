//! The accuracy figures: the tests that assert them, run again for what they print.

use crate::arm;
use anyhow::{Context, Result, ensure};
use std::process::Command;

/// Package, test program and the tests of it that print a figure. A further one is a line here.
const SOURCES: &[(&str, &str, &[&str])] = &[
    (
        "courier-sensor",
        "suite",
        &[
            "parameter_errors_agree_with_the_predicted_covariance_over_200_seeds",
            "incremental_f32_agrees_with_batch_f64_on_the_same_rows",
            "one_bad_sample_of_any_size_hardly_moves_the_calibration",
            "optimal_plan_reaches_the_bound_at_half_a_degree_and_a_third_at_one_and_a_half",
            "joint::synthetic::synthetic_problem_of_the_paper",
            "joint::synthetic::lateral_terms",
            "joint::synthetic::device_f32",
            "maps::homing::ten_thousand_starts_find_the_right_teeth",
            "maps::homing::a_beacon_that_was_moved_is_refused",
            "maps::homing::another_platens_teeth_are_told",
            "maps::mark_tries::",
        ],
    ),
    (
        "hal-sim",
        "suite",
        &[
            "figures::",
            "maps::a_map_is_in_force_within_two_seconds",
            "watch::changes::a_change_of_half_a_micrometre",
            "watch::service::twenty_hours",
            "watch::hours::twenty_hours",
            "recalibration::month::a_quarter",
            "recalibration::tries::nothing_that_makes_the_position_worse_comes_in_force_in_ten",
        ],
    ),
    (
        "courier",
        "suite",
        &[
            "replay::real_recordings",
            "replay::four_segments",
            "guided::some_answers",
        ],
    ),
    // The nightly forms, of 1,000 pairs, 1,000 hours and 320 changes, print the same.
    ("comparison", "coverage", &["told_as_often_as_is_said"]),
    ("comparison", "joint", &["tells_its_covariance"]),
    ("comparison", "teeth", &["from_place_to_place"]),
];

/// Runs the tests and prints their figures.
///
/// # Errors
/// A test fails: its figure is not reached; or a name is no test's.
pub fn run() -> Result<()> {
    println!("accuracy figures, each asserted by the test that prints it:");
    for (package, program, names) in SOURCES {
        let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
        command
            .current_dir(arm::root())
            .args(["test", "--profile", "checked"])
            .args(["--package", package, "--test", program, "--"])
            .args(["--nocapture", "--test-threads=1"])
            .args(*names);
        let output = command.output().context("cargo test")?;
        let text = String::from_utf8_lossy(&output.stdout);
        text.lines()
            .filter_map(figure)
            .for_each(|line| println!("  {line}"));
        ensure!(
            output.status.success(),
            "{package}, {program}: a figure is not reached:\n{text}"
        );
        for name in *names {
            ensure!(
                text.lines().any(|line| is_of(line, name)),
                "{package}, {program}: no test is called {name}"
            );
        }
    }
    Ok(())
}

/// Whether the harness begins a test of this name with a line.
fn is_of(line: &str, name: &str) -> bool {
    line.strip_prefix("test ")
        .and_then(|rest| rest.split_once(" ... "))
        .is_some_and(|(test, _)| test.contains(name))
}

/// What a test printed, not what its harness says of it: its first words follow its name.
fn figure(line: &str) -> Option<&str> {
    let printed = match line.strip_prefix("test ") {
        Some(of_harness) => of_harness.split_once(" ... ")?.1,
        None => line,
    };
    let harness = ["running ", "test result", "ok", "ignored", "FAILED"];
    let is_printed = !printed.is_empty() && !harness.iter().any(|start| printed.starts_with(start));
    is_printed.then_some(printed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_what_tests_printed() {
        let text = "\nrunning 2 tests\ntest maps::one ... 3 of 3 right\n4 of 4 refused\nok\ntest maps::two has been running for over 60 seconds\ntest maps::two ... \n5 µm\nok\n\ntest result: ok. 2 passed";
        let figures: Vec<&str> = text.lines().filter_map(figure).collect();
        assert_eq!(figures, ["3 of 3 right", "4 of 4 refused", "5 µm"]);
        let named = |name| text.lines().any(|line| is_of(line, name));
        assert!(named("maps::two") && !named("three") && !named("right"));
    }
}
