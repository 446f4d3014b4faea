//! The command line: one line on standard error and exit code 2 for anything that cannot be done as asked.

use crate::board::Choice;
use crate::commands::Command;
use crate::terminal::one_line;
use clap::error::ErrorKind;
use clap::{CommandFactory, FromArgMatches, Parser};
use std::process::ExitCode;

/// Exit code of bad input, bad options and refusals.
pub const EXIT_BAD_INPUT: u8 = 2;

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
    let cli = match parse() {
        Ok(cli) => cli,
        Err(error) => return usage(&error),
    };
    match cli.command.run(&cli.board) {
        Ok(code) => code,
        Err(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => refuse(&format!("{error:#}")),
    }
}

/// The process's command line. A negative number after an option is its value, which may then be out of range, and no option.
fn parse() -> Result<Cli, clap::Error> {
    let command = with_negative_numbers(Cli::command());
    Cli::from_arg_matches(&command.try_get_matches()?)
}

fn with_negative_numbers(command: clap::Command) -> clap::Command {
    command
        .allow_negative_numbers(true)
        .mut_subcommands(with_negative_numbers)
}

/// One line on standard error, and the exit code for bad input.
fn refuse(message: &str) -> ExitCode {
    eprintln!("courier: {}", one_line(message));
    ExitCode::from(EXIT_BAD_INPUT)
}

/// Help and version as they are; a usage error as one line.
fn usage(error: &clap::Error) -> ExitCode {
    if matches!(
        error.kind(),
        ErrorKind::DisplayHelp | ErrorKind::DisplayVersion
    ) {
        // A reader who closed the pipe has seen enough.
        let _ = error.print();
        return ExitCode::SUCCESS;
    }
    if error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
        return refuse("no command given; `courier --help` lists them");
    }
    let text = error.render().to_string();
    let lines = text
        .lines()
        .map(str::trim)
        .take_while(|line| !line.starts_with("Usage:"));
    let told: Vec<&str> = lines
        .filter(|line| !line.is_empty() && !line.starts_with("For more"))
        .collect();
    refuse(told.join(" ").trim_start_matches("error: "))
}

/// Whoever read our output has closed it: nothing is wrong.
fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error
        .downcast_ref::<std::io::Error>()
        .is_some_and(|error| error.kind() == std::io::ErrorKind::BrokenPipe)
}

#[cfg(test)]
mod tests {
    use super::*;

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
