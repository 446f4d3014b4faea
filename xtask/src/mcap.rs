//! The command built with its feature `mcap`, which the tests of every change leave out: the tests and lints of the crate `bag`, recordings
//! through the commands, a monitor that is cut, a bag of ROS 2, and what other programs' readers make of the files.
//! Part of `cargo xtask nightly`, and alone `cargo xtask mcap`.

mod readers;
mod rosbags;

use crate::arm;
use crate::cargo::cargo;
use crate::parquet::{built, courier, example};
use crate::permission;
use anyhow::{Context, Result, ensure};
use std::path::Path;
use std::process::Command;

/// Command lines, in order, in a folder of their own: `survey` is the example's folder, `log.csv` its log, `rosbags.mcap` a bag of ROS 2.
/// All of them succeed.
const LINES: [&str; 12] = [
    "convert survey s.mcap",
    "convert s.mcap again",
    "convert s.mcap s.parquet",
    "convert s.parquet of-parquet.mcap",
    "convert log.csv encoder.mcap --column t_s=time:ms --column q1s=sin --column q1c=cos --column ref_x_m=stage:mm --pitch 1.016mm",
    "convert encoder.mcap encoder",
    "replay encoder.mcap --json=by-file.json",
    "replay encoder --json=by-folder.json",
    "--sim-preset ideal record board.mcap --seconds 0.2 --platen-id west",
    "monitor --rate-hz 50 --seconds 3 --mcap watched.mcap",
    "convert watched.mcap watched --column p1_m=/state.x_m --column p2_m=/state.y_m --pitch 1.016mm",
    "convert rosbags.mcap joints --column p1_m=position[elbow]:rad --column ref_x_m=/stage.data:deg",
];

/// Builds the command with the feature and runs all of it.
///
/// # Errors
/// It does not compile, a lint or a test fails, or a command line fails or gives another answer than from a folder.
pub fn nightly() -> Result<()> {
    permission::grant();
    let lint = "clippy --quiet --profile checked --package bag --package courier --all-targets --features courier/mcap,bag/mcap -- --deny warnings";
    arm::run(&mut cargo(&lint.split(' ').collect::<Vec<_>>()))
        .context("clippy with the feature mcap")?;
    let test = "test --quiet --profile checked --package bag --features bag/mcap";
    arm::run(&mut cargo(&test.split(' ').collect::<Vec<_>>())).context("the tests of bag")?;
    let command = built()?;
    let folder = example("mcap")?;
    let folder = folder.as_path();
    std::fs::copy(
        arm::root().join("bag/tests/files/rosbags.mcap"),
        folder.join("rosbags.mcap"),
    )?;
    for line in LINES {
        courier(&command, folder, line)?;
    }
    let read =
        |name: &str| std::fs::read_to_string(folder.join(name)).with_context(|| name.to_owned());
    for name in ["recording.toml", "samples.csv"] {
        ensure!(
            read(&format!("survey/{name}"))? == read(&format!("again/{name}"))?,
            "{name}: found a difference after MCAP, wanted none"
        );
    }
    let by_file = read("by-file.json")?.replace("encoder.mcap", "encoder");
    ensure!(
        by_file == read("by-folder.json")?,
        "replay: found another answer from the file than from the folder"
    );
    cut(&command, folder)?;
    readers::with_python(&command, folder)?;
    rosbags::with_rosbags(&command, folder)?;
    readers::with_foxglove(&command, folder)
}

/// A monitor's file without its end is read as far as it goes; a recording's is refused.
fn cut(command: &Path, folder: &Path) -> Result<()> {
    for name in ["watched", "s"] {
        let bytes = std::fs::read(folder.join(format!("{name}.mcap")))?;
        std::fs::write(
            folder.join(format!("{name}-cut.mcap")),
            &bytes[..bytes.len() * 2 / 3],
        )?;
    }
    let told = arm::output(
        Command::new(command)
            .args(["convert", "watched-cut.mcap"])
            .current_dir(folder),
    )?;
    ensure!(
        told.contains("the end of the file is missing"),
        "watched-cut.mcap: found no word of its missing end in\n{told}"
    );
    let refused = Command::new(command)
        .args(["replay", "s-cut.mcap"])
        .current_dir(folder)
        .output()?;
    let told = String::from_utf8_lossy(&refused.stderr).into_owned();
    ensure!(
        refused.status.code() == Some(2) && told.contains("a recording whose end is missing"),
        "s-cut.mcap: found\n{told}"
    );
    Ok(())
}
