//! `cargo xtask chip`: the sensor board's image as it ships, run on a model of its chip (`tools/chip`).

mod batches;
mod control;
mod copy;
mod figures;
mod model;
mod mutate;
mod mutations;
mod rules;
mod score;

pub use figures::json;
pub use model::missing;

use self::mutate::Tools;
use crate::arm::{self, run, say};
use crate::cargo::cargo;
use crate::firmware;
use crate::permission::NotSetUp;
use crate::processor_time;
use anyhow::Result;
use std::process::Command;

/// The command. Words: names of checks; none: all, and the model's own tests before them. `--mutate` and names of mutations, each tried
/// alone; none: all, and what trips each rule. `--tests` and names of tests of the emulated board or of `host/tests/chip`, none: those of
/// [`TESTS`]. `control`: embassy's images. `trace FILE.vcd [SECONDS]`: what a logic analyser sees at the pins.
///
/// # Errors
/// The image or the model cannot be built, or a check fails.
pub fn run_command(arguments: &[String]) -> Result<()> {
    model::prepare().map_err(|error| NotSetUp::of(error, " chip"))?;
    match arguments.split_first() {
        Some((first, names)) if first == "--mutate" => mutate_all(names),
        Some((first, [])) if first == "control" => control::check(),
        Some((first, names)) if first == "--tests" => boards_tests(&TESTS, names),
        Some((first, words)) if first == "trace" => trace(words),
        _ => check(arguments),
    }
}

fn check(names: &[String]) -> Result<()> {
    let image = firmware::build(&arm::ensure()?, "g474")?;
    let program = model::build()?;
    if names.is_empty() {
        timed("the model's own tests", || {
            model::own_tests()?;
            rules::check(&program)
        })?;
    }
    timed("the checks", || {
        run(Command::new(program).arg(image).args(names))
    })
}

fn trace(words: &[String]) -> Result<()> {
    let image = firmware::build(&arm::ensure()?, "g474")?;
    run(Command::new(model::build()?)
        .arg("trace")
        .arg(image)
        .args(words))
}

fn mutate_all(names: &[String]) -> Result<()> {
    let arm = arm::ensure()?;
    firmware::build(&arm, "g474")?;
    let model = model::build()?;
    let tools = Tools {
        arm: &arm,
        model: &model,
    };
    say("each mended fault is brought in again");
    if !names.is_empty() {
        return mutate::alone(tools, names)?.judge();
    }
    model::own_tests()?;
    rules::check(&model)?;
    mutate::all(tools)?.judge()
}

/// Faults that `cargo xtask nightly` brings in again, in one image: one that the peripherals show, one of the signal path.
const SAMPLE: [&str; 2] = ["1-data-cache", "3-missed-instants"];
/// Tests of the emulated board and of the commands that `cargo xtask test` runs on the model.
const SAMPLE_TESTS: [&str; 4] = ["bytes::", "log::", "commands::", "trace::"];

/// What `cargo xtask test` asks of the model: all checks, somebody else's images, and that it is a board of `courier`. Says what each part took of processor time.
///
/// # Errors
/// As [`run_command`].
pub fn test() -> Result<()> {
    let arm = arm::ensure()?;
    model::prepare().map_err(|error| NotSetUp::of(error, " chip"))?;
    timed("building the image", || firmware::build(&arm, "g474"))?;
    timed("building the model", model::build)?;
    check(&[])?;
    timed("the control", control::check)?;
    timed("tests of the emulated board and of the commands", || {
        boards_tests(&SAMPLE_TESTS, &[])
    })
}

/// What `cargo xtask nightly` asks besides: that the model still sees faults. It builds an image for that.
///
/// # Errors
/// As [`run_command`].
pub fn nightly() -> Result<()> {
    let arm = arm::ensure()?;
    model::prepare().map_err(|error| NotSetUp::of(error, " chip"))?;
    let tools = Tools {
        arm: &arm,
        model: &model::build()?,
    };
    timed("faults brought in again", || {
        mutate::together(tools, &SAMPLE.map(Into::into))?.judge()
    })
}

/// Does it, and says what it took.
fn timed<R>(what: &str, work: impl FnOnce() -> Result<R>) -> Result<R> {
    let (result, took) = processor_time::of(work);
    say(&format!(
        "{what}: {:.1} s of processor time",
        took.as_secs_f64()
    ));
    result
}

/// Tests of the commands (`host/tests/chip`), and those of the emulated board (`host/tests/emulated`) that need nothing which only that board
/// has.
const TESTS: [&str; 15] = [
    "commands::",
    "trace::",
    "calibration::",
    "bytes::",
    "parts::a_silent_converter",
    "parts::a_stuck_channel",
    "parts::an_absent_motion_controller",
    "restarts::a_restart_under_stream",
    "storage::",
    "map::",
    "log::",
    "acceptance::",
    "speed::",
    "long::",
    "joint::a_joint_calibration_is_aborted",
];

/// Those of these names on the model of the chip, none: `usual` ones.
fn boards_tests(usual: &[&str], names: &[String]) -> Result<()> {
    let image = firmware::build(&arm::ensure()?, "g474")?;
    let model = model::build()?;
    let mut command = cargo(&["test", "--profile", "checked", "--package", "courier"]);
    command.args(["--test", "emulated", "--test", "chip", "--"]);
    match names {
        [] => command.args(usual),
        names => command.args(names),
    };
    command
        .env("COURIER_TEST_BOARD", "chip")
        .env("COURIER_CHIP_MODEL", model)
        .env("COURIER_CHIP_IMAGE", image);
    run(&mut command)
}

/// Installs what is missing and builds the model and the image.
///
/// # Errors
/// Something cannot be installed or built.
pub fn set_up() -> Result<()> {
    model::prepare()?;
    firmware::build(&arm::ensure()?, "g474")?;
    model::build().map(drop)
}
