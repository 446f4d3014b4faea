//! The command line.

use crate::board::Choice;
use crate::commands::Command;
use clap::Parser;
use courier_sensor::calibration::record::VERSION as RECORD;
use courier_sensor::link::message::PROTOCOL;
use recording::SCHEMA;
use std::process::ExitCode;

/// What `courier --version` says beside the number: what this build can talk to and read.
fn long_version() -> String {
    let told = |is_in: bool| if is_in { "built in" } else { "not built in" };
    let probes = told(cfg!(feature = "probe-code"));
    let parquet = told(cfg!(feature = "parquet"));
    let mcap = told(cfg!(feature = "mcap"));
    format!(
        "{}\nlink protocol {PROTOCOL}, calibration records {RECORD}, recordings of schema {SCHEMA}\ndebug probes {probes}, Parquet {parquet}, MCAP {mcap}; {} on {}",
        env!("CARGO_PKG_VERSION"),
        std::env::consts::OS,
        std::env::consts::ARCH,
    )
}

/// The courier's position sensor from the host: calibrate, watch, record, replay, diagnose.
#[derive(Debug, Parser)]
#[command(name = "courier", version, long_version = long_version(), disable_help_subcommand = true)]
pub struct Cli {
    /// Which board.
    #[command(flatten)]
    pub board: Choice,
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// Runs the process's command line and gives its exit code.
pub fn main() -> ExitCode {
    command_line::run(|cli: Cli| cli.command.run(&cli.board))
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_well_formed() {
        Cli::command().debug_assert();
    }

    #[test]
    fn the_version_tells_what_can_be_talked_to() {
        let told = Cli::command().render_long_version();
        assert!(told.starts_with("courier 0."), "{told}");
        assert!(
            told.contains(&format!("link protocol {PROTOCOL}")),
            "{told}"
        );
    }

    /// Every command has an example, and each is one that this build takes: debug probes are not in every build.
    #[test]
    fn every_command_has_an_example_that_works_here() {
        for command in Cli::command().get_subcommands() {
            let help = command.get_after_long_help().or(command.get_after_help());
            let told = help.map(ToString::to_string).unwrap_or_default();
            let told = told.replace("\\\n", " ");
            let examples: Vec<&str> = told
                .lines()
                .map(str::trim)
                .filter(|line| line.starts_with("courier "))
                .flat_map(|line| line.split(" && "))
                // What comes behind it: a remark, a file or another program.
                .filter_map(|example| example.split("   ").next())
                .filter_map(|example| example.split(" > ").next())
                .filter_map(|example| example.split(" | ").next())
                .collect();
            assert!(
                !examples.is_empty(),
                "{} has no example",
                command.get_name()
            );
            for example in examples {
                let parsed = Cli::try_parse_from(example.split_whitespace());
                assert!(parsed.is_ok(), "{example}: {}", parsed.unwrap_err());
                assert!(!example.contains("--probe"), "{example}");
            }
        }
    }
}
