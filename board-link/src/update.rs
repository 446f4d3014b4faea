//! A new firmware for a board: sent, restarted on trial, and kept or given up.

use crate::Link;
use crate::image::Image;
use anyhow::{Result, bail};
use courier_sensor::link::message::{Action, Reply};
use courier_sensor::update::install::Progress;
use courier_sensor::update::order::{PIECE_BYTES, UpdateOrder, UpdateStatus};
use heapless::Vec;
use indicatif::ProgressBar;
use std::time::Duration;

/// Time between two looks while the board checks, of its own.
const LOOK: Duration = Duration::from_millis(20);
/// Looks until a check that does not end is given up: a minute.
const LOOKS: u32 = 3000;
/// Times that a piece whose answer was lost is asked for, before the board is given up.
const ATTEMPTS: u32 = 3;

/// Gives an order and tells how the update then stands.
///
/// # Errors
/// The board refuses, by name, or cannot be reached.
pub fn ask(link: &mut Link, order: UpdateOrder) -> Result<UpdateStatus> {
    match link.ask(Action::Update(order))? {
        Reply::Update(status) => Ok(status),
        _ => bail!("the board: found a strange reply to an order about an update"),
    }
}

/// Sends an image and has it checked and installed: it is on trial after the next restart. `bar` counts its bytes twice: sent, checked.
///
/// # Errors
/// The board refuses it, or cannot be reached. What runs still does.
pub fn send(link: &mut Link, image: &Image, allow_older: bool, bar: &ProgressBar) -> Result<()> {
    bar.set_length(2 * image.body.len() as u64);
    let header = Vec::from_slice(&image.header.encode()).unwrap_or_default();
    ask(
        link,
        UpdateOrder::Begin {
            header,
            allow_older,
        },
    )?;
    let mut next = 0;
    while next < image.body.len() {
        next = piece(link, &image.body, next)?;
        bar.set_position(next as u64);
    }
    let mut status = ask(link, UpdateOrder::Finish)?;
    for _ in 0..LOOKS {
        match status.progress {
            Progress::Installed { .. } => return Ok(()),
            Progress::Failed(refusal) => bail!("the board refuses: {refusal}"),
            Progress::Checking { done, .. } => {
                bar.set_position(image.body.len() as u64 + u64::from(done))
            }
            other => bail!("the board: found {other:?} instead of a check of the image"),
        }
        link.pass(LOOK)?;
        status = ask(link, UpdateOrder::Status)?;
    }
    bail!("the board: found a check of the image that does not end")
}

/// Sends the piece at `place`; where the board wants the next. One whose answer was lost may have been taken.
fn piece(link: &mut Link, body: &[u8], place: usize) -> Result<usize> {
    let end = body.len().min(place + PIECE_BYTES);
    let order = UpdateOrder::Piece {
        offset: place as u32,
        bytes: Vec::from_slice(&body[place..end]).unwrap_or_default(),
    };
    let mut answer = ask(link, order);
    for _ in 0..ATTEMPTS {
        if answer.is_ok() {
            break;
        }
        answer = match ask(link, UpdateOrder::Status) {
            Ok(status) if matches!(status.progress, Progress::Receiving { .. }) => Ok(status),
            _ => answer,
        };
    }
    match answer?.progress {
        Progress::Receiving { next, .. } => Ok(next as usize),
        Progress::Failed(refusal) => bail!("the board refuses: {refusal}"),
        other => bail!("the board: found {other:?} instead of an update under way"),
    }
}
