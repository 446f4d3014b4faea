//! An image that decays after it was installed is not started; one that is whole, signed and new, and does not work, is ended by the watchdog
//! at each of its trials, and the one before comes back.

use super::{Bench, START_UP, Seen, sleeper};
use crate::check::fixture::judge;
use crate::image::Image as Elf;
use crate::rule::Rule;
use anyhow::{Context, Result, ensure};
use board_link::image::Image;
use courier_sensor::link::message::{Action, Reply};
use courier_sensor::update::choice::TRIALS;
use courier_sensor::update::layout::BODY_START;
use courier_sensor::update::version::Version;
use std::time::Duration;

/// What the watchdog takes to end a trial: its time, and as much as its oscillator may be slow.
const TRIAL: Duration = Duration::from_millis(1100);

pub fn run(elf: &Elf) -> Result<String> {
    let mut bench = Bench::factory(elf, 23)?;
    let result = roll_back(&mut bench);
    judge(&mut bench.board.processor.borrow_mut(), result)
}

/// An image of which a byte has changed since it was installed is not started.
fn decayed(bench: &mut Bench, image: &Image) -> Result<()> {
    bench.install(image)?;
    // In its stack pointer, so that it would sleep as before.
    let place = BODY_START as usize + 1;
    bench.banks[1].0.borrow_mut().force(place, &[0x55]);
    let resets = bench.board.processor.borrow().resets();
    bench.restart()?;
    // By its end a trial has taken others.
    let resets = bench.board.processor.borrow().resets() - resets;
    ensure!(
        resets == 1,
        "found {resets} resets, wanted the ordered one alone: an image that has decayed is started"
    );
    bench.expect(
        Seen::kept(Version::OWN, 1),
        "a byte of the image has changed",
    )
}

fn roll_back(bench: &mut Bench) -> Result<String> {
    let later = Version {
        minor: Version::OWN.minor + 1,
        ..Version::OWN
    };
    bench.store(1)?;
    decayed(bench, &sleeper(later)?)?;
    bench.install(&sleeper(later)?)?;
    let resets = bench.board.processor.borrow().resets();
    let done = bench.link.ask(Action::Restart)?;
    ensure!(
        done == Reply::Done,
        "found {done:?} as the reply to a restart"
    );
    bench.link.pass(u32::from(TRIALS) * TRIAL + 2 * START_UP)?;
    // The watchdog is meant to end it.
    bench
        .board
        .processor
        .borrow_mut()
        .findings()
        .forgive(Rule::Watchdog);
    let back = bench.link.reconnect();
    back.context("the image before does not come back: one that hangs is tried for ever")?;
    bench.expect(Seen::kept(Version::OWN, 1), "after the trials")?;
    let status = bench.link.status()?;
    let trials = bench.board.processor.borrow().resets() - resets - 1;
    ensure!(
        trials == u32::from(TRIALS),
        "found {trials} trials, wanted {TRIALS}"
    );
    ensure!(
        !status.health.safe_mode,
        "the image that came back is in safe mode, as if the faults had been its own"
    );
    // And it takes the next.
    bench.install(&sleeper(later)?)?;
    Ok(format!(
        "an image that hangs is tried {trials} times, then the one before runs with its calibration"
    ))
}
