//! The command line.

use crate::board::Choice;
use crate::commands::Command;
use clap::Parser;
use std::process::ExitCode;

/// The courier's position sensor from the host: calibrate, watch, record, replay, diagnose.
#[derive(Debug, Parser)]
#[command(name = "courier", version, disable_help_subcommand = true)]
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
    fn every_command_has_an_example() {
        for command in Cli::command().get_subcommands() {
            let help = command.clone().render_long_help().to_string();
            assert!(
                help.contains("Example"),
                "{} has no example",
                command.get_name()
            );
        }
    }
}
