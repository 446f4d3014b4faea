//! Bad input: one line that names the place, exit code 2, nothing on standard output, nothing written.

use crate::common::courier_in;

const META: &str =
    "schema = 1\n[geometry]\npitch_m = 1e-3\n[electronics]\nposition_noise_m = 1e-8\n";
const SAMPLES: &str = "t_s,p1_m,ref_x_m\n0,0,0\n1,1e-4,1e-4\n";

/// Each wrong recording: name, recording.toml, samples.csv, what the line must hold.
const RECORDINGS: [(&str, &str, &str, &[&str]); 9] = [
    (
        "schema",
        "schema = 9\n",
        SAMPLES,
        &["recording.toml", "schema", "found 9", "wanted 1"],
    ),
    (
        "no-geometry",
        "schema = 1\n[electronics]\nposition_noise_m = 1e-8\n",
        SAMPLES,
        &["recording.toml", "[geometry]"],
    ),
    (
        "no-noise",
        "schema = 1\n[geometry]\npitch_m = 1e-3\n",
        SAMPLES,
        &["recording.toml", "[electronics]"],
    ),
    (
        "garbage",
        "\u{0}\u{1}\u{2}",
        SAMPLES,
        &["recording.toml", "wanted TOML"],
    ),
    (
        "nan",
        META,
        "t_s,p1_m\n0,0\n1,NaN\n",
        &["samples.csv", "row 3", "p1_m", "NaN", "finite"],
    ),
    (
        "backward",
        META,
        "t_s,p1_m\n1,0\n0,0\n",
        &["samples.csv", "row 3", "t_s", "\"0\"", "after"],
    ),
    (
        "ragged",
        META,
        "t_s,p1_m\n0\n",
        &["samples.csv", "row 2", "1 fields", "2"],
    ),
    ("no-time", META, "p1_m\n0\n", &["samples.csv", "t_s"]),
    ("empty", META, "", &["samples.csv", "empty"]),
];

/// Each wrong command line, and what the line must hold.
const COMMAND_LINES: [(&[&str], &[&str]); 10] = [
    (&[], &["no command", "--help"]),
    (&["fly"], &["fly"]),
    (&["replay"], &["<RECORDING>"]),
    (
        &["replay", "nowhere"],
        &["nowhere", "no such file", "wanted a folder"],
    ),
    (
        &["replay", "a-file"],
        &["a-file", "found a file", "wanted a folder"],
    ),
    (
        &["replay", "empty-folder"],
        &["recording.toml", "no such file"],
    ),
    (&["replay", "nan", "--yaml"], &["--yaml"]),
    (&["completions", "cobol"], &["cobol", "bash"]),
    // Before any work, and before the file that could be written is.
    (
        &[
            "diagnose",
            "nan",
            "--json",
            "a.json",
            "--report",
            "no/a.html",
        ],
        &["no/a.html", "found no folder for it"],
    ),
    (
        &["blind", "--folder", "cases", "--json", "empty-folder"],
        &["empty-folder", "found a folder"],
    ),
];

#[test]
fn one_line_and_exit_code_two() {
    let folder = tempfile::tempdir().unwrap();
    for (name, meta, samples, _) in RECORDINGS {
        let path = folder.path().join(name);
        std::fs::create_dir(&path).unwrap();
        std::fs::write(path.join("recording.toml"), meta).unwrap();
        std::fs::write(path.join("samples.csv"), samples).unwrap();
    }
    std::fs::write(folder.path().join("a-file"), "").unwrap();
    std::fs::create_dir(folder.path().join("empty-folder")).unwrap();
    let before = listing(folder.path());
    let recordings = RECORDINGS.map(|(name, _, _, wanted)| (vec!["replay", name], wanted));
    let command_lines = COMMAND_LINES.map(|(arguments, wanted)| (arguments.to_vec(), wanted));
    for (arguments, wanted) in recordings.into_iter().chain(command_lines) {
        courier_in(folder.path(), &arguments).refused(wanted);
    }
    assert_eq!(listing(folder.path()), before);
}

#[test]
fn help_is_no_error() {
    let folder = tempfile::tempdir().unwrap();
    for arguments in [
        &["--help"][..],
        &["replay", "--help"],
        &["--version"],
        &["completions", "bash"],
    ] {
        assert!(!courier_in(folder.path(), arguments).quiet().is_empty());
    }
}

fn listing(folder: &std::path::Path) -> Vec<std::path::PathBuf> {
    let mut paths = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            paths.extend(listing(&path));
        }
        paths.push(path);
    }
    paths.sort();
    paths
}
