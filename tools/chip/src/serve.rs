//! `chip serve IMAGE`: the modelled chip as a board for a host that is another program (`courier --chip`).

use crate::chip::Chip;
use crate::host::Host;
use crate::image::{self, Image};
use crate::peripheral::flash::Start;
use crate::processor::{BANK_BYTES, FLASH, Processor};
use crate::surroundings::Surroundings;
use crate::wire::Board;
use anyhow::{Context, Result, bail};
use board_link::Wire;
use link_host::chip::protocol::{Done, Order};
use std::path::Path;
use std::time::Duration;

/// Takes orders from standard input until it ends.
///
/// # Errors
/// There is no such image, or the host speaks another language.
pub fn run(path: &Path) -> Result<()> {
    let host = Host::new(std::io::stdin(), std::io::stdout());
    let Some(Order::Start { number }) = host.order() else {
        bail!("found no order to start, wanted one on standard input: `courier --chip` gives it")
    };
    let board = match start(path, number, &host) {
        Ok(board) => board,
        Err(error) => return host.done(Done::Failed(format!("{error:#}"))),
    };
    host.done(Done::Nothing)?;
    let mut seen = 0;
    while let Some(order) = host.order() {
        let done = carry_out(order, &mut board.clone(), &mut seen);
        host.done(done.unwrap_or_else(|error| Done::Failed(format!("{error:#}"))))?;
    }
    Ok(())
}

fn start(path: &Path, number: [u8; 12], host: &Host) -> Result<Board> {
    let code = Image::open(path)?.flash(FLASH, BANK_BYTES as usize)?;
    let around = Surroundings::of_host(host.clone())?;
    let mut processor = Processor::start(&code, Chip::new(around, Start::default()))?;
    processor
        .write_memory(image::NUMBER, &number)
        .context("the chip's number")?;
    // Who sits before the board may ask it to restart.
    processor.may_reset = true;
    Ok(Board::new(processor))
}

/// `seen`: broken rules that have been told.
fn carry_out(order: Order, board: &mut Board, seen: &mut usize) -> Result<Done> {
    match order {
        Order::Start { .. } => bail!("found an order to start, wanted it once"),
        Order::Run { ns } => {
            board.pass(Duration::from_nanos(ns))?;
            let mut processor = board.processor.borrow_mut();
            let list = processor.findings().list();
            let new = &list[(*seen).min(list.len())..];
            *seen = list.len();
            Ok(Done::Ran {
                broken: new.iter().map(ToString::to_string).collect(),
            })
        }
        Order::LookAtBank => {
            let mut processor = board.processor.borrow_mut();
            for bank in &mut processor.chip().around.banks {
                bank.look_again()?;
            }
            Ok(Done::Nothing)
        }
        Order::Receive { channel, most } => {
            let mut bytes = vec![0; most as usize];
            let count = board.receive(usize::from(channel), &mut bytes)?;
            bytes.truncate(count);
            Ok(Done::Bytes(bytes))
        }
        Order::Send { bytes } => Ok(Done::Taken(board.send(&bytes)? as u32)),
    }
}
