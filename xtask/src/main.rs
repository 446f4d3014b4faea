//! Drives the checks of the project: `cargo xtask COMMAND`.

mod arm;
mod arm_checks;
mod assemble;
mod bench;
mod blind;
mod cargo;
mod chip;
mod circles;
mod cmsis;
mod constants;
mod drift;
mod examples;
mod figures;
mod firmware;
mod flash;
mod functions;
mod image_body;
mod manifests;
mod mcap;
mod mistakes;
mod names;
mod onboard;
mod option_bytes;
mod parity;
mod parquet;
mod permission;
mod platforms;
mod plugin;
mod processor_time;
mod python;
mod recordings;
mod report;
mod robustness;
mod rp2350;
mod runner;
mod setup;
mod sign;
mod source;
mod stack;
mod test;
mod throughput;

use std::process::ExitCode;

/// A command: its name, what it does, and the function that does it.
type Task = (&'static str, &'static str, Work);

/// What a command does: by itself, or with the arguments after its name.
#[derive(Clone, Copy)]
enum Work {
    Alone(fn() -> anyhow::Result<()>),
    With(fn(&[String]) -> anyhow::Result<()>),
}

/// All commands. A further one is a line here.
const TASKS: &[Task] = &[
    (
        "test",
        "everything that checks the project; sets up what is missing (NAMES OF CHECKS)",
        Work::With(test::run),
    ),
    (
        "nightly",
        "the tests that `test` leaves out for their length, each for a change that others hold less closely",
        Work::Alone(test::nightly),
    ),
    (
        "parquet",
        "nightly: the command with its feature `parquet`, every kind of command, and what DuckDB, Arrow and Polars read",
        Work::Alone(parquet::nightly),
    ),
    (
        "ray",
        "nightly: the examples on Ray, on two workers of which one is killed",
        Work::Alone(python::on_ray),
    ),
    (
        "mcap",
        "nightly: the command with its feature `mcap`, a bag of ROS 2, a monitor that is cut, and other programs' readers",
        Work::Alone(mcap::nightly),
    ),
    (
        "rp2350",
        "nightly: the example of one encoder on an RP2350, compiled for its own core",
        Work::Alone(rp2350::nightly),
    ),
    (
        "bench",
        "the cost table, measured on the emulated Cortex-M4F (--json), then accuracy figures and throughput on this host",
        Work::With(bench::run),
    ),
    (
        "firmware",
        "both images: flash, RAM, worst stack, no panic in the interrupt",
        Work::With(firmware::run_command),
    ),
    (
        "report",
        "the HTML reports in a headless browser, at the width of a desk and of a phone, by day and by night (PAGES --picture)",
        Work::With(report::run),
    ),
    (
        "blind",
        "the nightly blind check of the diagnosis: its figures against those asked for (CASES SEED)",
        Work::With(blind::run),
    ),
    (
        "mistakes",
        "nightly: mis-wired and mis-stated recordings of every kind are recognised, and nothing is told of right ones (SEED)",
        Work::With(mistakes::run),
    ),
    (
        "robustness",
        "nightly: random recordings through every command, and surveys cut at random (crashes COUNT --first N; cuts COUNT)",
        Work::With(robustness::run),
    ),
    (
        "drift",
        "how well any claim can foretell what a wandering pair leaves on the next recording",
        Work::Alone(drift::run),
    ),
    (
        "examples",
        "makes the data in examples/ anew and says which differ",
        Work::Alone(examples::run),
    ),
    (
        "flash",
        "writes the board behind a debug probe (also `cargo flash`)",
        Work::With(flash::run),
    ),
    (
        "option-bytes",
        "looks at the option bytes of the board behind a debug probe, asks (or takes --yes), and sets them",
        Work::With(option_bytes::run_command),
    ),
    (
        "image",
        "the sensor board's firmware as a signed file for `courier update` (OUT [--key FILE]; --new-key FILE)",
        Work::With(sign::run),
    ),
    (
        "setup",
        "says what `courier --emulated` (with the word chip: `courier --chip`) lacks here, asks (or takes --yes), installs and builds it",
        Work::With(setup::run),
    ),
    (
        "images",
        "builds what `courier --emulated` runs and prints where it is; installs nothing",
        Work::Alone(firmware::images),
    ),
    (
        "emulated",
        "the tests of the image on the emulated board alone, with what they print and 1000 poses (NAMES OF TESTS)",
        Work::With(onboard::run),
    ),
    (
        "chip",
        "the sensor board's image as it ships on a model of its chip (NAMES OF CHECKS; control: embassy's image; --mutate: each mended fault brought in again; --tests: tests of the emulated board and of the commands on it; trace FILE.vcd [SECONDS]: what a logic analyser sees at its pins)",
        Work::With(chip::run_command),
    ),
    (
        "manifests",
        "licence, description and oldest compiler of every package, and a reason for each dependency",
        Work::Alone(manifests::check),
    ),
    (
        "circles",
        "no file takes names from one that takes names from it, in any crate",
        Work::Alone(circles::check),
    ),
    (
        "constants",
        "lists in docs/notes/constants.md where the numbers of the estimators come from",
        Work::Alone(constants::run),
    ),
    (
        "platforms",
        "`courier` type-checked for macOS and Windows",
        Work::Alone(platforms::check),
    ),
    (
        "arm",
        "the checks on the Cortex-M4F alone",
        Work::Alone(arm_checks::check),
    ),
];

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let name = arguments.first().map_or("", String::as_str);
    let Some((_, _, task)) = TASKS.iter().find(|(known, _, _)| *known == name) else {
        return usage(name);
    };
    let done = match (task, &arguments[1..]) {
        (Work::Alone(work), []) => work(),
        (Work::With(work), given) => work(given),
        (Work::Alone(_), [more, ..]) => {
            eprintln!("xtask {name}: found {more:?}, wanted no argument");
            return ExitCode::from(2);
        }
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("xtask {name}: {error:#}");
            match error.is::<flash::NoProbe>() || error.is::<permission::NotSetUp>() {
                true => ExitCode::from(2),
                false => ExitCode::FAILURE,
            }
        }
    }
}

fn usage(name: &str) -> ExitCode {
    let help = matches!(name, "-h" | "--help" | "help");
    if !help {
        let names: Vec<&str> = TASKS.iter().map(|(name, _, _)| *name).collect();
        eprintln!("xtask: found {name:?}, wanted one of {}", names.join(", "));
        return ExitCode::from(2);
    }
    for (name, what, _) in TASKS {
        println!("cargo xtask {name:<12} {what}");
    }
    ExitCode::SUCCESS
}
