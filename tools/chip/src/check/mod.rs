//! What `cargo xtask chip` runs, one check a file.

mod boot;
mod bus;
mod calibration;
pub mod control;
mod cuts;
pub(crate) mod fixture;
mod hang;
mod health;
mod link;
mod overflow;
mod parity;
mod restart;
mod stream;
mod time;
mod update;
mod variants;

use crate::image::Image;
use anyhow::{Result, bail, ensure};
use cpu_time::ThreadTime;
use std::num::NonZero;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::thread;

/// A check: its name, what it does, and the function that does it.
type Check = (&'static str, &'static str, fn(&Image) -> Result<String>);

/// All checks, those that take longest first: they run at once. A further one is a line here.
pub const CHECKS: &[Check] = &[
    (
        "calibration",
        "a calibration, a commit, a power cut, a start from what was stored",
        calibration::run,
    ),
    (
        "stream",
        "a recording's stream beside interrupts as long as they may be, and beside commits and a calibration: every frame is taken up",
        stream::run,
    ),
    (
        "cuts",
        "the supply goes at every operation of a commit",
        cuts::run,
    ),
    (
        "update",
        "a good image over the link: installed while the board samples, tried, accepted; the supply goes at every operation of that",
        update::good::run,
    ),
    (
        "update-refused",
        "images of another board, key or version, half and damaged ones: the board starts as before",
        update::refused::run,
    ),
    (
        "update-trial",
        "an image that hangs: the one before comes back",
        update::trial::run,
    ),
    ("boot", "from the reset vector to 1,000 samples", boot::run),
    (
        "link",
        "hello, status and a stream over the rings in RAM",
        link::run,
    ),
    (
        "health",
        "self-tests pass, and tell of option bytes and a clock that are wrong",
        health::run,
    ),
    (
        "parity",
        "raw counts give the same bits on the chip and here",
        parity::run,
    ),
    (
        "time",
        "cycles of the sampling interrupts with wait states, plain and with a tooth map; the fastest rate",
        time::run,
    ),
    (
        "hang",
        "a hang of background or sampling interrupt leaves its place; three in a row are safe mode",
        hang::run,
    ),
    (
        "overflow",
        "a stack that runs over is told and loses nothing",
        overflow::run,
    ),
    (
        "flags",
        "a commit on error flags of the past",
        variants::flags,
    ),
    (
        "single-bank",
        "a commit in single-bank mode is refused",
        variants::single_bank,
    ),
    (
        "halted",
        "a debugger halts the processor for 10 ms",
        variants::halted,
    ),
    ("stale", "a stale byte in the bus's FIFO", bus::stale),
    (
        "check-sums",
        "wrong check sums of the converters' frames: each costs its own sample",
        bus::check_sums,
    ),
    ("code", "wrong check bits in the code", variants::code),
    (
        "restart",
        "a restart while the courier is on its way: it stops",
        restart::run,
    ),
    ("silent", "BUSY is silent for 10 ms", variants::silent),
];

/// Checks that take minutes: they run if they are named.
pub const LONG_CHECKS: &[Check] = &[(
    "minute",
    "a minute of a recording's stream, commits and calibrations: every frame is taken up",
    stream::minute,
)];

/// Prints what a check measures, as JSON on one line: `time`, or `stream`, which then takes a minute of the board's.
///
/// # Errors
/// There is no such image, a rule is broken, or the check measures nothing.
pub fn print_figures(image: &Path, check: &str) -> Result<()> {
    let image = Image::open(image)?;
    let figures = match check {
        "time" => time::json(&image),
        "stream" => stream::json(&image),
        other => bail!("found {other:?}, wanted time or stream before --json"),
    };
    println!("{}", figures?);
    Ok(())
}

/// Runs the checks that are named, or [`CHECKS`]; prints a line each.
///
/// # Errors
/// A check that fails; what broke is said as it is found.
pub fn run(image: &Path, names: &[String]) -> Result<()> {
    let all: Vec<&Check> = CHECKS.iter().chain(LONG_CHECKS).collect();
    if let Some(unknown) = names
        .iter()
        .find(|name| all.iter().all(|(known, ..)| known != name))
    {
        let known: Vec<&str> = all.iter().map(|(name, ..)| *name).collect();
        bail!("found {unknown:?}, wanted one of {}", known.join(", "));
    }
    let image = Image::open(image)?;
    let chosen = match names {
        [] => CHECKS.iter().collect(),
        names => all
            .into_iter()
            .filter(|(name, ..)| names.iter().any(|wanted| wanted == name))
            .collect::<Vec<&Check>>(),
    };
    let failed = at_once(&image, &chosen);
    ensure!(failed.is_empty(), "failed: {}", failed.join(", "));
    Ok(())
}

/// Runs checks, as many at once as there are processors; a line each as it ends, with its processor time. Names of those that failed, in their order.
fn at_once(image: &Image, checks: &[&Check]) -> Vec<&'static str> {
    let workers = thread::available_parallelism().map_or(1, NonZero::get);
    let (next, failed) = (AtomicUsize::new(0), Mutex::new(vec![]));
    thread::scope(|scope| {
        for _ in 0..workers.min(checks.len()) {
            scope.spawn(|| {
                while let Some((name, _, check)) = checks.get(next.fetch_add(1, Relaxed)) {
                    let begin = ThreadTime::now();
                    let outcome = check(image);
                    let seconds = begin.elapsed().as_secs_f64();
                    match outcome {
                        Ok(said) => println!("chip: {name} ({seconds:.1} s): {said}"),
                        Err(error) => {
                            eprintln!("chip: {name}: {error:#}");
                            let mut failed = failed.lock().unwrap_or_else(|held| held.into_inner());
                            failed.push(*name);
                        }
                    }
                }
            });
        }
    });
    let failed = failed.into_inner().unwrap_or_else(|held| held.into_inner());
    let in_order = checks.iter().map(|(name, ..)| *name);
    in_order.filter(|name| failed.contains(name)).collect()
}
