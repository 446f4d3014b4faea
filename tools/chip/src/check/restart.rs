//! A restart while the courier is on its way: nobody waits for it any more, so it is told to stop.

use super::fixture::{judge, start_in, world};
use crate::image::Image;
use crate::peripheral::flash::Start;
use crate::wire::Board;
use anyhow::{Result, ensure};
use board_link::Link;
use courier_sensor::drivers::motion::{HEARTBEAT_LIMIT_MS, Target};
use courier_sensor::link::message::{Action, Reply};
use effects::motion::{Motion, Pose};
use hal_sim::world::World;
use std::time::Duration;

/// Where the courier is sent, and how fast: a way of two seconds.
const WAY_M: f32 = 0.2;
const SPEED_M_PER_S: f32 = 0.2;
/// It is on its way after this time, far from the end of it.
const UNDER_WAY: Duration = Duration::from_millis(300);
/// By then it stands because it was told to: without a word it would begin to brake after [`HEARTBEAT_LIMIT_MS`] only. The restart follows the
/// reply by 20 ms; the first stage's check of the whole image, start-up and the stop's frame take 82 ms, braking from that speed 40 ms, and a
/// swing is left.
const STOPPED: Duration = Duration::from_millis(HEARTBEAT_LIMIT_MS as u64 - 20);
/// So long is looked at whether it stands, and so far a courier that swings out may be off, metres.
const LOOK: Duration = Duration::from_millis(20);
const STILL_M: f64 = 20e-6;

pub fn run(image: &Image) -> Result<String> {
    let (world, flash) = world(11)?;
    let board = Board::new(start_in(image, world.clone(), flash, Start::default())?);
    let result = stops(&board, &world);
    judge(&mut board.processor.borrow_mut(), result)
}

fn stops(board: &Board, world: &World) -> Result<String> {
    let mut link = Link::connect(Box::new(board.clone()))?;
    let target = Target {
        x_m: WAY_M,
        y_m: 0.0,
        theta_rad: 0.0,
    };
    let order = Action::GoTo {
        target,
        speed_m_per_s: SPEED_M_PER_S,
    };
    ensure!(
        link.ask(order)? == Reply::Done,
        "a strange reply to an order to go"
    );
    link.pass(UNDER_WAY)?;
    let begun = moves(&mut link, board, world)?;
    ensure!(begun > STILL_M, "the courier is not on its way");
    board.processor.borrow_mut().may_reset = true;
    ensure!(
        link.ask(Action::Restart)? == Reply::Done,
        "a strange reply to an order to restart"
    );
    link.pass(STOPPED)?;
    let still = moves(&mut link, board, world)?;
    ensure!(
        still < STILL_M,
        "the courier goes on after the restart: {:.0} um in {} ms",
        1e6 * still,
        LOOK.as_millis()
    );
    Ok(format!(
        "the courier stands within {} ms of a restart on its way",
        STOPPED.as_millis()
    ))
}

/// How far the courier moves while it is looked at, metres.
fn moves(link: &mut Link, board: &Board, world: &World) -> Result<f64> {
    let at = || -> Pose {
        let seconds = board.processor.borrow().now() as f64 / crate::time::TICK_HZ as f64;
        world.motion.motion().pose(seconds)
    };
    let before = at();
    link.pass(LOOK)?;
    let way = at().plus(before, -1.0);
    Ok(way.x_m.hypot(way.y_m))
}
