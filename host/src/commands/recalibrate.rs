//! `courier recalibrate`.

use crate::board::Choice;
use crate::json::Json;
use crate::output::{Files, Kind};
use anyhow::{Result, bail};
use courier_sensor::calibration::recalibration::{Mode, Order, Recalibration};
use courier_sensor::calibration::slots::Place;
use courier_sensor::link::message::{Action, BoardStatus, Reply};
use serde::Serialize;
use std::process::ExitCode;

/// Keep the calibration true while the courier works: show a candidate, accept or reject it, or say what becomes of candidates.
///
/// The board estimates from ordinary motion what has changed since the calibration. A candidate is proposed when it beats the
/// calibration in force on readings that neither has seen, and the position surely gains: docs/in-service.md. The calibration before
/// is one `courier rollback` away.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  courier --sim-flash board.bin recalibrate\n  courier --sim-flash board.bin recalibrate automatic")]
pub struct Args {
    /// What to do; without it, show how it stands.
    #[arg(value_enum)]
    order: Option<Word>,
    #[command(flatten)]
    json: Json,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum Word {
    /// Look for no candidate, from now on and over restarts.
    Off,
    /// Propose candidates, from now on and over restarts: as boards do unless told otherwise.
    Propose,
    /// Store candidates and put them in force, from now on and over restarts.
    Automatic,
    /// Store the candidate that is proposed and put it in force.
    Accept,
    /// Propose none until another calibration comes in force or a mode is set.
    Reject,
}

impl Word {
    const fn order(self) -> Order {
        match self {
            Self::Off => Order::Set(Mode::Off),
            Self::Propose => Order::Set(Mode::Propose),
            Self::Automatic => Order::Set(Mode::Automatic),
            Self::Accept => Order::Accept,
            Self::Reject => Order::Reject,
        }
    }
}

/// What `--json` writes.
const ANSWER: Kind = Kind::json("an answer of `courier recalibrate`", &["recalibration", "stored"]);

#[derive(Serialize)]
struct Output {
    recalibration: Recalibration,
    /// Where a candidate is stored that came in force by this command.
    stored: Option<Place>,
}

impl Args {
    /// The files that it reads and writes.
    pub fn files(&self) -> Files {
        Files::default().json(&self.json, ANSWER)
    }
}

/// Asks and prints.
///
/// # Errors
/// The board cannot be reached or refuses; what was in force still is.
pub fn run(args: &Args, choice: &Choice) -> Result<ExitCode> {
    let mut board = choice.open()?;
    let order = args.order.map(Word::order);
    let stored = match order.map(|order| board.link.ask(Action::Recalibrate(order))).transpose()? {
        None | Some(Reply::Done) => None,
        Some(Reply::Place(place)) => Some(place),
        Some(_) => bail!(super::STRANGE_REPLY),
    };
    let Reply::Status(BoardStatus { recalibration, .. }) = board.link.ask(Action::Status)? else {
        bail!(super::STRANGE_REPLY)
    };
    board.close()?;
    let output = Output { recalibration, stored };
    args.json.tell(ANSWER, &output, || text(&output))?;
    Ok(ExitCode::SUCCESS)
}

fn text(output: &Output) -> String {
    let place = output.stored.as_ref().map(|place| super::place("stored and in force", place) + "\n");
    format!("{}{}", place.unwrap_or_default(), output.recalibration)
}
