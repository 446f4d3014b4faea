//! `courier demo`, end to end.

use crate::common::{courier, courier_in, entry, shared};
use serde_json::Value;

/// Names of the rows, in the order of the paper's table.
const NAMES: [&str; 11] = [
    "condition_number",
    "scatter_residual_before_um",
    "scatter_residual_after_um",
    "flyby_residual_before_um",
    "flyby_residual_after_um",
    "flyby_position_before_um",
    "flyby_position_after_um",
    "theta_x_before_mrad",
    "theta_x_after_mrad",
    "theta_y_before_mrad",
    "theta_y_after_mrad",
];

fn here(report: &Value, name: &str) -> f64 {
    entry(report, "rows", "name", name)["here"]
        .as_f64()
        .unwrap()
}

/// From an uncalibrated board to a flight on what it stored. The noise of a segment is 0.16 µm a sample: 0.32 µm in g_p of
/// single samples on the flight, a quarter of that in the mean of 16 at each pose; the slope of e adds some tens of percent.
#[test]
fn ideal_reaches_the_noise() {
    let report = courier(&["demo", "--preset", "ideal", "--seed", "5", "--json"]).json();
    let names: Vec<&str> = report["rows"]
        .as_array()
        .unwrap()
        .iter()
        .map(|row| row["name"].as_str().unwrap())
        .collect();
    assert_eq!(names, NAMES);
    assert_eq!(
        (&report["preset"], &report["poses"], &report["accepted"]),
        (&"ideal".into(), &1000.into(), &true.into())
    );
    assert!(
        (7.0..8.7).contains(&here(&report, "condition_number")),
        "{report}"
    );
    assert!(
        (0.07..0.13).contains(&here(&report, "scatter_residual_after_um")),
        "{report}"
    );
    assert!(
        (0.28..0.50).contains(&here(&report, "flyby_residual_after_um")),
        "{report}"
    );
    assert!(here(&report, "flyby_position_after_um") < 0.2, "{report}");
    assert!(
        here(&report, "flyby_position_after_um") < 0.2 * here(&report, "flyby_position_before_um"),
        "{report}"
    );
}

/// The same seed gives the same run, another one another courier; a recording of it calibrates to the same sensor.
#[test]
fn seeds_repeat_and_recordings_replay() {
    let folder = tempfile::tempdir().unwrap();
    let run = |seed: &str, name: &str| {
        let ran = courier_in(
            folder.path(),
            &[
                "demo", "--preset", "ideal", "--plan", "optimal", "--poses", "120", "--seed", seed,
                "--json", "--record", name,
            ],
        );
        ran.quiet()
    };
    let (first, second, other) = (run("7", "first"), run("7", "second"), run("8", "other"));
    assert_eq!(first, second);
    assert_ne!(first, other);
    let file = |name: &str| std::fs::read(folder.path().join(name).join("samples.csv")).unwrap();
    assert_eq!(file("first"), file("second"));
    let replayed = courier_in(folder.path(), &["replay", "first", "--json"]).json();
    let residual_m = replayed["held_out"]["calibrated_rms_m"].as_f64().unwrap();
    assert!((0.28e-6..0.50e-6).contains(&residual_m), "{replayed}");
}

/// Shapes that no model of ours made: from the shared data, and from a file of the user's.
#[test]
fn measured_waveforms() {
    let folder = tempfile::tempdir().unwrap();
    let mut table = "code,a,b,c,d\n".to_owned();
    for code in 0..512 {
        let phase = std::f64::consts::TAU * f64::from(code) / 512.0;
        let value =
            |order: f64, shift: f64| (order * phase + shift).sin() + 0.3 * (2.0 * phase).cos();
        table += &format!(
            "{code},{},{},{},{}\n",
            value(1.0, 0.0),
            value(2.0, 1.0),
            value(1.0, 2.0),
            value(4.0, 3.0)
        );
    }
    std::fs::write(folder.path().join("mine.csv"), table).unwrap();
    let mine = [
        "demo",
        "--preset",
        "measured",
        "--waveforms",
        "mine.csv",
        "--rms-um",
        "1",
        "--poses",
        "150",
        "--json",
    ];
    let report = courier_in(folder.path(), &mine).json();
    // At 1 µm the error is small enough for equation (3)'s phase to be the output's: what is left is the noise, 0.08 µm.
    assert!(
        here(&report, "scatter_residual_after_um") < 0.13,
        "{report}"
    );
    if shared("encoder-waveforms").is_some() {
        let report = courier(&["demo", "--preset", "measured", "--poses", "150", "--json"]).json();
        println!(
            "measured waveforms at 10 µm: {} µm left by equation (3)",
            here(&report, "scatter_residual_after_um")
        );
        assert!(
            here(&report, "scatter_residual_after_um")
                < here(&report, "scatter_residual_before_um")
        );
    }
}

