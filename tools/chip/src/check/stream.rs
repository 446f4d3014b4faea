//! Every frame is taken up, whatever else the board has to do: send every sample as `courier record` wants it, calibrate, write to the
//! flash.
//!
//! The check gives the sampling interrupts all the time that their budget leaves them, and then has everything come together for some
//! seconds; `minute` does the latter for a minute, which is the figure of `cargo xtask bench --json` too.

use super::fixture::{judge, start};
use super::time::{SAMPLE_CYCLES, spent};
use crate::image::Image;
use crate::peripheral::flash::Start;
use crate::registers;
use crate::time::TICK_HZ;
use crate::wire::Board;
use anyhow::{Context, Result, bail, ensure};
use board_link::Link;
use courier_sensor::calibration::record::Calibration;
use courier_sensor::geometry::Geometry;
use courier_sensor::link::message::{Action, CalibrateOrder, Reply};
use courier_sensor::link::telemetry::Channels;
use courier_sensor::model::{BACKGROUND_CYCLES, ErrorModel, TermTable};
use cpu_time::ThreadTime;
use std::fmt;
use std::time::Duration;

/// Processor time that a virtual second of the board may cost, seconds: beyond that the checks would take minutes.
const WANTED_COST: f64 = 20.0;
/// Virtual time with sampling interrupts as long as they may be, with everything at once in the check, and in the minute.
const STRETCHED_MS: u64 = 500;
const CHECK_MS: u64 = 2_000;
const MINUTE_MS: u64 = 60_000;
/// The host takes the stream out of the rings so often; a probe is faster.
const LOOK: Duration = Duration::from_millis(1);
/// Looks from one order to the next.
const LOOKS_AN_ORDER: u64 = 100;
/// The shortest session that can be accepted, stored at its end: two of them are over within the minute.
const ORDER: (u16, u16) = (60, 10);

pub fn run(image: &Image) -> Result<String> {
    let stretched = on_a_board(image, |board, link| {
        let taken = stretch(board)?;
        let counts = stream(board, link, STRETCHED_MS, |_, _| Ok(()))?;
        Ok((taken, counts))
    });
    let (taken, counts) = stretched?;
    let said = format!("with sampling interrupts of {taken} cycles, {counts}");
    counts.judge(&said)?;
    Ok(format!("{said}; {}", everything(image, CHECK_MS)?))
}

/// A minute of everything.
pub fn minute(image: &Image) -> Result<String> {
    everything(image, MINUTE_MS)
}

/// Everything for so long: what was counted, in words.
fn everything(image: &Image, milliseconds: u64) -> Result<String> {
    let (counts, orders, cost) = at_once(image, milliseconds)?;
    let said = format!(
        "{orders}, {counts}; a virtual second of the board costs {cost:.1} s of processor time"
    );
    counts.judge(&said)?;
    ensure!(
        cost <= WANTED_COST,
        "{said}; wanted {WANTED_COST} s or less"
    );
    Ok(said)
}

/// What a minute of everything comes to, as one JSON object.
///
/// # Errors
/// The image does not do what it is told.
pub fn json(image: &Image) -> Result<String> {
    let (counts, orders, _) = at_once(image, MINUTE_MS)?;
    eprintln!("chip: stream: {orders}, {counts}");
    Ok(format!(
        "{{\"frames_not_taken_up\": {}}}",
        counts.not_taken_up
    ))
}

/// A recording's stream, commits and calibrations; and the processor time that a virtual second costs, seconds.
fn at_once(image: &Image, milliseconds: u64) -> Result<(Counts, Orders, f64)> {
    let mut orders = Orders::default();
    let (counts, cost) = on_a_board(image, |board, link| {
        load(link, 0)?;
        let begin = ThreadTime::now();
        let before = board.processor.borrow().now();
        let counts = stream(board, link, milliseconds, |link, look| {
            orders.go_on(link, look)
        })?;
        let virtual_ticks = board.processor.borrow().now() - before;
        let virtual_s = virtual_ticks as f64 / TICK_HZ as f64;
        Ok((counts, begin.elapsed().as_secs_f64() / virtual_s))
    })?;
    Ok((counts, orders, cost))
}

/// What was counted.
struct Counts {
    samples: u32,
    sent: u64,
    not_taken_up: u32,
    missed: u32,
    unsent: u32,
}

