//! Supply cuts during commits: after each the board must start with the calibration before the commit or the one after it.

use super::judge::Step;
use crate::board::Link;
use anyhow::{Context, Result, bail};
use board_link::session::Linked;
use courier_sensor::calibration::record::Calibration;
use courier_sensor::link::message::{Action, InForce, Reply, ResetCause, Source};
use std::time::Duration;

/// The interrupt takes what was put in force at its next sample.
const TAKEN: Duration = Duration::from_millis(1);
/// Attempts at reaching a board whose supply has come again.
const ATTEMPTS: u32 = 10;

/// What came of the cuts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cuts {
    /// Cuts.
    pub done: u32,
    /// Cuts that came before the commit had ended.
    pub hit: u32,
    /// Starts with one of both calibrations in force, of a cause that a supply can have.
    pub kept: u32,
}

/// Cuts the supply so often: `cut` begins to switch it off and on again and gives what is to be waited for, `open` reaches the board, which is
/// ordered to commit in between. What was in force before is stored again in the end. Each cut takes a page's erasure or two.
///
/// # Errors
/// The board has no calibration, does not come back, or the supply cannot be switched.
pub fn cut<B: Linked, W: FnOnce() -> Result<()>>(
    times: u32,
    mut open: impl FnMut() -> Result<B>,
    mut cut: impl FnMut(u32) -> Result<W>,
    mut watch: impl FnMut(u32),
) -> Result<Cuts> {
    let mut board = open()?;
    let first = stored(board.link())?.context(
        "the board: found no stored calibration in force, wanted one: `courier calibrate` makes one",
    )?;
    let (mut cuts, mut before) = (Cuts::default(), first.clone());
    for number in 0..times {
        let mut after = before.clone();
        after.made.uptime_s = after.made.uptime_s.wrapping_add(1);
        let wait = cut(number)?;
        let answered = commit(board.link(), &after);
        wait()?;
        drop(board);
        board = reach(&mut open)?;
        let status = board.link().status()?;
        let now = stored(board.link())?;
        let by_supply = matches!(status.reset, ResetCause::BrownOut | ResetCause::PowerOn);
        let known =
            now.as_ref() == Some(&after) || answered.is_err() && now.as_ref() == Some(&before);
        cuts.done += 1;
        cuts.hit += u32::from(answered.is_err());
        cuts.kept += u32::from(by_supply && known);
        before = now.unwrap_or(before);
        watch(cuts.done);
    }
    commit(board.link(), &first)?;
    Ok(cuts)
}

/// The verdict.
pub fn judged(cuts: &Cuts) -> Step {
    let found = format!(
        "{} of {} starts with one of both calibrations, {} cuts before the commit had ended",
        cuts.kept, cuts.done, cuts.hit
    );
    let passed = cuts.kept == cuts.done && cuts.hit > 0;
    Step::new(
        "supply cuts",
        passed,
        found,
        format!("{} starts, and some such cuts", cuts.done),
    )
}

/// The calibration in force, if it is stored.
fn stored(link: &mut Link) -> Result<Option<Calibration>> {
    if !matches!(link.status()?.in_force, InForce::Stored(_)) {
        return Ok(None);
    }
    match link.ask(Action::Read(Source::InForce))? {
        Reply::Calibration(calibration) => Ok(Some(calibration)),
        _ => bail!("the board: found a strange reply to a question for its calibration"),
    }
}

/// Loads and stores; an error may be a supply that has gone.
fn commit(link: &mut Link, calibration: &Calibration) -> Result<()> {
    link.ask(Action::load(calibration.clone()))?;
    link.pass(TAKEN)?;
    let lose_unknown = false;
    match link.ask(Action::Commit { lose_unknown })? {
        Reply::Place(_) => Ok(()),
        _ => bail!("the board: found a strange reply to a commit"),
    }
}

/// Reaches a board that has just been switched on.
fn reach<B>(open: &mut impl FnMut() -> Result<B>) -> Result<B> {
    for _ in 1..ATTEMPTS {
        if let Ok(board) = open() {
            return Ok(board);
        }
    }
    open().context("the board did not come back after its supply was cut")
}

#[cfg(test)]
mod tests {
    use super::*;
    use board_link::SimWire;
    use courier_sensor::geometry::Geometry;
    use courier_sensor::model::{ErrorModel, TermTable};
    use courier_sensor::update::layout::SLOTS_START;
    use hal_sim::board::SharedFlash;
    use hal_sim::presets;

    /// A board on this flash, switched on.
    fn open(flash: &SharedFlash) -> Result<Link> {
        flash.0.borrow_mut().power_up();
        let wire = SimWire::start(presets::ideal(1), 1, flash.clone())?;
        Link::connect(Box::new(wire))
    }

    fn with_a_calibration() -> SharedFlash {
        let flash = SharedFlash::erased(1);
        let mut link = open(&flash).unwrap();
        let mut calibration = Calibration::identity(Geometry::PAPER);
        calibration.model = ErrorModel::zero(TermTable::equation_3());
        calibration.device = link.hello().device;
        commit(&mut link, &calibration).unwrap();
        flash
    }

    /// The supply goes at another of the flash's steps each time.
    #[test]
    fn cuts_of_a_sound_board_keep_one_of_both_calibrations() {
        let flash = with_a_calibration();
        let supply = flash.clone();
        let go = |number: u32| {
            supply.0.borrow_mut().cut_after(60 * u64::from(number));
            Ok(|| Ok(()))
        };
        let cuts = cut(5, || open(&flash), go, |_| {}).unwrap();
        assert_eq!((cuts.done, cuts.kept), (5, 5), "{cuts:?}");
        assert!(cuts.hit > 0, "{cuts:?}");
        assert_eq!(judged(&cuts).passed, Some(true));
    }

    #[test]
    fn a_flash_that_loses_both_slots_fails() {
        let flash = with_a_calibration();
        let broken = flash.clone();
        let go = |_| {
            broken.0.borrow_mut().cut_after(10);
            let broken = broken.clone();
            Ok(move || {
                (0..2).for_each(|slot| {
                    broken
                        .0
                        .borrow_mut()
                        .force(SLOTS_START as usize + slot * 2048 + 40, &[0x5A; 8])
                });
                Ok(())
            })
        };
        let cuts = cut(2, || open(&flash), go, |_| {}).unwrap();
        assert_eq!((cuts.done, cuts.kept), (2, 0), "{cuts:?}");
        assert_eq!(judged(&cuts).passed, Some(false));
        let nothing_hit = Cuts {
            done: 3,
            hit: 0,
            kept: 3,
        };
        assert_eq!(
            judged(&nothing_hit).passed,
            Some(false),
            "a test that tests nothing"
        );
        assert!(cut(1, || open(&SharedFlash::erased(2)), go, |_| {}).is_err());
    }
}
