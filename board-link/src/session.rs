//! A calibration session on a board: ordered, watched, ended.

use crate::{Link, Simulated};
use anyhow::{Result, bail};
use courier_sensor::calibration::Stage;
use courier_sensor::link::message::{Action, CalibrateOrder, Reply};
use courier_sensor::link::report::Progress;
use indicatif::ProgressBar;
use std::time::Duration;

/// Time between two looks at the progress, of the board's own, where nothing needs more.
pub const LOOK: Duration = Duration::from_millis(50);

/// Something with a link to a board.
pub trait Linked {
    /// The link.
    fn link(&mut self) -> &mut Link;
}

impl Linked for Link {
    fn link(&mut self) -> &mut Link {
        self
    }
}

impl Linked for Simulated {
    fn link(&mut self) -> &mut Link {
        &mut self.link
    }
}

/// Orders a session and waits for its end; `watch` is called at each look.
///
/// # Errors
/// The board refuses the order or cannot be reached, or `watch` fails. A refused result is no error: the ending says so.
pub fn run<B: Linked>(
    board: &mut B,
    order: &CalibrateOrder,
    look: Duration,
    bar: &ProgressBar,
    mut watch: impl FnMut(&mut B, &Progress) -> Result<()>,
) -> Result<Progress> {
    let Reply::Done = board.link().ask(Action::Calibrate(*order))? else {
        bail!("the board: found a strange reply to an order to calibrate")
    };
    bar.set_position(0);
    bar.set_length(u64::from(order.poses) + u64::from(order.held_out_poses));
    loop {
        board.link().pass(look)?;
        let now = progress(board.link())?;
        show(&now, order, bar);
        watch(board, &now)?;
        if now.ending.is_some() {
            return Ok(now);
        }
    }
}

/// How far the session is; a board that has restarted meanwhile has none. What was asked at that moment is lost, so it is
/// asked once more.
fn progress(link: &mut Link) -> Result<Progress> {
    let reply = link.ask(Action::Progress).or_else(|_| {
        link.reconnect()?;
        link.ask(Action::Progress)
    });
    let Reply::Progress(now) = reply? else {
        bail!("the board: found a strange reply to a question for its progress")
    };
    if now.stage == Stage::Finished && now.ending.is_none() {
        bail!("{}", restarted(link)?);
    }
    Ok(now)
}

fn restarted(link: &mut Link) -> Result<String> {
    let cause = link.status()?.reset;
    let message = match link.ask(Action::LastFault)? {
        Reply::LastFault(Some(fault)) => format!(", {}", fault.message),
        _ => String::new(),
    };
    Ok(format!(
        "the board: found no session any more, wanted the one that was ordered: it has restarted ({cause:?}{message})"
    ))
}

fn show(now: &Progress, order: &CalibrateOrder, bar: &ProgressBar) {
    let fitted = u64::from(order.poses);
    bar.set_position(match now.stage {
        Stage::Solving => {
            bar.set_message(format!("solving, {} of {}", now.done + 1, now.of));
            fitted + u64::from(order.held_out_poses)
        }
        Stage::HeldOut => fitted + u64::from(now.done),
        _ => u64::from(now.done),
    });
}