#[test]
fn wrong_options_are_one_line() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("full")).unwrap();
    std::fs::write(folder.path().join("full/thesis.txt"), "precious").unwrap();
    std::fs::write(folder.path().join("bad.csv"), "code,a\n0,1\n1,x\n").unwrap();
    let cases: [(&[&str], &[&str]); 14] = [
        (
            &["--joint", "--plan", "optimal"],
            &["--joint", "cannot be used with"],
        ),
        (
            &["--joint", "--record", "new"],
            &["--joint", "cannot be used with"],
        ),
        (
            &["--joint", "--poses", "2000"],
            &["--poses", "2000", "50 to 1000"],
        ),
        (
            &["--preset", "perfect"],
            &["perfect", "paper", "ideal", "measured"],
        ),
        (&["--plan", "best"], &["best", "random", "optimal"]),
        (&["--poses", "0"], &["'0'", "40..=20000"]),
        (&["--poses", "many"], &["many"]),
        (&["--seed", "-1"], &["-1"]),
        (
            &["--waveforms", "bad.csv"],
            &["--waveforms", "--preset measured"],
        ),
        (
            &["--preset", "measured", "--waveforms", "none.csv"],
            &["none.csv"],
        ),
        (
            &["--preset", "measured", "--waveforms", "bad.csv"],
            &["bad.csv", "row 3", "\u{60}x\u{60}"],
        ),
        (
            &[
                "--preset",
                "measured",
                "--waveforms",
                "bad.csv",
                "--rms-um",
                "nan",
            ],
            &["row 3"],
        ),
        (&["--record", "full"], &["full", "thesis.txt", "wanted"]),
        (&["--force"], &["--record"]),
    ];
    for (options, wanted) in cases {
        courier_in(folder.path(), &[&["demo"], options].concat()).refused(wanted);
    }
    let names: Vec<_> = std::fs::read_dir(folder.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name())
        .collect();
    assert_eq!(names.len(), 2, "{names:?}");
}

/// The accepted result is told in the table, the refused one by name and with exit code 1.
#[test]
fn the_table_names_every_row() {
    let told = courier(&["demo", "--preset", "ideal", "--poses", "100"]).quiet();
    assert!(
        told.contains("accepted: held-out g_p residual")
            && told.contains("in force after a restart"),
        "{told}"
    );
    assert_eq!(
        told.lines().filter(|line| line.contains("| ")).count(),
        1 + NAMES.len(),
        "{told}"
    );
}

/// Figure asked for: the ten rows of 3.1.2 within 25 % of the paper's, whatever the noise and the poses. Seed 1 stands in README.md,
/// which is compared with what the command prints.
#[test]
fn the_papers_table_comes_out() {
    let report = courier(&["demo", "--seed", "20", "--json"]).json();
    let rows = report["rows"].as_array().unwrap().iter();
    let number = |row: &Value, key: &str| row[key].as_f64().unwrap();
    let seed_20 = rows.map(|row| [number(row, "paper"), number(row, "here")]);
    for (seed, rows) in [("1", readme_rows()), ("20", seed_20.collect())] {
        assert_eq!(rows.len(), NAMES.len(), "seed {seed}");
        assert!((7.0..8.7).contains(&rows[0][1]), "seed {seed}: {rows:?}");
        for (name, [paper, here]) in NAMES.iter().zip(rows).skip(1) {
            let ratio = here / paper;
            assert!(
                (0.75..1.25).contains(&ratio),
                "seed {seed}, {name}: {ratio}"
            );
        }
    }
}

