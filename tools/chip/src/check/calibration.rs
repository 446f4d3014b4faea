//! A calibration with a commit, a power cut, and a start from what was stored.

use super::fixture::{judge, start};
use crate::image::Image;
use crate::peripheral::flash::Start;
use crate::wire::Board;
use anyhow::{Context, Result, bail, ensure};
use board_link::Link;
use courier_sensor::calibration::record::Calibration;
use courier_sensor::link::message::{Action, CalibrateOrder, InForce, Reply, Source};
use courier_sensor::link::report::Ending;

use std::time::Duration;

/// The shortest session that can be accepted, stored at its end.
const POSES: u16 = 60;
const HELD_OUT: u16 = 10;
/// A pose takes 0.3 s; with as much again for what is slow.
const PATIENCE_S: u64 = 45;

pub fn run(image: &Image) -> Result<String> {
    let board = Board::new(start(image, 3, Start::default())?);
    let result = calibrate(&board);
    judge(&mut board.processor.borrow_mut(), result)
}

fn calibrate(board: &Board) -> Result<String> {
    let mut link = Link::connect(Box::new(board.clone()))?;
    let order = CalibrateOrder {
        poses: POSES,
        held_out_poses: HELD_OUT,
        ..CalibrateOrder::default()
    };
    ensure!(
        link.ask(Action::Calibrate(order))? == Reply::Done,
        "a strange reply to an order"
    );
    let ending = ending(&mut link)?;
    let Ending::Accepted {
        stored: Some(_), ..
    } = ending
    else {
        bail!("found {ending:?}, wanted a calibration that is stored")
    };
    let made = in_force(&mut link)?;
    let missed = link.status()?.missed;
    let seconds = board.processor.borrow().now() / crate::time::TICK_HZ;
    board.processor.borrow_mut().cut_power()?;
    link.reconnect().context("after the power cut")?;
    link.pass(Duration::from_millis(10))?;
    let status = link.status()?;
    ensure!(
        matches!(status.in_force, InForce::Stored(_)),
        "found {:?} in force after the power cut, wanted what was stored",
        status.in_force
    );
    ensure!(
        in_force(&mut link)? == made,
        "the calibration in force is another one after the power cut"
    );
    ensure!(missed == 0, "found {missed} instants missed, wanted none");
    Ok(format!(
        "{POSES} poses in {seconds} s of the board's, stored, in force again after a power cut"
    ))
}

fn ending(link: &mut Link) -> Result<Ending> {
    for _ in 0..10 * PATIENCE_S {
        link.pass(Duration::from_millis(100))?;
        let Reply::Progress(progress) = link.ask(Action::Progress)? else {
            bail!("a strange reply to a question for the progress")
        };
        if let Some(ending) = progress.ending {
            return Ok(ending);
        }
    }
    bail!("found no end of the calibration within {PATIENCE_S} s of the board's")
}

fn in_force(link: &mut Link) -> Result<Box<Calibration>> {
    match link.ask(Action::Read(Source::InForce))? {
        Reply::Calibration(calibration) => Ok(Box::new(calibration)),
        _ => bail!("a strange reply to a question for the calibration in force"),
    }
}
