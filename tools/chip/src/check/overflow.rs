//! A stack that runs over, of the background and of a sampling interrupt: the memory protection faults at the first access below RAM, the board
//! restarts, says why, and has lost nothing.

use super::fixture::{judge, start};
use crate::image::Image;
use crate::peripheral::flash::Start;
use crate::registers;
use crate::rule::Rule;
use crate::wire::Board;
use anyhow::{Context, Result, bail, ensure};
use board_link::Link;
use courier_sensor::calibration::record::Calibration;
use courier_sensor::geometry::Geometry;
use courier_sensor::link::message::{Action, InForce, Reply, ResetCause};
use courier_sensor::model::{ErrorModel, TermTable};
use std::time::Duration;

/// From the fault to the link's answer: the restart and the start.
const RESTART: Duration = Duration::from_millis(200);
/// MMARVALID and DACCVIOL of the fault's status (ARMv7-M ARM, B3.2.15), which is the last word of what the board tells.
const PROTECTION: u32 = 0x82;

pub fn run(image: &Image) -> Result<String> {
    let line = 16 + registers::interrupt("DMA1_CHANNEL2");
    for (seed, what, exception) in [
        (18, "the background", 0),
        (19, "the sampling interrupt", line),
    ] {
        let board = Board::new(start(image, seed, Start::default())?);
        let result = overflows(&board, exception).with_context(|| what.to_owned());
        // It is meant to fault.
        board.processor.borrow_mut().findings().forgive(Rule::Fault);
        judge(&mut board.processor.borrow_mut(), result)?;
    }
    Ok(
        "a stack that runs over, of background and sampling interrupt, is told and loses nothing"
            .into(),
    )
}

fn overflows(board: &Board, exception: u16) -> Result<String> {
    let mut link = Link::connect(Box::new(board.clone()))?;
    let mut calibration = Calibration::identity(Geometry::PAPER);
    calibration.model = ErrorModel::zero(TermTable::equation_3());
    link.ask(Action::take_over(calibration))?;
    let lose_unknown = false;
    link.ask(Action::Commit { lose_unknown })?;
    let before = link.status()?.in_force;
    ensure!(
        matches!(before, InForce::Stored(_)),
        "found {before:?}, wanted it stored"
    );
    {
        let mut processor = board.processor.borrow_mut();
        processor.may_reset = true;
        processor.spend_stack(exception)?;
    }
    link.pass(RESTART)?;
    link.reconnect().context("no restart in time")?;
    let status = link.status()?;
    let Reply::LastFault(Some(fault)) = link.ask(Action::LastFault)? else {
        bail!("found no fault, wanted what was kept over the restart")
    };
    let last = fault.message.rsplit(' ').next();
    let code: u32 = last.and_then(|word| word.parse().ok()).unwrap_or(0);
    ensure!(
        fault.cause == ResetCause::HardFault
            && fault.message.starts_with("stack overflow")
            && code & PROTECTION == PROTECTION,
        "found {fault:?}, wanted a stack overflow by memory protection, bits {PROTECTION} of the status"
    );
    ensure!(
        status.in_force == before,
        "found {:?} in force after the restart, wanted {before:?}",
        status.in_force
    );
    Ok(String::new())
}
