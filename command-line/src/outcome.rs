//! From a command line to an exit code: one line on standard error and exit code 2 for anything that cannot be done as asked, and
//! exit code 70 for an error of the program itself.

use crate::json;
use crate::program_error::{self, EXIT_PROGRAM_ERROR, caught};
use crate::terminal::one_line;
use clap::Parser;
use clap::error::ErrorKind;
use std::ffi::OsString;
use std::io::Write as _;
use std::process::ExitCode;

/// Exit code of bad input, bad options and refusals.
pub const EXIT_BAD_INPUT: u8 = 2;

/// Takes the process's command line apart, does `work` with it and gives the exit code.
pub fn run<P: Parser>(work: impl FnOnce(P) -> anyhow::Result<ExitCode>) -> ExitCode {
    let whole = || {
        let parsed = match parse() {
            Ok(parsed) => parsed,
            Err(error) => return usage(&error),
        };
        match work(parsed) {
            Ok(code) => code,
            Err(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
            Err(error) => refuse(&told(&error)),
        }
    };
    caught(whole).unwrap_or_else(|panic| {
        let command = P::command();
        let version = command.get_version().unwrap_or_default();
        let program = format!("{} {version}", command.get_name());
        let arguments = std::env::args_os().map(|word| word.to_string_lossy().into_owned());
        let arguments: Vec<String> = arguments.collect();
        say(&program_error::told(&panic, &program, &arguments));
        ExitCode::from(EXIT_PROGRAM_ERROR)
    })
}

/// The process's command line. A negative number after an option is its value, which may then be out of range, and no option.
fn parse<P: Parser>() -> Result<P, clap::Error> {
    let arguments: Vec<OsString> = std::env::args_os().collect();
    parsed(&arguments).or_else(|error| {
        let one_too_many = matches!(
            error.kind(),
            ErrorKind::UnknownArgument
                | ErrorKind::InvalidSubcommand
                | ErrorKind::InvalidValue
                | ErrorKind::ArgumentConflict
                // A second recording, which only `--out` takes.
                | ErrorKind::MissingRequiredArgument
        );
        // `--json FILE`: the file is the word that is one too many.
        match json::in_one_word(&arguments).filter(|_| one_too_many) {
            Some(joined) => parsed(&joined),
            None => Err(error),
        }
    })
}

fn parsed<P: Parser>(arguments: &[OsString]) -> Result<P, clap::Error> {
    let command = with_negative_numbers(P::command());
    P::from_arg_matches(&command.try_get_matches_from(arguments)?)
}

fn with_negative_numbers(command: clap::Command) -> clap::Command {
    command
        .allow_negative_numbers(true)
        .mut_subcommands(with_negative_numbers)
}

/// An error and its causes on one line, outermost first; a cause that the one before it has told already is not told again.
pub fn told(error: &anyhow::Error) -> String {
    let mut text = String::new();
    for cause in error.chain().map(ToString::to_string) {
        if text.is_empty() {
            text = cause;
        } else if !text.ends_with(&cause) {
            text = format!("{text}: {cause}");
        }
    }
    one_line(&text)
}

/// One line on standard error, and the exit code for bad input.
pub fn refuse(message: &str) -> ExitCode {
    say(message);
    ExitCode::from(EXIT_BAD_INPUT)
}

/// One line on standard error; where that is closed, nobody listens.
fn say(message: &str) {
    let _ = writeln!(std::io::stderr(), "courier: {}", one_line(message));
}

/// Takes the words of a command line apart that no process was started with; the first is the program's name.
///
/// # Errors
/// Why they are none, in one line.
pub fn parse_from<P: Parser>(words: &[OsString]) -> Result<P, String> {
    parsed(words).map_err(|error| one_line(&usage_line(&error)))
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
    refuse(&usage_line(error))
}

fn usage_line(error: &clap::Error) -> String {
    let text = error.render().to_string();
    let lines = text
        .lines()
        .map(str::trim)
        .take_while(|line| !line.starts_with("Usage:"));
    let told: Vec<&str> = lines
        .filter(|line| !line.is_empty() && !line.starts_with("For more"))
        .collect();
    told.join(" ").trim_start_matches("error: ").to_owned()
}

/// Whoever read our output has closed it: nothing is wrong.
fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error
        .downcast_ref::<std::io::Error>()
        .is_some_and(|error| error.kind() == std::io::ErrorKind::BrokenPipe)
}

#[cfg(test)]
mod tests {
    use super::told;
    use anyhow::{Context, anyhow};

    #[test]
    fn a_cause_is_told_once() {
        let cause = anyhow!("term 2 is 1, wanted 0");
        let told_already = format!("model: {cause}");
        let error = Err::<(), _>(cause)
            .context(told_already)
            .context("file.json");
        assert_eq!(
            told(&error.unwrap_err()),
            "file.json: model: term 2 is 1, wanted 0"
        );
        let other = Err::<(), _>(anyhow!("no room"))
            .context("file.json")
            .unwrap_err();
        assert_eq!(told(&other), "file.json: no room");
    }
}
