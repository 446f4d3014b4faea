//! What the board says of itself: every self-test passes on a chip as it should be, and tells of one that is not.

use super::fixture::{judge, start};
use crate::image::Image;
use crate::peripheral::flash::Start;
use crate::processor::Processor;
use crate::time::TICK_HZ;
use crate::wire::Board;
use anyhow::{Result, ensure};
use board_link::Link;
use courier_sensor::health::{OptionFault, Trouble, troubles};
use courier_sensor::link::message::{BoardStatus, ConverterTest, MemoryTest};
use std::time::Duration;

/// What the slow oscillator may be off by the two captures' rounding, hertz.
const ROUNDING_HZ: u32 = 2;
/// The board looks at what changes slowly every 100 ms.
const SLOW_LOOKS: Duration = Duration::from_millis(150);

pub fn run(image: &Image) -> Result<String> {
    let sound = with(
        image,
        12,
        Start::default(),
        |_| {},
        |status| {
            let health = &status.health;
            ensure!(health.converters == ConverterTest::Passed, "{health:?}");
            ensure!(health.memory == MemoryTest::Passed, "{health:?}");
            let hz = health.slow_clock_hz.unwrap_or(0);
            ensure!(
                hz.abs_diff(32_000) <= ROUNDING_HZ,
                "found {hz} Hz, wanted 32000"
            );
            ensure!(status.isr_cycles_worst.is_some(), "no cycles are counted");
            let found = troubles(health);
            ensure!(found.is_empty(), "found {found:?}, wanted no trouble");
            Ok(format!("slow clock {hz} Hz, no trouble"))
        },
    )?;
    let mut options = Start::default();
    options.options.set_n_swboot0(true);
    options.options.set_bor_lev(0);
    let pin = OptionFault::BootPin {
        software: 1,
        value: 1,
    };
    let wanted = [
        Trouble::Options(pin),
        Trouble::Options(OptionFault::BrownOut(0)),
    ];
    with(image, 13, options, |_| {}, |status| told(&status, &wanted))?;
    let slow = |processor: &mut Processor| processor.chip().set_slow_clock(TICK_HZ / 25_000);
    let wanted = [Trouble::Clock(25_000)];
    with(image, 14, Start::default(), slow, |status| {
        told(&status, &wanted)
    })?;
    let lost = pulses(image)?;
    Ok(format!(
        "{sound}; {lost}; option bytes and a clock that are wrong are told"
    ))
}

/// Pulses of BUSY that do not come are told, by their number.
fn pulses(image: &Image) -> Result<String> {
    const LOST: u32 = 3;
    let board = Board::new(start(image, 15, Start::default())?);
    let unanswered = |link: &mut Link| {
        link.pass(SLOW_LOOKS)?;
        Ok::<_, anyhow::Error>(link.status()?.health)
    };
    let result = Link::connect(Box::new(board.clone())).and_then(|mut link| {
        let before = unanswered(&mut link)?.unanswered;
        ensure!(
            before == Some(0),
            "found {before:?}, wanted none unanswered"
        );
        board.processor.borrow_mut().chip().around.lost_pulses = LOST;
        let found = troubles(&unanswered(&mut link)?);
        let wanted = [Trouble::Pulses(LOST as i32)];
        ensure!(found[..] == wanted, "found {found:?}, wanted {wanted:?}");
        Ok(format!("{LOST} pulses of BUSY that are lost are told"))
    });
    judge(&mut board.processor.borrow_mut(), result)
}

fn told(status: &BoardStatus, wanted: &[Trouble]) -> Result<String> {
    let found = troubles(&status.health);
    ensure!(found[..] == *wanted, "found {found:?}, wanted {wanted:?}");
    Ok(String::new())
}

/// Starts a chip that is set up so, and judges its status.
fn with(
    image: &Image,
    seed: u64,
    options: Start,
    change: impl FnOnce(&mut Processor),
    judged: impl FnOnce(BoardStatus) -> Result<String>,
) -> Result<String> {
    let mut processor = start(image, seed, options)?;
    change(&mut processor);
    let board = Board::new(processor);
    let status = Link::connect(Box::new(board.clone())).and_then(|mut link| link.status());
    let result = status.and_then(judged);
    judge(&mut board.processor.borrow_mut(), result)
}
