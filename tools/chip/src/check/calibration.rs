//! A calibration with a commit, a power cut, and a start from what was stored.

use super::fixture::{judge, start_in};
use crate::image::Image;
use crate::peripheral::flash::Start;
use crate::wire::Board;
use anyhow::{Context, Result, bail, ensure};
use board_link::Link;
use courier_sensor::calibration::record::Calibration;
use courier_sensor::link::message::{Action, CalibrateOrder, InForce, Reply, Source};
use courier_sensor::link::report::Ending;
use hal_sim::board::SharedFlash;
use hal_sim::presets;
use hal_sim::wire::motion::ControllerConfig;
use hal_sim::world::World;
use std::time::Duration;

/// The courier's number.
const SEED: u64 = 3;
/// The shortest session that can be accepted, stored at its end.
const POSES: u16 = 60;
const HELD_OUT: u16 = 10;
/// A motor that stands at once, and how fast it moves, m/s: nothing is tried while the courier is on its way.
const QUICK: ControllerConfig = ControllerConfig {
    decay_s: 1.5e-3,
    settle_s: 10.0e-3,
    acceleration_m_per_s2: 40.0,
    ..ControllerConfig::TYPICAL
};
const SPEED_M_PER_S: f32 = 1.0;
/// A pose takes 0.06 s; with as much again for what is slow.
const PATIENCE_S: u64 = 10;

pub fn run(image: &Image) -> Result<String> {
    let world = World::new(presets::ideal(SEED), QUICK, Default::default(), SEED)?;
    let processor = start_in(image, world, SharedFlash::erased(SEED), Start::default())?;
    let board = Board::new(processor);
    let result = calibrate(&board);
    judge(&mut board.processor.borrow_mut(), result)
}

fn calibrate(board: &Board) -> Result<String> {
    let mut link = Link::connect(Box::new(board.clone()))?;
    let order = CalibrateOrder {
        poses: POSES,
        held_out_poses: HELD_OUT,
        speed_m_per_s: SPEED_M_PER_S,
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
