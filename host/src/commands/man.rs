//! `courier man`.

use crate::cli::Cli;
use crate::output::{self, Files, Kind};
use crate::terminal::print;
use anyhow::{Context, Result};
use clap::CommandFactory;
use clap_mangen::Man;
use std::path::PathBuf;
use std::process::ExitCode;

/// Print a manual page, or write all of them into a folder.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  courier man | man -l -\n  courier man record | man -l -\n  courier man --into ~/.local/share/man/man1"
)]
pub struct Args {
    /// The command whose page is printed [default: the page of `courier` itself].
    command: Option<String>,
    /// Write the page of `courier` and one of each command into this folder, which is made if need be.
    #[arg(long, value_name = "DIR", conflicts_with = "command")]
    into: Option<PathBuf>,
}

/// What is in the head of a page that is replaced.
const PAGE: Kind = Kind::Page {
    made_by: ".TH courier",
};

impl Args {
    /// The files that it reads and writes: pages in the folder, each of which is checked where it is written.
    pub fn files(&self) -> Files {
        Files::default()
    }
}

/// Prints the page, or writes all.
///
/// # Errors
/// There is no such command, or the folder cannot be written.
pub fn run(args: &Args) -> Result<ExitCode> {
    let pages = pages()?;
    if let Some(folder) = &args.into {
        let told = || format!("--into: {}: wanted a folder that can be written", folder.display());
        std::fs::create_dir_all(folder).with_context(told)?;
        for (name, page) in &pages {
            output::write(&folder.join(format!("{name}.1")), PAGE, page.as_bytes())?;
        }
        return Ok(ExitCode::SUCCESS);
    }
    let command = args.command.as_ref();
    let wanted = command.map_or("courier".to_owned(), |command| format!("courier-{command}"));
    let found = pages.iter().find(|(name, _)| *name == wanted);
    let told = || {
        let asked = command.map_or("", String::as_str);
        format!("man: found {asked:?}, wanted a command; `courier --help` lists them")
    };
    let (_, page) = found.with_context(told)?;
    print(page.trim_end())?;
    Ok(ExitCode::SUCCESS)
}

/// Names and texts of all pages.
fn pages() -> Result<Vec<(String, String)>> {
    // Options of the board are those of all commands: they are in the page of `courier`.
    let command = Cli::command();
    let alone = command.get_subcommands().map(|command| {
        let name = format!("courier-{}", command.get_name());
        (name.clone(), command.clone().name(name))
    });
    let mut pages = vec![("courier".to_owned(), command.clone())];
    pages.extend(alone.filter(|(_, command)| !command.is_hide_set()));
    let text = |(name, command): (String, clap::Command)| {
        let mut page = Vec::new();
        Man::new(command.disable_help_subcommand(true)).render(&mut page)?;
        Ok((name, String::from_utf8(page)?))
    };
    pages.into_iter().map(text).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_has_a_page_with_its_options() {
        let pages = pages().unwrap();
        assert_eq!(pages.len(), 1 + Cli::command().get_subcommands().count());
        for (name, page) in &pages {
            assert!(page.contains(&format!(".TH {name} 1")), "{name}: {page}");
            assert!(page.contains(".SH SYNOPSIS"), "{name}");
        }
        let (_, replay) = pages.iter().find(|(name, _)| name == "courier-replay").unwrap();
        assert!(replay.contains("\\-\\-json"), "{replay}");
    }

    #[test]
    fn a_command_that_is_none_is_refused() {
        let args = Args {
            command: Some("fly".to_owned()),
            into: None,
        };
        let told = run(&args).unwrap_err().to_string();
        assert!(told.contains("\"fly\"") && told.contains("wanted"), "{told}");
    }

    #[test]
    fn all_pages_are_written_into_a_folder() {
        let folder = tempfile::tempdir().unwrap();
        let args = Args {
            command: None,
            into: Some(folder.path().join("man1")),
        };
        run(&args).unwrap();
        let written = std::fs::read_to_string(folder.path().join("man1/courier-record.1")).unwrap();
        assert!(written.contains("courier\\-record"), "{written}");
    }
}