impl Counts {
    /// Fails if a frame was lost anywhere; the host takes everything out of the rings in time.
    fn judge(&self, said: &str) -> Result<()> {
        ensure!(
            self.not_taken_up == 0 && self.missed == 0 && self.unsent == 0,
            "{said}; wanted none of these"
        );
        Ok(())
    }
}

impl fmt::Display for Counts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} samples went out of {}; {} were not taken up, {} missed, and {} not sent",
            self.sent, self.samples, self.not_taken_up, self.missed, self.unsent
        )
    }
}

fn on_a_board<R>(image: &Image, work: impl FnOnce(&Board, &mut Link) -> Result<R>) -> Result<R> {
    let board = Board::new(start(image, 12, Start::default())?);
    let mut found = None;
    let result = Link::connect(Box::new(board.clone()))
        .and_then(|mut link| work(&board, &mut link))
        .map(|result| found = Some(result));
    let said = result.map(|()| String::new());
    judge(&mut board.processor.borrow_mut(), said)?;
    found.context("nothing was counted")
}

/// The sampling interrupts take from now on what their budget allows; how much that is, cycles.
fn stretch(board: &Board) -> Result<u64> {
    let mut processor = board.processor.borrow_mut();
    let own = spent(&mut processor)?.worst;
    let allowed = SAMPLE_CYCLES - BACKGROUND_CYCLES as u64;
    let more = allowed.checked_sub(own);
    let more = more.with_context(|| format!("found {own} cycles already, allowed {allowed}"))?;
    processor.stretch = Some((16 + registers::interrupt("DMA1_CHANNEL2"), more));
    Ok(allowed)
}

/// A recording's stream for so long; `work` sees each look.
fn stream(
    board: &Board,
    link: &mut Link,
    milliseconds: u64,
    mut work: impl FnMut(&mut Link, u64) -> Result<()>,
) -> Result<Counts> {
    let before = link.status()?;
    link.stream(Channels::RECORDING, 1)?;
    link.drop_samples()?;
    let mut sent = 0;
    let end = board.processor.borrow().now() + milliseconds * TICK_HZ / 1000;
    for look in 0.. {
        if board.processor.borrow().now() >= end {
            break;
        }
        link.pass(LOOK)?;
        link.listen(|_| {
            sent += 1;
            Ok(())
        })?;
        work(link, look)?;
    }
    let after = link.status()?;
    Ok(Counts {
        samples: after.samples - before.samples,
        sent,
        not_taken_up: after.dropped_frames - before.dropped_frames,
        missed: after.missed - before.missed,
        unsent: after.lost_telemetry,
    })
}

/// Commits and calibrations by turns. A commit is refused while a calibration is under way, which stores by itself at its end.
#[derive(Default)]
struct Orders {
    commits: u32,
    calibrations: u32,
    calibrates: bool,
}

impl fmt::Display for Orders {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (commits, calibrations) = (self.commits, self.calibrations);
        write!(f, "with {commits} commits and {calibrations} calibrations")
    }
}

impl Orders {
    fn go_on(&mut self, link: &mut Link, look: u64) -> Result<()> {
        if look % LOOKS_AN_ORDER != 0 {
            return Ok(());
        }
        if self.calibrates {
            let Reply::Progress(progress) = link.ask(Action::Progress)? else {
                bail!("a strange reply to a question for the progress")
            };
            let ended = progress.ending.is_some();
            self.calibrations += u32::from(ended);
            self.calibrates = !ended;
        } else if self.commits > self.calibrations {
            let (poses, held_out_poses) = ORDER;
            let order = CalibrateOrder {
                poses,
                held_out_poses,
                ..CalibrateOrder::default()
            };
            done(&link.ask(Action::Calibrate(order))?)?;
            self.calibrates = true;
        } else {
            load(link, self.commits + 1)?;
            let stored = link.ask(Action::Commit { lose_unknown: true })?;
            ensure!(
                matches!(stored, Reply::Place(_)),
                "a strange reply to a commit"
            );
            self.commits += 1;
        }
        Ok(())
    }
}

/// Puts a record of no board in particular in force, which becomes this one's; each `number` is another record.
fn load(link: &mut Link, number: u32) -> Result<()> {
    let mut calibration = Calibration::identity(Geometry::PAPER);
    calibration.model = ErrorModel::zero(TermTable::equation_3());
    calibration.made.uptime_s = number;
    done(&link.ask(Action::take_over(calibration))?)?;
    link.pass(LOOK)
}

fn done(reply: &Reply) -> Result<()> {
    ensure!(*reply == Reply::Done, "a strange reply to an order");
    Ok(())
}
