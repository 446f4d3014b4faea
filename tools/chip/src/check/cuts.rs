//! The supply goes in the middle of a commit: at every operation of the flash controller, before it and within it, and at every
//! eighth of the page's erase; every second time it dips only, and RAM keeps what it held. Afterwards either the old calibration is in force or the new one, and a commit goes through again.

use super::fixture::{judge, start_in, world};
use crate::image::Image;
use crate::peripheral::flash::Start;
use crate::wire::Board;
use anyhow::{Context, Result, bail, ensure};
use board_link::Link;
use courier_sensor::calibration::record::Calibration;
use courier_sensor::geometry::Geometry;
use courier_sensor::link::message::{Action, Reply, ResetCause, Source};
use courier_sensor::model::{ErrorModel, TermTable};
use hal_sim::board::SharedFlash;
use std::time::Duration;

/// Steps of `hal-sim`'s flash to an operation: eight bytes of a double word, eight eighths of an erase.
const STEPS: u64 = 8;
/// So long the reply to a commit is waited for: an erase and the programming take 30 ms.
const COMMIT: Duration = Duration::from_millis(60);

pub fn run(image: &Image) -> Result<String> {
    let (world, flash) = world(12)?;
    let board = Board::new(start_in(image, world, flash.clone(), Start::default())?);
    let result = cut(&board, &flash);
    judge(&mut board.processor.borrow_mut(), result)
}

fn cut(board: &Board, flash: &SharedFlash) -> Result<String> {
    board.processor.borrow_mut().may_reset = true;
    let mut link = Link::connect(Box::new(board.clone()))?;
    store(&mut link, 1).context("the first commit")?;
    let before = flash.0.borrow().steps();
    store(&mut link, 2).context("the second commit")?;
    let steps = flash.0.borrow().steps() - before;
    let (mut old, mut kept, mut cuts) = (2, 0, 0);
    for cut in (0..=steps).filter(|step| *step < STEPS || step % (STEPS / 2) == 0) {
        let dips = cuts % 2 == 1;
        board.processor.borrow_mut().dips = dips;
        let told = try_one(&mut link, flash, cut, old + 1, dips);
        let mark = told.with_context(|| format!("the supply goes after {cut} of {steps} steps"))?;
        ensure!(
            mark == old || mark == old + 1,
            "the supply went after {cut} of {steps} steps: found calibration {mark} in force, wanted {old} or {}",
            old + 1
        );
        (cuts, kept) = (cuts + 1, kept + u32::from(mark == old));
        if mark == old {
            store(&mut link, old + 1)
                .with_context(|| format!("a commit after a cut at {cut} of {steps} steps"))?;
        }
        old += 1;
    }
    ensure!(
        kept > 0 && kept < cuts,
        "found {kept} of {cuts} cuts that left the old calibration, wanted some of both kinds"
    );
    Ok(format!(
        "{} operations of the flash a commit, {cuts} cuts: {kept} left the old calibration, {} the new one",
        steps / STEPS,
        cuts - kept
    ))
}

/// A commit with a cut after so many steps; the mark of the calibration that is in force after the start that follows.
fn try_one(link: &mut Link, flash: &SharedFlash, cut: u64, mark: u32, dips: bool) -> Result<u32> {
    load(link, mark)?;
    flash.0.borrow_mut().cut_after(cut);
    let commit = Action::Commit {
        lose_unknown: false,
    };
    let stored = link.ask_patiently(commit, COMMIT).is_ok();
    if stored {
        // It went through before the cut.
        flash.0.borrow_mut().power_up();
        link.restart()?;
    } else {
        link.reconnect()?;
        let cause = link.status()?.reset;
        let wanted = match dips {
            true => ResetCause::BrownOut,
            false => ResetCause::PowerOn,
        };
        ensure!(
            cause == wanted,
            "found {cause:?} as the cause of the reset, wanted {wanted:?}"
        );
    }
    let found = in_force(link)?;
    ensure!(!stored || found == mark, "told as stored, and lost");
    Ok(found)
}

fn load(link: &mut Link, mark: u32) -> Result<()> {
    let mut calibration = Calibration::identity(Geometry::PAPER);
    calibration.model = ErrorModel::zero(TermTable::equation_3());
    calibration.made.uptime_s = mark;
    let loaded = link.ask(Action::take_over(calibration))?;
    ensure!(
        loaded == Reply::Done,
        "found {loaded:?} as the reply to a load"
    );
    Ok(())
}

fn store(link: &mut Link, mark: u32) -> Result<()> {
    load(link, mark)?;
    let lose_unknown = false;
    match link.ask(Action::Commit { lose_unknown })? {
        Reply::Place(_) => Ok(()),
        other => bail!("found {other:?} as the reply to a commit, wanted its place"),
    }
}

fn in_force(link: &mut Link) -> Result<u32> {
    match link.ask(Action::Read(Source::InForce))? {
        Reply::Calibration(calibration) => Ok(calibration.made.uptime_s),
        other => bail!("found {other:?}, wanted the calibration in force"),
    }
}
