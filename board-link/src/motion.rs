//! Moving a courier over its board, and waiting until it rests.

use crate::Link;
use anyhow::{Result, bail};
use courier_sensor::drivers::motion::Target;
use courier_sensor::link::message::{Action, Reply};
use std::time::Duration;

/// Time between two looks.
const LOOK: Duration = Duration::from_millis(20);
/// Looks until a motion is given up: 60 s.
const LOOKS: u32 = 3000;

/// Orders a motion; returns at once.
///
/// # Errors
/// The board refuses or cannot be reached.
pub fn start(link: &mut Link, target: Target, speed_m_per_s: f32) -> Result<()> {
    let Reply::Done = link.ask(Action::GoTo {
        target,
        speed_m_per_s,
    })?
    else {
        bail!("the board: wanted a plain yes to a motion")
    };
    Ok(())
}

/// Waits until the courier rests.
///
/// # Errors
/// It does not within 60 s of the board's time, or the board cannot be reached.
pub fn rest(link: &mut Link) -> Result<()> {
    for _ in 0..LOOKS {
        link.pass(LOOK)?;
        let Reply::Status(status) = link.ask(Action::Status)? else {
            bail!("the board: wanted a status")
        };
        if !status.moving {
            return Ok(());
        }
    }
    bail!("the motion controller: found no rest within 60 s, wanted one")
}

/// Goes there and waits.
///
/// # Errors
/// As [`start`] and [`rest`].
pub fn go(link: &mut Link, target: Target, speed_m_per_s: f32) -> Result<()> {
    start(link, target, speed_m_per_s)?;
    rest(link)
}
