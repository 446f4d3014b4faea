//! The acceptance of a board, as far as no instrument is needed. `judge` decides each step from values; here they are taken from the board.

pub mod cuts;
mod judge;

pub use judge::Step;

use crate::board::Link;
use anyhow::{Result, bail};
use courier_sensor::calibration::record::Calibration;
use courier_sensor::link::message::{Action, BoardStatus, Hello, InForce, Reply, Source};
use courier_sensor::link::telemetry::Channels;
use judge::Sampled;
use serde::Serialize;
use std::time::Duration;

/// Time between two looks at the stream, of the board's own.
const LOOK: Duration = Duration::from_millis(10);
/// One frame in so many is looked at: 1,000 a second, which any way to a board carries.
const DECIMATION: u16 = 20;
/// From a restart until frames are there.
const SETTLED: Duration = Duration::from_millis(100);
/// The interrupt takes what was put in force at its next sample.
const TAKEN: Duration = Duration::from_millis(1);

/// What is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Time of sampling that is watched, seconds of the board's.
    pub seconds: f64,
    /// Commits meanwhile.
    pub commits: u16,
    /// Restarts before.
    pub restarts: u16,
    /// Temperature by another thermometer, degrees Celsius.
    pub temperature_c: Option<f32>,
}

/// What came of it.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// The board.
    pub board: Hello,
    /// Each step.
    pub steps: Vec<Step>,
    /// Whether no step failed.
    pub passed: bool,
}

impl Report {
    /// Adds a step.
    pub fn add(&mut self, step: Step) {
        self.passed &= step.passed != Some(false);
        self.steps.push(step);
    }
}

/// Runs every step; `watch` is told how much of the sampling has passed.
///
/// # Errors
/// The board cannot be reached.
pub fn accept(link: &mut Link, settings: &Settings, watch: impl FnMut(Duration)) -> Result<Report> {
    link.pass(SETTLED)?;
    let before = link.status()?;
    let restarts = restart(link, settings.restarts, before.in_force)?;
    let sampled = sample(link, settings, watch)?;
    let after = link.status()?;
    let mut steps = vec![
        judge::self_test(&after.health),
        judge::temperature(after.temperature_c, settings.temperature_c),
        judge::restarts(settings.restarts, restarts),
    ];
    steps.extend(judge::sampling(&sampled, settings.commits));
    steps.push(judge::interrupt(after.isr_cycles_worst, link.hello()));
    Ok(Report {
        passed: steps.iter().all(|step| step.passed != Some(false)),
        board: link.hello().clone(),
        steps,
    })
}

/// Restarts the board so often; how often it came back by that order and with the calibration that it has stored.
fn restart(link: &mut Link, times: u16, in_force: InForce) -> Result<u16> {
    let mut good = 0;
    for _ in 0..times {
        link.restart()?;
        link.pass(SETTLED)?;
        let status = link.status()?;
        let same = matches!(in_force, InForce::Unsaved) || status.in_force == in_force;
        good += u16::from(judge::restarted_as_ordered(&status) && same);
    }
    Ok(good)
}

/// Watches the board sampling, and stores what is in force meanwhile.
fn sample(
    link: &mut Link,
    settings: &Settings,
    mut watch: impl FnMut(Duration),
) -> Result<Sampled> {
    let calibration = in_force(link)?;
    link.drop_samples()?;
    let before = link.status()?;
    link.stream(Channels::STATUS, DECIMATION)?;
    let whole = Duration::from_secs_f64(settings.seconds);
    let commits = if calibration.is_some() {
        settings.commits
    } else {
        0
    };
    let mut sampled = Sampled::default();
    let mut passed = Duration::ZERO;
    let mut done = 0;
    while passed < whole {
        link.pass(LOOK)?;
        passed += LOOK;
        let due = (passed.as_secs_f64() / settings.seconds * f64::from(commits)) as u16;
        if let (true, Some(calibration)) = (done < due.min(commits), &calibration) {
            done += 1;
            sampled.stored += u16::from(store(link, calibration)?);
        }
        link.listen(|_| {
            sampled.received += 1;
            Ok(())
        })?;
        watch(passed);
    }
    sampled.lost = link.lost();
    link.stream(Channels::empty(), 0)?;
    let after: BoardStatus = link.status()?;
    sampled.calibrated = calibration.is_some();
    sampled.unchanged = in_force(link)? == calibration;
    sampled.samples = after.samples.wrapping_sub(before.samples);
    sampled.missed = after.missed.wrapping_sub(before.missed);
    sampled.dropped = after.dropped_frames.wrapping_sub(before.dropped_frames);
    sampled.status_seen = after.status_seen;
    Ok(sampled)
}

/// The calibration in force, if there is one.
fn in_force(link: &mut Link) -> Result<Option<Calibration>> {
    if link.status()?.in_force == InForce::None {
        return Ok(None);
    }
    match link.ask(Action::Read(Source::InForce))? {
        Reply::Calibration(calibration) => Ok(Some(calibration)),
        _ => bail!("the board: found a strange reply to a question for its calibration"),
    }
}

/// Loads a calibration, which then is not stored, and stores it: whether the board says that it did.
fn store(link: &mut Link, calibration: &Calibration) -> Result<bool> {
    let loaded = link.ask(Action::load(calibration.clone()))?;
    link.pass(TAKEN)?;
    let lose_unknown = false;
    let stored = link.ask(Action::Commit { lose_unknown })?;
    Ok(loaded == Reply::Done && matches!(stored, Reply::Place(_)))
}
