//! Starts as they happen on a bench: error flags left over, option bytes of another mode, a converter that is silent, a debugger that halts.

use super::fixture::{judge, start, start_in, world};
use crate::image::Image;
use crate::peripheral::flash::Start;
use crate::processor::Processor;
use crate::time::from_us;
use crate::wire::Board;
use anyhow::{Context, Result, bail, ensure};
use board_link::Link;
use courier_sensor::calibration::record::Calibration;
use courier_sensor::geometry::Geometry;
use courier_sensor::link::message::{Action, Reply, ResetCause};
use courier_sensor::link::telemetry::Channels;
use courier_sensor::model::{ErrorModel, TermTable};
use std::time::Duration;

/// PGSERR, bit 7 of the flash's status: what a debug probe's own programming may leave.
const PROGRAM_SEQUENCE_ERROR: u32 = 1 << 7;
/// So long a debugger halts the processor, and BUSY is silent.
const HALT_US: u64 = 10_000;
/// Instants of 50 us in them.
const INSTANTS: u32 = 200;
/// So long the board may take until it has started again.
const RECOVERY: Duration = Duration::from_millis(50);
/// Every other frame is looked at: all of them are too many for the ring.
const EVERY: u16 = 2;
/// Instants that may lie between a conversion and its frame's arrival, twice.
const SLACK_INSTANTS: u32 = 40;

/// A commit on error flags of the past: they are cleared, and it is stored.
pub fn flags(image: &Image) -> Result<String> {
    let past = Start {
        errors: PROGRAM_SEQUENCE_ERROR,
        ..Start::default()
    };
    let board = Board::new(start(image, 4, past)?);
    let result = commit(&board).and_then(|reply| match reply {
        Ok(Reply::Place(_)) => Ok("a commit is stored".into()),
        Ok(reply) => bail!("found {reply:?} as the reply to a commit, wanted its place"),
        Err(refusal) => Err(refusal.context("a commit on error flags of the past")),
    });
    judge(&mut board.processor.borrow_mut(), result)
}

/// A commit in single-bank mode, where the pages are others: it is refused, and nothing is erased.
pub fn single_bank(image: &Image) -> Result<String> {
    let mut one = Start::default();
    one.options.set_dbank(false);
    let board = Board::new(start(image, 5, one)?);
    let result = commit(&board).and_then(|reply| match reply {
        Err(refusal) => Ok(format!("a commit is refused: {refusal:#}")),
        Ok(reply) => bail!("found {reply:?} as the reply to a commit, wanted a refusal"),
    });
    judge(&mut board.processor.borrow_mut(), result)
}

/// Loads a calibration that corrects nothing and asks for it to be stored; the board's answer.
fn commit(board: &Board) -> Result<Result<Reply>> {
    let mut link = Link::connect(Box::new(board.clone()))?;
    let mut calibration = Calibration::identity(Geometry::PAPER);
    calibration.model = ErrorModel::zero(TermTable::equation_3());
    let loaded = link.ask(Action::take_over(calibration))?;
    ensure!(
        loaded == Reply::Done,
        "found {loaded:?} as the reply to a load"
    );
    let lose_unknown = false;
    Ok(link.ask(Action::Commit { lose_unknown }))
}

/// The processor is halted for 10 ms: as many instants are missed, and the board says so.
pub fn halted(image: &Image) -> Result<String> {
    count_missed(image, 6, INSTANTS, |processor| {
        processor.chip().halt(from_us(HALT_US));
        Ok(())
    })
}

/// BUSY is silent for 10 ms: as many instants are missed, and the board says so.
pub fn silent(image: &Image) -> Result<String> {
    // The background calls the interrupt by hand at every sixth instant or later: those are not missed, but frames of a fault.
    count_missed(image, 7, INSTANTS / 6 * 5, |processor| {
        processor.chip().around.silent = true;
        processor.run(from_us(HALT_US))?;
        processor.chip().around.silent = false;
        Ok(())
    })
}

fn count_missed(
    image: &Image,
    seed: u64,
    least: u32,
    disturb: fn(&mut Processor) -> Result<()>,
) -> Result<String> {
    let (world, flash) = world(seed)?;
    let board = Board::new(start_in(image, world.clone(), flash, Start::default())?);
    let result = disturbed(&board, least, disturb, || world.conversions());
    judge(&mut board.processor.borrow_mut(), result)
}

/// Check bits that are wrong in the code: the image may not go on over it as if a slot were torn.
pub fn code(image: &Image) -> Result<String> {
    let board = Board::new(start(image, 9, Start::default())?);
    let result = stops(&board);
    judge(&mut board.processor.borrow_mut(), result)
}

fn stops(board: &Board) -> Result<String> {
    let mut link = Link::connect(Box::new(board.clone()))?;
    {
        let mut processor = board.processor.borrow_mut();
        processor.may_reset = true;
        processor.chip().disturb_code();
    }
    link.pass(RECOVERY)?;
    let resets = board.processor.borrow().resets();
    ensure!(
        resets == 1,
        "found {resets} resets, wanted one: the code is corrupt"
    );
    link.reconnect()?;
    let cause = link.status()?.reset;
    ensure!(
        matches!(cause, ResetCause::Panic | ResetCause::HardFault),
        "found cause {cause:?}, wanted a panic or a fault that is kept"
    );
    Ok("a reset, and its reason is kept".into())
}

/// How far the frames' numbers and the board's count of missed instants come, against the conversions that there were.
fn disturbed(
    board: &Board,
    least: u32,
    disturb: fn(&mut Processor) -> Result<()>,
    conversions: impl Fn() -> u64,
) -> Result<String> {
    let mut link = Link::connect(Box::new(board.clone()))?;
    link.stream(Channels::POSE, EVERY)?;
    let (first, began) = (last_number(&mut link)?, conversions());
    let before = link.status()?.missed;
    disturb(&mut board.processor.borrow_mut())?;
    let (last, ended) = (last_number(&mut link)?, conversions());
    let missed = link.status()?.missed.wrapping_sub(before);
    ensure!(
        (least.saturating_sub(SLACK_INSTANTS)..=INSTANTS + SLACK_INSTANTS).contains(&missed),
        "found {missed} instants missed, wanted {least} to {INSTANTS}"
    );
    let (numbers, there_were) = (last.wrapping_sub(first), (ended - began) as u32);
    ensure!(
        numbers.abs_diff(there_were) <= SLACK_INSTANTS,
        "found frames numbered {numbers} further after {there_were} conversions: instants were missed and have no number"
    );
    Ok(format!(
        "{missed} instants missed and said so; frames {numbers} further after {there_were} conversions"
    ))
}

/// Number of the last frame that came within 20 ms.
fn last_number(link: &mut Link) -> Result<u32> {
    let mut last = None;
    for _ in 0..20 {
        link.pass(Duration::from_millis(1))?;
        link.listen(|sample| {
            last = Some(sample.sequence);
            Ok(())
        })?;
    }
    last.context("found no samples, wanted some")
}
