//! `cargo demo`: `courier demo` without the rest of `courier`, which takes three times as long to build.

use anyhow::{Context, Result};
use clap::Parser;
use courier_demo::{Args, On, demo};
use std::process::{Command, ExitCode};

// Without documentation of its own, so that the options' is the help's first line.
#[derive(Debug, Parser)]
#[command(name = "cargo demo", bin_name = "cargo demo", version)]
struct Cli {
    #[command(flatten)]
    args: Args,
}

fn main() -> ExitCode {
    command_line::run(|cli: Cli| match cli.args.on() {
        On::Sim => {
            cli.args.files().check()?;
            demo(&cli.args, board_link::Starter::default())
        }
        On::Emulated | On::Chip => whole_command(),
    })
}

/// These boards come with the whole command: `courier demo` with the arguments of this process.
fn whole_command() -> Result<ExitCode> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let manifest = concat!(env!("CARGO_MANIFEST_DIR"), "/../Cargo.toml");
    let status = Command::new(cargo)
        .args(["run", "--quiet", "--release", "--manifest-path", manifest])
        .args(["--package", "courier", "--", "demo"])
        .args(std::env::args_os().skip(1))
        .status()
        .context("--on: cargo, which builds the whole command")?;
    let code = status.code().and_then(|code| u8::try_from(code).ok());
    Ok(code.map_or(ExitCode::FAILURE, ExitCode::from))
}
