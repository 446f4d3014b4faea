//! The debug link over the chip's RAM: who is there, how it is, a stream of samples.

use super::{judge, start};
use crate::image::Image;
use crate::peripheral::flash::Start;
use crate::wire::Board;
use anyhow::{Result, ensure};
use board_link::Link;
use courier_sensor::link::telemetry::Channels;

use std::time::Duration;

/// So long samples are listened to.
const LISTEN_MS: u64 = 50;
const SAMPLES_A_MS: u64 = 20;

pub fn run(image: &Image) -> Result<String> {
    let board = Board::new(start(image, 2, Start::default())?);
    let result = listen(&board);
    judge(&mut board.processor.borrow_mut(), result)
}

fn listen(board: &Board) -> Result<String> {
    let mut link = Link::connect(Box::new(board.clone()))?;
    let name = link.hello().board.clone();
    link.stream(Channels::RAW, 1)?;
    let (mut first, mut last, mut count) = (None, 0, 0);
    for _ in 0..LISTEN_MS {
        link.pass(Duration::from_millis(1))?;
        link.listen(|sample| {
            let number = sample.sequence;
            first.get_or_insert(number);
            (last, count) = (number, count + 1);
            Ok(())
        })?;
    }
    let status = link.status()?;
    ensure!(name == "g474", "found board {name:?}, wanted g474");
    ensure!(
        status.missed == 0,
        "found {} instants missed, wanted none",
        status.missed
    );
    let wanted = LISTEN_MS * SAMPLES_A_MS;
    let spread = u64::from(last - first.unwrap_or(last)) + 1;
    ensure!(
        count == spread && count > wanted - SAMPLES_A_MS,
        "found {count} samples of {spread}, wanted {wanted} without a gap"
    );
    Ok(format!(
        "{count} samples in {LISTEN_MS} ms, none missed; status {:#x}",
        status.status
    ))
}
