//! An output never replaces an input, another output or a file of another kind: every command, every file that it writes.

use crate::common::{asked, courier_in};
use clap::{Arg, CommandFactory};
use courier::cli::Cli;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// A command line that is right but for its outputs, and the files that it reads. `{model}` and the like are made by [`prepare`].
struct Line {
    words: &'static str,
    /// Files that it reads.
    inputs: &'static [&'static str],
}

const fn line(words: &'static str, inputs: &'static [&'static str]) -> Line {
    Line { words, inputs }
}

const RECORDING: &[&str] = &["v/samples.csv", "v/recording.toml"];

/// Every command that writes a file. None gets as far as its work.
const LINES: [Line; 32] = [
    line("demo --record new", &[]),
    line("demo --preset measured --waveforms w.csv", &["w.csv"]),
    line("convert w.csv new", &["w.csv"]),
    line("encoder w.csv", &["w.csv"]),
    line("replay v", RECORDING),
    line("replay v --calibration c.json", &["c.json"]),
    line("diagnose v", RECORDING),
    line("blind --cases 1", &[]),
    line("blind score cases", &["cases/answers.json"]),
    line("check m.json v", &["m.json", "v/samples.csv"]),
    line("compare c.json v", &["c.json", "v/samples.csv"]),
    line("isolability", &[]),
    line("map v", RECORDING),
    line("fleet v", RECORDING),
    line("trace w.csv", &["w.csv"]),
    line("status", &[]),
    line("calibrate", &[]),
    line("abort", &[]),
    line("monitor", &[]),
    line("record new", &[]),
    line("slots", &[]),
    line("maps", &[]),
    line("recalibrate", &[]),
    line("commit", &[]),
    line("rollback", &[]),
    line("export new.json", &[]),
    line("import c.json", &["c.json"]),
    line("load m.json", &["m.json"]),
    line("--emulated log --elf image", &["image"]),
    line("reset", &[]),
    line("acceptance", &[]),
    line("update image", &["image"]),
];

/// Options that name a file to write.
const OUTPUTS: [&str; 4] = ["--json", "--model", "--report", "--out"];

/// Files of every kind but those that a command writes, and files that are of a command's kind but for one of its keys.
const STRANGERS: [(&str, &str); 7] = [
    ("w.csv", "t_s,q1s\n0,1\n"),
    ("c.json", "{\"courier_calibration\": 1}"),
    ("m.json", "{\"schema\": 1, \"survey\": {}, \"claimed\": {}}"),
    ("other.json", "{\"schema\": 1, \"recording\": \"v\"}"),
    ("list.json", "[1, 2]"),
    ("page.html", "<!DOCTYPE html><html><body>mine</body></html>"),
    ("image", "\u{7f}ELF"),
];

fn prepare(folder: &Path) {
    for (name, text) in STRANGERS {
        std::fs::write(folder.join(name), text).unwrap();
    }
    for sub in ["v", "cases"] {
        std::fs::create_dir(folder.join(sub)).unwrap();
    }
    std::fs::write(folder.join("cases/answers.json"), "{\"cases\": []}").unwrap();
    let meta = "schema = 1\n[geometry]\npitch_m = 1e-3\n[electronics]\nposition_noise_m = 1e-8\n";
    std::fs::write(folder.join("v/recording.toml"), meta).unwrap();
    std::fs::write(folder.join("v/samples.csv"), "t_s,p1_m,ref_x_m\n0,0,0\n").unwrap();
}

/// Every file's bytes.
fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut all = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(one) = folders.pop() {
        for entry in std::fs::read_dir(one).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(folder).unwrap().display().to_string();
                all.insert(name, std::fs::read(&path).unwrap());
            }
        }
    }
    all
}

/// The command that a line names, and the outputs that it takes.
fn outputs(line: &str) -> (String, Vec<&'static str>) {
    let cli = Cli::command();
    let mut words = line.split(' ').filter(|word| !word.starts_with("--"));
    let name = words.next().unwrap().to_owned();
    let mut command = cli.find_subcommand(&name).unwrap();
    if let Some(step) = words.next().and_then(|step| command.find_subcommand(step)) {
        command = step;
    }
    let takes = |option: &&str| {
        let long = option.trim_start_matches('-');
        // An option of the same name may take a folder.
        let is_folder = |argument: &Arg| {
            let names = argument.get_value_names().unwrap_or_default();
            names.iter().any(|name| name == "DIR")
        };
        command
            .get_arguments()
            .any(|argument| argument.get_long() == Some(long) && !is_folder(argument))
    };
    (name, OUTPUTS.into_iter().filter(takes).collect())
}

/// The table above is whole, and no command has an option for a file that the table does not know.
#[test]
fn every_command_that_writes_is_in_the_table() {
    let listed: BTreeSet<String> = LINES.iter().map(|line| outputs(line.words).0).collect();
    let cli = Cli::command();
    for command in cli.get_subcommands() {
        let name = command.get_name();
        let json = command
            .get_arguments()
            .any(|argument| argument.get_long() == Some("json"));
        assert!(
            !json || listed.contains(name),
            "{name} takes --json and is not in the table"
        );
    }
}

