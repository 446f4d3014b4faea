//! Faults on the converters' buses: a byte too many, and check sums that are wrong. A sample whose reading fails says so, and the next are good.

use super::fixture::{judge, start};
use crate::image::Image;
use crate::peripheral::flash::Start;
use crate::rule::Rule;
use crate::surroundings::ByteFault;
use crate::wire::Board;
use anyhow::{Result, ensure};
use board_link::Link;
use courier_sensor::drivers::ad7606c::FRAME_BYTES;
use courier_sensor::frame::Status;
use courier_sensor::link::telemetry::Channels;
use std::time::Duration;

/// So long samples are looked at after a fault: the chips are set anew within 10 ms.
const LOOK_MS: u64 = 20;
/// Samples that a byte too many costs: the one that it shifts, and the one at whose instant the buses are made ready again.
const A_STRAY_BYTE_COSTS: usize = 2;
/// A byte of no frame.
const STRAY: u8 = 0xA5;
/// Single readings with a wrong check sum, alternately of each chip.
const SINGLE: usize = 10;
/// So many readings in a row fail until the chips are set anew (`src/drivers/converter/revival.rs`, `FAILURES`).
const IN_A_ROW: u32 = 20;

/// A byte that nobody asked for lies in the bus's FIFO, as after a transfer that was given up: it is found and thrown away.
pub fn stale(image: &Image) -> Result<String> {
    on_a_board(image, 8, |board, link| {
        board.processor.borrow_mut().chip().disturb_bus(STRAY);
        let failed = failed(link)?;
        // What the byte itself does is no fault of the image; what is left of it after that time is.
        for rule in [Rule::SpiStale, Rule::SpiSelect, Rule::SpiFifo] {
            board.processor.borrow_mut().findings().forgive(rule);
        }
        ensure!(
            (1..=A_STRAY_BYTE_COSTS).contains(&failed),
            "found {failed} samples without a reading, wanted 1 or {A_STRAY_BYTE_COSTS}: a stale byte in the FIFO shifts the frames"
        );
        Ok(format!("a stale byte costs {failed} samples"))
    })
}

/// Check sums that are wrong: each costs its own sample, and after too many in a row the chips are set anew.
pub fn check_sums(image: &Image) -> Result<String> {
    on_a_board(image, 16, |board, link| {
        // From the first byte of a frame: what begins within one ends within another, the first of those that set the chips anew.
        let change = |chip, bytes| {
            let fault = Some((chip, ByteFault::Changed, bytes));
            board.processor.borrow_mut().chip().around.next_fault = fault;
        };
        let mut single = 0;
        for number in 0..SINGLE {
            change(number % 2, 1);
            single += failed(link)?;
        }
        ensure!(
            single == SINGLE,
            "found {single} samples without a reading after {SINGLE} wrong check sums, wanted as many"
        );
        change(1, IN_A_ROW * FRAME_BYTES as u32);
        let row = failed(link)?;
        let again = failed(link)?;
        ensure!(
            row > IN_A_ROW as usize && again == 0,
            "found {row} samples without a reading after {IN_A_ROW} wrong check sums in a row and {again} in the {LOOK_MS} ms that follow, wanted more and 0"
        );
        let missed = link.status()?.missed;
        ensure!(missed == 0, "found {missed} instants missed, wanted none");
        Ok(format!(
            "{SINGLE} wrong check sums cost {single} samples; {IN_A_ROW} in a row {row}, with the chips set anew; no instant missed"
        ))
    })
}

fn on_a_board(
    image: &Image,
    seed: u64,
    work: impl FnOnce(&Board, &mut Link) -> Result<String>,
) -> Result<String> {
    let board = Board::new(start(image, seed, Start::default())?);
    let result = Link::connect(Box::new(board.clone())).and_then(|mut link| {
        link.stream(Channels::STATUS, 1)?;
        let before = failed(&mut link)?;
        ensure!(before == 0, "the converters are not in service");
        work(&board, &mut link)
    });
    judge(&mut board.processor.borrow_mut(), result)
}

/// Samples without a reading that come within a while.
fn failed(link: &mut Link) -> Result<usize> {
    let mut count = 0;
    for _ in 0..LOOK_MS {
        link.pass(Duration::from_millis(1))?;
        link.listen(|sample| {
            let status = sample.status.unwrap_or_default();
            let failed = Status::CONVERTER_CRC | Status::CONVERTER_TIMEOUT;
            count += usize::from(status.intersects(failed));
            Ok(())
        })?;
    }
    Ok(count)
}
