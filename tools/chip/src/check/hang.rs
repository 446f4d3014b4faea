//! A hang leaves its place, whether the background hangs or a sampling interrupt, and after three in a row the board leaves alone what is
//! stored.

use super::fixture::{judge, start};
use crate::image::Image;
use crate::peripheral::flash::Start;
use crate::registers;
use crate::wire::Board;
use anyhow::{Context, Result, bail, ensure};
use board_link::Link;
use courier_sensor::link::message::{Action, FaultReport, Reply, ResetCause};
use std::time::Duration;

/// In service for so long before each hang.
const SERVICE: Duration = Duration::from_millis(50);
/// The board looks for a hang of the background for 0.9 s, and for one of a sampling interrupt for 0.2 s; start-up takes 0.02 s.
const BACKGROUND: Duration = Duration::from_millis(950);
const INTERRUPT: Duration = Duration::from_millis(250);

pub fn run(image: &Image) -> Result<String> {
    let board = Board::new(start(image, 15, Start::default())?);
    board.processor.borrow_mut().may_reset = true;
    let result = hangs(&board);
    judge(&mut board.processor.borrow_mut(), result)
}

fn hangs(board: &Board) -> Result<String> {
    let mut link = Link::connect(Box::new(board.clone()))?;
    let line = |name: &str| 16 + registers::interrupt(name);
    // Nobody sees two faults in a row as more than chance.
    for (what, exception, patience) in [
        ("the background", 0, BACKGROUND),
        ("the start of a reading", line("EXTI9_5"), INTERRUPT),
        ("the sampling interrupt", line("DMA1_CHANNEL2"), INTERRUPT),
    ] {
        ensure!(
            !link.status()?.health.safe_mode,
            "safe mode before {what} hangs, wanted it after three faults in a row"
        );
        link.pass(SERVICE)?;
        let place = board.processor.borrow_mut().hang(exception)?;
        let found = fault(&mut link, patience).with_context(|| format!("{what} hangs"))?;
        ensure!(
            found.cause == ResetCause::Watchdog && found.program_counter == place,
            "{what} hangs at {place:#010x}: found {found:?}, wanted that place and the watchdog"
        );
    }
    let health = link.status()?.health;
    ensure!(
        health.safe_mode && health.faults_in_a_row == 3,
        "found {health:?} after three faults in a row, wanted safe mode"
    );
    Ok("a hang of background and of both sampling interrupts leaves its place; three in a row are safe mode".into())
}

/// What the next start tells of the fault.
fn fault(link: &mut Link, patience: Duration) -> Result<FaultReport> {
    link.pass(patience)?;
    link.reconnect().context("no restart in time")?;
    match link.ask(Action::LastFault)? {
        Reply::LastFault(Some(report)) => Ok(report),
        Reply::LastFault(None) => bail!("found no fault, wanted the place of the hang"),
        _ => bail!("a strange reply to a question for the last fault"),
    }
}