#[test]
fn an_output_replaces_nothing_that_is_of_another_kind() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    prepare(folder);
    let before = contents(folder);
    for Line { words, .. } in &LINES {
        for option in outputs(words).1 {
            for (name, _) in STRANGERS {
                let own = match option {
                    "--model" => "m.json",
                    _ => "",
                };
                if name != own {
                    asked(folder, &format!("{words} {option}={name}")).refused(&[name, "found"]);
                }
            }
        }
    }
    for name in ["w.csv", "m.json", "page.html"] {
        for force in ["", " --force"] {
            asked(folder, &format!("export {name}{force}")).refused(&[name]);
        }
    }
    assert_eq!(contents(folder), before);
}

#[test]
fn an_output_replaces_no_input_and_no_other_output() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    prepare(folder);
    // A model as an input may not be replaced even where the output is a model.
    std::fs::write(folder.join("same.json"), "").unwrap();
    link(folder);
    let before = contents(folder);
    for Line { words, inputs } in &LINES {
        let options = outputs(words).1;
        for option in &options {
            for input in *inputs {
                asked(folder, &format!("{words} {option}={input}")).refused(&[input]);
            }
            for other in options.iter().filter(|other| *other != option) {
                for (one, two) in [("both", "./both"), ("same.json", "same.json"), LINKED] {
                    let wanted = if one == "both" {
                        "two outputs in one file"
                    } else {
                        "found"
                    };
                    asked(folder, &format!("{words} {option}={one} {other}={two}"))
                        .refused(&[wanted]);
                }
            }
        }
    }
    asked(folder, "--sim-flash flash.bin status --json=flash.bin").refused(&["flash.bin", "reads"]);
    asked(folder, "record new --json=new").refused(&["new", "fills"]);
    asked(folder, "export both --json=both").refused(&["two outputs in one file"]);
    assert_eq!(contents(folder), before);
}

/// Two names of one empty file.
const LINKED: (&str, &str) = (
    "same.json",
    if cfg!(unix) {
        "hard.json"
    } else {
        "./same.json"
    },
);

fn link(folder: &Path) {
    std::fs::hard_link(folder.join("same.json"), folder.join("hard.json")).unwrap();
}

/// What a command wrote it may write again, and with a word of `--json` in each of its forms.
#[test]
fn an_output_replaces_one_of_its_kind() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let cheap = [
        ("status", "uptime"),
        ("slots", "slot"),
        ("maps", "place"),
        ("recalibrate", "waits for"),
        ("isolability --poses 60", "condition number"),
        ("monitor --seconds 0.3", "g_p"),
        ("record rec --seconds 0.05 --force", "samples in"),
        (
            "--sim-flash a.bin calibrate --poses 60 --held-out 20",
            "accepted",
        ),
        ("--sim-flash a.bin export c.json --force", "written to"),
        ("--sim-flash a.bin import c.json", "in force"),
        ("reset", "restarting"),
        (
            "--sim-flash a.bin acceptance --seconds 0.1 --commits 1",
            "passed",
        ),
        ("replay rec2", "held out"),
    ];
    line_recording(&folder.join("rec2"));
    for (words, told) in cheap {
        for form in ["--json=told.json", "--json told.json"] {
            let ran = asked(folder, &format!("{words} {form}"));
            assert_eq!(ran.code, 0, "{words}: {}", ran.err);
            assert!(ran.out.contains(told), "{words}: {}", ran.out);
            let file = std::fs::read_to_string(folder.join("told.json")).unwrap();
            assert!(file.starts_with(['{', '[']), "{words}: {file}");
        }
        let ran = courier_in(
            folder,
            &[&words.split(' ').collect::<Vec<_>>()[..], &["--json"]].concat(),
        );
        assert!(ran.out.starts_with(['{', '[']), "{words}: {}", ran.out);
        std::fs::remove_file(folder.join("told.json")).unwrap();
    }
}

/// One segment beside a reference, to and fro.
fn line_recording(folder: &Path) {
    std::fs::create_dir(folder).unwrap();
    let meta = "schema = 1\n[geometry]\npitch_m = 1e-3\n[electronics]\nposition_noise_m = 1e-7\n";
    std::fs::write(folder.join("recording.toml"), meta).unwrap();
    let mut rows = String::from("t_s,p1_m,ref_x_m\n");
    let mut noise = 1_u32;
    for k in 0..4000 {
        let t_s = f64::from(k) * 1.0e-3;
        let place_m = 5.0e-3 * (1.0 - (1.3 * t_s).cos());
        noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let error_m = 1.0e-6 * (std::f64::consts::TAU * place_m / 1.0e-3).sin()
            + 1.0e-7 * (f64::from(noise) / f64::from(u32::MAX) - 0.5);
        rows += &format!("{t_s},{:e},{place_m:e}\n", place_m + error_m);
    }
    std::fs::write(folder.join("samples.csv"), rows).unwrap();
}

/// `diagnose --json REC` diagnoses the recording and does not take it for the file.
#[test]
fn a_recording_after_json_is_the_recording() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    prepare(folder);
    for words in [
        "diagnose --json v",
        "diagnose v --json",
        "diagnose v --json -",
    ] {
        let ran = asked(folder, words);
        assert_eq!(ran.code, 0, "{words}: {}", ran.err);
        assert!(
            ran.out.contains("\"verdict\": \"insufficient_data\""),
            "{}",
            ran.out
        );
    }
    for words in ["diagnose v --json a.json", "diagnose --json a.json v"] {
        let ran = asked(folder, words);
        assert_eq!(ran.code, 0, "{words}: {}", ran.err);
        assert!(ran.out.contains("insufficient"), "{}", ran.out);
        std::fs::remove_file(folder.join("a.json")).unwrap();
    }
    asked(folder, "diagnose v --json a.json b").refused(&["--out"]);
}
