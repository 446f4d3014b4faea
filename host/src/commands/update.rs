//! `courier update IMAGE`.

use crate::board::{Choice, Image, Link, Opened, update};
use crate::json::Json;
use crate::output::{Files, Kind};
use crate::terminal::{pairs, progress, warn};
use anyhow::{Context, Result, ensure};
use courier_sensor::frame::Status;
use courier_sensor::link::message::{BoardStatus, InForce};
use courier_sensor::update::order::{UpdateOrder, UpdateStatus};
use courier_sensor::update::version::Version;
use serde::Serialize;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

/// Put a new firmware on a board; it is kept if it works, and given up if not.
///
/// The image goes into the bank of flash that no code runs from, is checked there, and is started on trial. If the board then is as it
/// was, its calibration included, the image is kept; otherwise the one before comes back. Without an image: how the board's firmware
/// stands.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  courier update\n  courier update firmware.img --older")]
pub struct Args {
    /// The image, as `cargo xtask image` makes it.
    #[arg(conflicts_with_all = ["accept", "refuse"])]
    image: Option<PathBuf>,
    /// Take an image that is older than what runs.
    #[arg(long, requires = "image")]
    older: bool,
    /// Leave the new image on trial: without `--accept` within two minutes the one before comes back.
    #[arg(long, requires = "image")]
    leave_on_trial: bool,
    /// Keep the image that is on trial.
    #[arg(long, conflicts_with = "refuse")]
    accept: bool,
    /// Give the image that is on trial up: the board restarts with the one before.
    #[arg(long)]
    refuse: bool,
    #[command(flatten)]
    json: Json,
}

/// What `--json` writes.
const ANSWER: Kind = Kind::json("an answer of `courier update`", &["running", "on_trial"]);

/// Time of the board's own that a new image is watched for before it is accepted.
const WATCH: Duration = Duration::from_secs(2);

/// What `--json` prints.
#[derive(Serialize)]
struct Told {
    /// The version that ran before.
    before: String,
    running: String,
    on_trial: bool,
    /// Anybody can sign images that the running firmware takes.
    development_key: bool,
    /// Why the new image was given up.
    #[serde(skip_serializing_if = "Option::is_none")]
    given_up: Option<String>,
}

impl Args {
    /// The files that it reads and writes.
    pub fn files(&self) -> Files {
        let files = Files::default().json(&self.json, ANSWER);
        match &self.image {
            Some(path) => files.reads(path),
            None => files,
        }
    }
}

/// Sends, restarts, watches, accepts.
///
/// # Errors
/// The file is no image, or the board refuses or cannot be reached; what ran still runs, or comes back.
pub fn run(args: &Args, choice: &Choice) -> Result<ExitCode> {
    let image = args.image.as_ref().map(read).transpose()?;
    let mut board = choice.open()?;
    let before = update::ask(&mut board.link, UpdateOrder::Status)?;
    let mut given_up = None;
    match &image {
        Some(image) => {
            let was = board.link.status()?;
            install(&mut board.link, image, args.older)?;
            given_up = try_out(&mut board.link, image.header.version, &was, args)?;
        }
        None if args.accept => {
            update::ask(&mut board.link, UpdateOrder::Accept)?;
        }
        None if args.refuse => give_up(&mut board.link)?,
        None => {}
    }
    let failed = given_up.is_some();
    tell(args, board, before, given_up)?;
    Ok(if failed {
        ExitCode::FAILURE
    } else {
        ExitCode::SUCCESS
    })
}

fn read(path: &PathBuf) -> Result<Image> {
    let bytes = std::fs::read(path).with_context(|| path.display().to_string())?;
    Image::parse(&bytes).with_context(|| path.display().to_string())
}

/// Sends it and restarts the board.
fn install(link: &mut Link, image: &Image, older: bool) -> Result<()> {
    if link.status()?.map.is_some() {
        warn("the tooth map is out of force after the restart: load it again");
    }
    let bar = progress(0, "firmware: bytes");
    update::send(link, image, older, &bar)?;
    bar.finish_and_clear();
    link.restart()
}

/// Watches a new image and accepts it; or gives it up, and says why.
fn try_out(
    link: &mut Link,
    wanted: Version,
    was: &BoardStatus,
    args: &Args,
) -> Result<Option<String>> {
    let now = update::ask(link, UpdateOrder::Status)?;
    ensure!(
        now.running == wanted && now.trial_left_s.is_some(),
        "the board: found version {} running, wanted {wanted} on trial: the new image did not start",
        now.running
    );
    if args.leave_on_trial {
        return Ok(None);
    }
    let first = link.status()?.samples;
    link.pass(WATCH)?;
    let worse = worse(was, &link.status()?, first);
    match &worse {
        None => drop(update::ask(link, UpdateOrder::Accept)?),
        Some(_) => give_up(link)?,
    }
    Ok(worse)
}

/// What is worse than before the update. `first`: samples when the watch began.
fn worse(was: &BoardStatus, now: &BoardStatus, first: u32) -> Option<String> {
    let new = Status::from_bits_truncate(now.status & !was.status);
    let names: Vec<&str> = new.iter_names().map(|(name, _)| name).collect();
    let stored = |status: &BoardStatus| match status.in_force {
        InForce::Stored(place) => Some(place.sequence),
        _ => None,
    };
    match () {
        () if now.samples == first => Some("it takes no samples".into()),
        () if !names.is_empty() => Some(format!("its frames say {}", names.join(", "))),
        () if stored(was).is_some() && stored(now) != stored(was) => {
            Some("the stored calibration is not in force".into())
        }
        () => None,
    }
}

fn give_up(link: &mut Link) -> Result<()> {
    update::ask(link, UpdateOrder::Refuse)?;
    link.restart()
}

fn tell(
    args: &Args,
    mut board: Opened,
    before: UpdateStatus,
    given_up: Option<String>,
) -> Result<()> {
    let now = update::ask(&mut board.link, UpdateOrder::Status)?;
    board.close()?;
    let told = Told {
        before: before.running.to_string(),
        running: now.running.to_string(),
        on_trial: now.trial_left_s.is_some(),
        development_key: now.development_key,
        given_up,
    };
    args.json.tell(ANSWER, &told, || text(&told, &now))
}

fn text(told: &Told, now: &UpdateStatus) -> String {
    let mut rows = vec![];
    if let Some(why) = &told.given_up {
        rows.push(("given up", format!("{why}: the firmware before is back")));
    }
    let standing = match now.trial_left_s {
        Some(left_s) => format!("on trial, {left_s} s left to `courier update --accept`"),
        None => "kept".into(),
    };
    rows.push(("firmware", format!("{}, {standing}", told.running)));
    if told.before != told.running {
        rows.push(("before", told.before.clone()));
    }
    let key = match told.development_key {
        true => "the development key: anybody can sign an image that this board takes",
        false => "the firmware's own",
    };
    rows.push(("key", key.into()));
    pairs(&rows)
}
