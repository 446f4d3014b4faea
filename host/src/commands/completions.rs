//! `courier completions SHELL`.

use crate::output::{Files};
use crate::cli::Cli;
use anyhow::Result;
use clap::CommandFactory;
use clap_complete::Shell;
use std::io::Write as _;
use std::process::ExitCode;

/// Print completions for a shell.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  courier completions bash > ~/.local/share/bash-completion/completions/courier"
)]
pub struct Args {
    /// The shell to complete in.
    shell: Shell,
}

impl Args {
    /// The files that it reads and writes.
    pub fn files(&self) -> Files {
        Files::default()
    }
}

/// Prints the script.
///
/// # Errors
/// Standard output is closed or full.
pub fn run(args: &Args) -> Result<ExitCode> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "courier", &mut script);
    std::io::stdout().lock().write_all(&script)?;
    Ok(ExitCode::SUCCESS)
}