/// The paper's number and ours in each row of README.md's table.
fn readme_rows() -> Vec<[f64; 2]> {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../README.md");
    let page = std::fs::read_to_string(path).unwrap();
    let (_, printed) = page
        .split_once("$ cargo demo\ncourier `paper`, seed 1: ")
        .unwrap();
    let (printed, _) = printed.split_once("```").unwrap();
    let numbers = |line: &str| {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let [_, _, _, paper, here, _] = cells[..] else {
            return None;
        };
        Some([paper.parse().ok()?, here.parse().ok()?])
    };
    printed.lines().filter_map(numbers).collect()
}

/// Section 3.2.1's rows, in its order.
const JOINT_NAMES: [&str; 15] = [
    "height_um",
    "lever_um",
    "other_um",
    "g_x_residual_um",
    "g_y_residual_um",
    "g_p_residual_um",
    "position_uncalibrated_um",
    "position_separate_um",
    "position_joint_um",
    "theta_x_joint_mrad",
    "theta_y_joint_mrad",
    "theta_x_uncalibrated_mrad",
    "theta_x_separate_mrad",
    "theta_y_uncalibrated_mrad",
    "theta_y_separate_mrad",
];

/// Equation (3) and noise only: both methods have the right model, and the joint calibration must not make a flight worse.
#[test]
fn joint_has_the_rows_of_the_paper() {
    let report = courier(&[
        "demo", "--joint", "--preset", "ideal", "--poses", "150", "--json",
    ])
    .json();
    let rows = report["rows"].as_array().unwrap();
    let names: Vec<&str> = rows
        .iter()
        .map(|row| row["name"].as_str().unwrap())
        .collect();
    assert_eq!(names, JOINT_NAMES);
    assert_eq!(
        (&report["preset"], &report["poses"]),
        (&"ideal".into(), &150.into())
    );
    let complete = |row: &Value| {
        ["paper", "here", "paper_method"]
            .iter()
            .all(|key| row[key].is_number())
    };
    assert!(rows.iter().all(complete), "{report}");
    // Single samples of 0.16 um a segment; the calibration adds its own error to that.
    assert!(here(&report, "position_joint_um") < 0.3, "{report}");
    assert!(
        here(&report, "position_joint_um") < 0.2 * here(&report, "position_uncalibrated_um"),
        "{report}"
    );
    assert!(
        here(&report, "theta_x_joint_mrad") < 0.06 && here(&report, "theta_y_joint_mrad") < 0.06,
        "{report}"
    );
}

/// The issue's figures, by the platen sensor alone on a single sample a place, with the
/// tooth map in force: the position within 0.6 um and both angles within 0.06 mrad, never worse than before calibration; the
/// paper's method on the same courier within 30 % of what the paper printed in each of the issue's rows. Seed 1 stands line by
/// line in `docs/accuracy.md`, and is compared with it.
#[test]
#[ignore = "nightly: a minute and a half, and docs/accuracy.md holds seed 1"]
fn joint_with_the_tooth_map_goes_past_the_paper() {
    // Not that of docs/accuracy.md.
    let seed = "7";
    let report = courier(&["demo", "--joint", "--seed", seed, "--json"]).json();
    assert!(report["map"].is_object(), "{report}");
    for axis in ["x", "y"] {
        let theta = |when: &str| here(&report, &format!("theta_{axis}_{when}_mrad"));
        let (before, after) = (theta("uncalibrated"), theta("joint"));
        println!("seed {seed}: theta_{axis} {before:.3} -> {after:.4} mrad");
        assert!(after <= 0.06 && after <= before, "{report}");
    }
    let position_um = here(&report, "position_joint_um");
    println!("seed {seed}: position {position_um:.3} um");
    assert!(position_um <= 0.6, "{report}");
    // A position's mean is gauge; its predicted deviation leaves the figure more than two deviations of room.
    let predicted_um = 1.0e6 * report["map"]["way_deviation_m"][1].as_f64().unwrap();
    assert!(predicted_um < 0.25, "{report}");
    for row in report["rows"].as_array().unwrap() {
        let name = row["name"].as_str().unwrap();
        // Not of the courier; and, of 3.2.1 but not among the issue's rows, 0.23 where the paper has 0.17.
        let exempt = matches!(
            name,
            "height_um" | "lever_um" | "other_um" | "theta_x_separate_mrad"
        );
        let ratio = row["paper_method"].as_f64().unwrap() / row["paper"].as_f64().unwrap();
        assert!(
            exempt || (0.7..1.3).contains(&ratio),
            "seed {seed}, {name}: {ratio}"
        );
    }
}
