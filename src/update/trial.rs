//! A new image on trial: it works like any other, but stores nothing, and goes back unless it is accepted in time.

use super::choice::has_accepted;
use super::journal::{self, ACCEPTED_MARKS, Kind, MarkError};
use super::mirror::{MirrorError, mirror};
use super::standing::{self, Bank};
use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};

/// Time that an image on trial has to be accepted, seconds: a host that waits for the board takes some five, a person who looks at it a
/// minute.
pub const TRIAL_S: u32 = 120;

/// The number of the running image if it is on trial: there is an image to go back to, and it was not yet accepted. `near` is the bank
/// that code runs from, `far` the other.
pub fn on_trial<F: ReadNorFlash>(near: &Bank, far: &Bank, far_flash: &mut F) -> Option<u32> {
    let number = near.number.filter(|number| Some(*number) > far.number)?;
    let before = far.header.as_ref().filter(|_| !has_accepted(far, near))?;
    standing::is_whole(far_flash, before).then_some(number)
}

/// How the running image stands, once start-up has brought its flash in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Standing {
    /// Its number, if it is on trial.
    pub trial: Option<u32>,
    /// Whether the calibration is where this image looks for it.
    pub moved: Result<(), MirrorError>,
}

/// What every image does at its start, before it looks into the slots: finds out whether it is on trial, ends an acceptance in which the
/// supply went, and moves the calibration if that lies beside it.
pub fn start<N: NorFlash, F: NorFlash>(near: &mut N, far: &mut F) -> Standing {
    let banks = (standing::read(near), standing::read(far));
    let trial = on_trial(&banks.0, &banks.1, far);
    let moved = mirror(near, far, trial.is_some()).map(|_| ());
    let ended = match trial {
        Some(_) => Ok(()),
        None => complete(far),
    };
    Standing {
        trial,
        moved: moved.and(ended.map_err(|_| MirrorError)),
    }
}

/// Accepts the running image: from now on it is the one that is started. To be called after the calibration was moved.
///
/// # Errors
/// [`MarkError`]; the image then still is on trial.
pub fn accept<F: NorFlash>(far: &mut F, number: u32) -> Result<(), MarkError> {
    let journal = journal::read(far);
    let there = match journal.number == number {
        true => journal.accepted,
        false => 0,
    };
    (there..ACCEPTED_MARKS).try_for_each(|_| journal::append(far, number, Kind::Accepted))
}

/// Ends an acceptance in which the supply went, before anything is stored.
fn complete<F: NorFlash>(far: &mut F) -> Result<(), MarkError> {
    let journal = journal::read(far);
    match journal.accepted {
        0 => Ok(()),
        _ => accept(far, journal.number),
    }
}

/// Refuses the running image: at the next start the one before comes back.
///
/// # Errors
/// [`MarkError`]; it then comes back once the trials are used up.
pub fn refuse<F: NorFlash>(far: &mut F, number: u32) -> Result<(), MarkError> {
    journal::append(far, number, Kind::Refused)
}
