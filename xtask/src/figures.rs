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
            "recalibration::month::a_quarter",
            "recalibration::tries::nothing_that_makes_the_position_worse_comes_in_force_in_twenty",
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
/// A test fails: its figure is not reached.
pub fn run() -> Result<()> {
    println!("accuracy figures, each asserted by the test that prints it:");
    for (package, program, names) in SOURCES {
        let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
        command
            .current_dir(arm::root())
            .args(["test", "--quiet", "--profile", "checked"])
            .args(["--package", package, "--test", program, "--"])
            .args(["--nocapture", "--test-threads=1"])
            .args(*names);
        let output = command.output().context("cargo test")?;
        let text = String::from_utf8_lossy(&output.stdout);
        // The quiet harness puts its dot in front of what the next test prints.
        let lines = text.lines().map(|line| line.trim_start_matches('.'));
        lines
            .filter(|line| is_figure(line))
            .for_each(|line| println!("  {line}"));
        ensure!(
            output.status.success(),
            "{package}, {program}: a figure is not reached:\n{text}"
        );
    }
    Ok(())
}

/// What a test printed, not what its harness says of it.
fn is_figure(line: &str) -> bool {
    let harness = ["running ", "test result", "test "];
    !line.is_empty() && !harness.iter().any(|start| line.starts_with(start))
}
