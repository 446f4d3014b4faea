//! A calibration session on a board: ordered, watched, ended.

use super::{Link, Simulated};
use anyhow::{Result, bail};
use courier_sensor::calibration::Stage;
use courier_sensor::link::message::{Action, CalibrateOrder, Reply};
use courier_sensor::link::report::Progress;
use indicatif::ProgressBar;
use std::time::Duration;

/// Time between two looks at the progress, of the board's own, where nothing needs more.
pub const LOOK: Duration = Duration::from_millis(50);
/// A board that makes a joint step answers when it has: seconds on the target, more where a step is fitted again.
const SOLVING: Duration = Duration::from_secs(60);

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
        let Reply::Progress(now) = board.link().ask_patiently(Action::Progress, SOLVING)? else {
            bail!("the board: found a strange reply to a question for its progress")
        };
        let before = match now.stage {
            Stage::HeldOut => u64::from(order.poses),
            _ => 0,
        };
        bar.set_position(before + u64::from(now.done));
        watch(board, &now)?;
        if now.ending.is_some() {
            return Ok(now);
        }
    }
}
