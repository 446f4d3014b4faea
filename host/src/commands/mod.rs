//! The commands, one file each: `Args` for the options, `run` for the work.

use anyhow::Result;
use std::process::ExitCode;

/// Makes the list of commands from the names of variants and modules.
macro_rules! commands {
    ($($variant:ident => $module:ident),* $(,)?) => {
        $(pub mod $module;)*

        /// What `courier` can do.
        #[derive(Debug, clap::Subcommand)]
        pub enum Command {
            $(#[allow(missing_docs)] $variant($module::Args),)*
        }

        impl Command {
            /// Does it.
            ///
            /// # Errors
            /// Bad input or a refusal, to be told in one line.
            pub fn run(self) -> Result<ExitCode> {
                match self {
                    $(Self::$variant(args) => $module::run(&args),)*
                }
            }
        }
    };
}

// A further command is a file and a line here.
commands! {
    Replay => replay,
    Completions => completions,
}
