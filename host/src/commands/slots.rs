//! `courier slots`.

use crate::board::Choice;
use crate::terminal::{print, print_json, table};
use anyhow::{Result, bail};
use courier_sensor::link::message::{Action, Reply};
use std::process::ExitCode;

/// List what both calibration slots of a board hold.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  courier --probe any slots")]
pub struct Args {
    /// Print JSON instead of the table.
    #[arg(long)]
    json: bool,
}

/// Asks and prints.
///
/// # Errors
/// The board cannot be reached or refuses.
pub fn run(args: &Args, choice: &Choice) -> Result<ExitCode> {
    let mut board = choice.open()?;
    let Reply::Slots(slots) = board.link.ask(Action::Slots)? else {
        bail!(super::STRANGE_REPLY)
    };
    board.close()?;
    if args.json {
        print_json(&slots)?;
        return Ok(ExitCode::SUCCESS);
    }
    let rows: Vec<Vec<String>> = slots
        .iter()
        .map(|slot| {
            let sequence = slot
                .sequence
                .map_or("-".to_owned(), |sequence| sequence.to_string());
            vec![slot.slot.to_string(), sequence, slot.state.to_string()]
        })
        .collect();
    print(&table(&["slot", "number", "state"], &rows))?;
    Ok(ExitCode::SUCCESS)
}
