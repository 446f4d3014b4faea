//! The supply goes at every operation of the flash that an update takes, from the erase of the old header to the last mark of acceptance.
//!
//! One update is made without a cut, and each operation of either bank is noted. What the flash holds after a cut follows from that: the
//! operations before it, and a part of the one that it falls into. For each of them the rule by which a bank is chosen is asked. The chip
//! itself, with the shipped first stage and firmware, is switched on after cuts in all that is not the body or the copied calibration, and in
//! some of these; it must start the same bank, and have the calibration in force.

use super::{Bench, switched_on};
use crate::bank::Operation;
use crate::check::fixture::judge;
use crate::processor::FLASH;
use crate::time::from_us;
use crate::wire::Board;
use anyhow::{Context, Result, bail, ensure};
use board_link::Link;
use courier_sensor::update::choice::candidates;
use courier_sensor::update::layout::{BODY_START, IMAGE_END, SLOTS_END, SLOTS_START};
use courier_sensor::update::standing;
use embedded_storage::nor_flash::NorFlash;
use hal_sim::board::SharedFlash;
use hal_sim::wire::flash::{Flash, FlashError, PAGE_BYTES};
use std::cell::RefCell;
use std::ops::Range;
use std::rc::Rc;

/// Steps of `hal-sim`'s flash to an operation: the cut falls into its middle.
const HALF: u64 = 4;
/// Of the operations on the body, and of those that copy the calibration, the chip is switched on after every so many.
const BODY_EVERY: usize = 2500;
const COPY_EVERY: usize = 50;
/// So long the first stage may take.
const PATIENCE_MS: u64 = 200;
/// Code of an image that has been started.
const CODE: Range<u32> = FLASH + BODY_START..FLASH + IMAGE_END;

/// Both banks as they were before the update, and what was done to them.
pub struct Update {
    pub before: [Flash; 2],
    pub operations: Vec<(usize, Operation)>,
}

/// Cuts each of the operations.
pub fn cut(update: &Update) -> Result<String> {
    let mut banks = update.before.clone();
    ensure!(is_whole(&mut banks[0]), "the image that ships is not whole");
    let (mut seen, mut tried) = ([0; 2], 0);
    let (mut in_body, mut copied) = (0, 0);
    for (number, (bank, operation)) in update.operations.iter().enumerate() {
        let mut torn = banks[*bank].clone();
        torn.cut_after(HALF);
        let cut = apply(&mut torn, *operation);
        ensure!(cut == Err(FlashError::Off), "found no cut, wanted one");
        torn.power_up();
        std::mem::swap(&mut banks[*bank], &mut torn);
        let by_rule = chosen(&mut banks)?;
        seen[by_rule] += 1;
        if is_tried(*operation, &mut in_body, &mut copied) {
            let place = || format!("a cut in operation {number}, {operation:?}");
            start(banks.clone(), by_rule).with_context(place)?;
            tried += 1;
        }
        std::mem::swap(&mut banks[*bank], &mut torn);
        apply(&mut banks[*bank], *operation)
            .map_err(|error| anyhow::anyhow!("operation {number}: {error:?}"))?;
    }
    ensure!(
        seen[0] > 0 && seen[1] > 0,
        "found {seen:?} cuts after which bank 1 and bank 2 start, wanted both"
    );
    Ok(format!(
        "{} operations, each cut: the old image starts after {}, the new one after {}; {tried} of them on the chip, each with the calibration",
        update.operations.len(),
        seen[0],
        seen[1]
    ))
}

fn apply(bank: &mut Flash, operation: Operation) -> Result<(), FlashError> {
    match operation {
        Operation::Erase(offset) => bank.erase(offset, offset + PAGE_BYTES as u32),
        Operation::Program(offset, data) => bank.write(offset, &data),
    }
}

/// The bank that the rule chooses. An update does not touch the body in bank 1, so that only the other one is looked at anew.
fn chosen(banks: &mut [Flash; 2]) -> Result<usize> {
    let standings = banks.each_mut().map(standing::read);
    let mut candidates = candidates(&standings).into_iter().map(|it| it.bank);
    let found = candidates.find(|bank| *bank == 0 || is_whole(&mut banks[1]));
    found.context("no image is started")
}

fn is_whole(bank: &mut Flash) -> bool {
    let header = standing::read(bank).header;
    header.is_some_and(|header| standing::is_whole(bank, &header))
}

/// Whether the chip is switched on after a cut in this operation.
fn is_tried(operation: Operation, in_body: &mut usize, copied: &mut usize) -> bool {
    let (Operation::Erase(offset) | Operation::Program(offset, _)) = operation;
    let every = |count: &mut usize, every: usize| {
        *count += 1;
        (*count - 1).is_multiple_of(every)
    };
    match offset {
        BODY_START..IMAGE_END => every(in_body, BODY_EVERY),
        SLOTS_START..SLOTS_END => every(copied, COPY_EVERY),
        _ => true,
    }
}

/// Switches a chip on with these banks: it must start the image in the bank that the rule has chosen, with the calibration.
fn start(banks: [Flash; 2], by_rule: usize) -> Result<()> {
    let banks = banks.map(|bank| SharedFlash(Rc::new(RefCell::new(bank))));
    let mut processor = switched_on(&banks, 25)?;
    for _ in 0..PATIENCE_MS {
        processor.run(from_us(1000))?;
        if CODE.contains(&processor.program_counter()) {
            break;
        }
    }
    let at = processor.program_counter();
    ensure!(CODE.contains(&at), "no image is started: {at:#010x}");
    let found = usize::from(processor.chip().banks_swapped());
    ensure!(
        found == by_rule,
        "found bank {} started, wanted bank {}",
        found + 1,
        by_rule + 1
    );
    let board = Board::new(processor);
    let link = Link::connect(Box::new(board.clone()))?;
    let mut bench = Bench { board, link, banks };
    let mark = bench.seen()?.mark;
    let result = match mark {
        Some(1) => Ok(String::new()),
        other => bail!("found calibration {other:?} in force, wanted 1"),
    };
    judge(&mut bench.board.processor.borrow_mut(), result).map(drop)
}
