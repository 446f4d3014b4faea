//! The commands, one file each: `Args` for the options, `run` for the work.

use crate::board::Choice;
use anyhow::{Result, ensure};
use courier_sensor::calibration::slots::Place;
use courier_sensor::drivers::motion::Target;
use std::process::ExitCode;

mod calibrate_guided;
mod calibrate_joint;
mod calibrate_text;
mod diagnose_explained;
pub mod diagnose_many;
mod fleet_text;
mod load_map;
mod log_kept;
mod log_words;
mod maps_mark;
mod record_guided;
mod status_map;
mod status_next;

/// What a reply of the wrong kind is told as.
const STRANGE_REPLY: &str = "the board: found a reply of another kind than was asked for";

/// Where the record lies that is in force now, and what was done with it.
fn place(done: &str, place: &Place) -> String {
    format!("{done}: slot {}, number {}", place.slot, place.sequence)
}

/// `X,Y,THETA` in mm, mm and degrees.
fn target(text: &str) -> Result<Target, String> {
    let numbers: Vec<f32> = text
        .split(',')
        .map_while(|part| part.trim().parse().ok())
        .collect();
    match numbers[..] {
        [x_mm, y_mm, theta_deg]
            if numbers.iter().all(|number| number.is_finite()) && text.split(',').count() == 3 =>
        {
            Ok(Target {
                x_m: x_mm * 1.0e-3,
                y_m: y_mm * 1.0e-3,
                theta_rad: theta_deg.to_radians(),
            })
        }
        _ => Err("wanted three numbers: mm, mm, degrees".to_owned()),
    }
}

/// Makes the list of commands from the names of variants and modules: those that need no board, then those that do.
macro_rules! commands {
    (alone { $($alone:ident => $alone_module:ident,)* } with_board { $($with:ident => $with_module:ident,)* }) => {
        $(pub mod $alone_module;)*
        $(pub mod $with_module;)*

        /// What `courier` can do.
        #[derive(Debug, clap::Subcommand)]
        pub enum Command {
            $(#[allow(missing_docs)] $alone($alone_module::Args),)*
            $(#[allow(missing_docs)] $with($with_module::Args),)*
        }

        impl Command {
            /// Does it.
            ///
            /// # Errors
            /// Bad input or a refusal, to be told in one line.
            pub fn run(self, board: &Choice) -> Result<ExitCode> {
                match self {
                    $(Self::$alone(args) => {
                        ensure!(!board.is_given(), "found a board named, wanted none: `{}` needs no board", stringify!($alone_module));
                        args.files().check()?;
                        $alone_module::run(&args)
                    })*
                    $(Self::$with(args) => {
                        board.files(args.files()).check()?;
                        $with_module::run(&args, board)
                    })*
                }
            }
        }
    };
}

// A further command is a file and a line here.
commands! {
    alone {
        Demo => demo,
        Convert => convert,
        Encoder => encoder,
        Replay => replay,
        Diagnose => diagnose,
        Blind => blind,
        Check => check,
        Compare => compare,
        Isolability => isolability,
        Map => map,
        Fleet => fleet,
        Trace => trace,
        Completions => completions,
        Man => man,
    }
    with_board {
        Status => status,
        Calibrate => calibrate,
        Abort => abort,
        Monitor => monitor,
        Record => record,
        Slots => slots,
        Maps => maps,
        Commit => commit,
        Rollback => rollback,
        Recalibrate => recalibrate,
        Export => export,
        Import => import,
        Load => load,
        Log => log,
        Reset => reset,
        Acceptance => acceptance,
        Update => update,
    }
}
