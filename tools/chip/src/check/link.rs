//! The debug link over the chip's RAM: who is there, how it is, a stream of samples.

use super::fixture::{judge, start};
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
/// Every tenth sample is asked for where none may be lost.
const EVERY: u16 = 10;

pub fn run(image: &Image) -> Result<String> {
    let board = Board::new(start(image, 2, Start::default())?);
    let result = listen(&board);
    judge(&mut board.processor.borrow_mut(), result)
}

fn listen(board: &Board) -> Result<String> {
    let mut link = Link::connect(Box::new(board.clone()))?;
    let name = link.hello().board.clone();
    ensure!(name == "g474", "found board {name:?}, wanted g474");
    let some = stream(&mut link, EVERY)?;
    let wanted = LISTEN_MS * SAMPLES_A_MS / u64::from(EVERY);
    ensure!(
        some + 1 >= wanted,
        "found {some} samples of every {EVERY}th, wanted {wanted}"
    );
    let all = stream(&mut link, 1)?;
    let status = link.status()?;
    ensure!(
        status.missed == 0,
        "found {} instants missed, wanted none",
        status.missed
    );
    Ok(format!(
        "none of every {EVERY}th sample lost; of all {} in {LISTEN_MS} ms, {all} came",
        LISTEN_MS * SAMPLES_A_MS
    ))
}

/// Samples that come of a stream of raw counts.
fn stream(link: &mut Link, decimation: u16) -> Result<u64> {
    link.stream(Channels::RAW, decimation)?;
    link.drop_samples()?;
    let mut count = 0;
    for _ in 0..LISTEN_MS {
        link.pass(Duration::from_millis(1))?;
        link.listen(|_| {
            count += 1;
            Ok(())
        })?;
    }
    link.stream(Channels::empty(), 1)?;
    Ok(count)
}
