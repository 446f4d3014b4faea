//! `courier load` of a tooth map.

use super::load::Args;
use crate::board::{Choice, Link, map, motion};
use crate::teeth::{Evidence, MapFile};
use anyhow::{Context, Result, bail, ensure};
use courier_sensor::app::background::SELF_MOTION_M_PER_S;
use courier_sensor::calibration::record::{Calibration, Quality};
use courier_sensor::calibration::rest_watch::MOST_DEFLECTION;
use courier_sensor::frame::Status;
use courier_sensor::link::message::{BoardStatus, InForce, MapPlace, StoredMap};
use courier_sensor::link::telemetry::Channels;
use courier_sensor::maps::Name;
use courier_sensor::maps::homing::{MOST_LEFT_TURNS, Mean, whole_teeth};
use serde_json::{Value, json};
use std::path::Path;
use std::process::ExitCode;
use std::time::Duration;

/// One frame in so many is looked at under the beacon, and so many of them: a quarter of a second.
const DECIMATION: u16 = 50;
const LOOKS: u16 = 100;
/// Looks at the channels, or at the board's status, until something must have come.
const PATIENCE: usize = 150;
/// Time between two.
const LOOK: Duration = Duration::from_millis(20);
const CHANNELS: Channels = Channels::STATUS
    .union(Channels::POSE)
    .union(Channels::TAN_PSI);

/// Goes under the beacon, makes sure that it is the map's, and stores the map, which the board then puts in force by itself; or, with
/// `--dry-run`, puts it in force alone.
///
/// # Errors
/// The board has no calibration, sees no beacon or not the map's, or refuses; a map that was in force may be out of it then, which
/// is told.
pub fn run(file: &MapFile, args: &Args, choice: &Choice) -> Result<ExitCode> {
    let name = name_of(args)?;
    let mut board = choice.open()?;
    let start = args.from.or(board.beacon);
    let link = &mut board.link;
    let calibration = map::in_force(link)?;
    check(file, &calibration, &link.status()?, args.dry_run)?;
    if let Some(target) = start {
        motion::go(link, target, SELF_MOTION_M_PER_S)?;
    }
    let ahead_teeth = teeth_ahead(link, file, &calibration)?;
    let stored = match args.dry_run {
        true => {
            put_in_force(link, file, calibration, ahead_teeth)?;
            None
        }
        false => Some(store(link, file, calibration, name)?),
    };
    let grids = link
        .status()?
        .map
        .context("the board: found no tooth map in force, wanted the one that was loaded")?;
    board.close()?;
    let told = json!({ "map": grids, "teeth_ahead": ahead_teeth, "stored": stored });
    let [x, y] = grids.map(|grid| grid.nodes);
    let kept = match &stored {
        Some(stored) => format!(
            "stored: map slot {}, `{}`; after a restart the board puts it in force as soon as it sees the beacon",
            stored["slot"],
            stored["name"].as_str().unwrap_or_default()
        ),
        None => {
            "not stored: it is lost when the board restarts or another calibration comes in force"
                .to_owned()
        }
    };
    args.json.tell(super::load::ANSWER, &told, || {
        format!(
            "tooth map of {} by {} and {} by {} nodes in force, with its own coefficients of equations (3) and (9)\nby the beacon the board counts {} and {} teeth ahead of the map's recording\n{kept}",
            x[0], x[1], y[0], y[1], ahead_teeth[0], ahead_teeth[1]
        )
    })?;
    Ok(ExitCode::SUCCESS)
}

/// The place's name: as given, or the file's.
fn name_of(args: &Args) -> Result<Name> {
    let stem = |path: &Path| {
        path.file_stem()
            .map(|stem| stem.to_string_lossy().into_owned())
    };
    let text = args
        .place
        .clone()
        .or_else(|| stem(&args.model))
        .unwrap_or_default();
    let is_good = !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_graphic());
    let name = Name::try_from(text.as_str()).ok().filter(|_| is_good);
    name.with_context(|| {
        format!("--place: found `{text}`, wanted the name of a place: 1 to 16 printable ASCII characters without spaces")
    })
}

/// Whether the map can be this board's at all.
fn check(
    file: &MapFile,
    calibration: &Calibration,
    status: &BoardStatus,
    dry_run: bool,
) -> Result<()> {
    let (anchor, own) = (&file.map.anchor, &calibration.geometry);
    for (what, found, wanted) in [
        ("pitch_m", anchor.pitch_m, own.pitch_m),
        ("tan_full_scale", anchor.tan_full_scale, own.tan_full_scale),
    ] {
        let wanted = f64::from(wanted);
        ensure!(
            (found - wanted).abs() <= 1.0e-5 * wanted.abs(),
            "the map: anchor.{what}: found {found:.6}, wanted the board's, {wanted:.6}: it is of another sensor"
        );
    }
    ensure!(
        dry_run || matches!(status.in_force, InForce::Stored(_)),
        "the board: found a calibration in force that is not stored, wanted it stored: a map is kept beside it (`courier commit`)"
    );
    Ok(())
}

/// Whole teeth by which the board's count is ahead of the map's, by the beacon above it.
fn teeth_ahead(link: &mut Link, file: &MapFile, calibration: &Calibration) -> Result<[i32; 2]> {
    let geometry = &calibration.geometry;
    let anchor = file.map.anchor.on_board();
    let (mut mean, mut farthest) = (Mean::default(), 0.0_f32);
    link.stream(CHANNELS, DECIMATION)?;
    for _ in 0..PATIENCE {
        link.pass(LOOK)?;
        link.listen(|sample| {
            let status = sample.status.unwrap_or(Status::BEACON_MISSING);
            let doubtful = Status::BEACON_MISSING.union(Status::BEACON_SATURATED);
            if let (Some(pose), Some(tan_psi), false) =
                (sample.pose, sample.tan_psi, status.intersects(doubtful))
            {
                mean.add(&anchor.ahead(geometry, &pose, tan_psi));
                farthest = tan_psi
                    .into_iter()
                    .map(|t| t.abs() / geometry.tan_full_scale)
                    .fold(farthest, f32::max);
            }
            Ok(())
        })?;
        if mean.frames() >= LOOKS {
            break;
        }
    }
    link.stream(Channels::empty(), 0)?;
    let found = mean.frames();
    ensure!(
        found >= LOOKS,
        "the board: found the beacon in {found} frames, wanted {LOOKS}: a map is placed by its beacon (--from goes there)"
    );
    ensure!(
        farthest <= MOST_DEFLECTION,
        "the board: found the beacon at {farthest:.2} of the diode's range, wanted {MOST_DEFLECTION} or less: stand under it"
    );
    let ahead = mean
        .mean()
        .context("the board: found places that disagree, wanted the courier at rest")?;
    whole_teeth(&ahead).with_context(|| {
        let [x, y] = ahead.map(|ahead| f64::from(ahead.teeth) + f64::from(ahead.fraction_turns));
        let axis = match ahead[0].fraction_turns.abs() > MOST_LEFT_TURNS {
            true => "x",
            false => "y",
        };
        let found = if axis == "x" { x } else { y };
        format!(
            "the board: found its count {found:.2} teeth ahead of the map's along {axis}, wanted a whole number within {MOST_LEFT_TURNS}: is this the map's beacon, unmoved?"
        )
    })
}

/// The map's coefficients and the beacon's place in force, then the map; nothing is stored.
fn put_in_force(
    link: &mut Link,
    file: &MapFile,
    calibration: Calibration,
    ahead_teeth: [i32; 2],
) -> Result<()> {
    let mut calibration = with_model(file, calibration);
    let geometry = &calibration.geometry;
    if let Some(beacon) = &mut calibration.beacon {
        let origin = file.map.anchor.on_board().origin(ahead_teeth, geometry);
        (beacon.origin_teeth, beacon.origin_m) = origin;
    }
    map::load(link, calibration)?;
    map::load_map(link, file.header_for(ahead_teeth), &file.map.nodes_nm)
}

/// Stores the map with its coefficients, and waits until the board has put it in force: what is told of it.
fn store(link: &mut Link, file: &MapFile, calibration: Calibration, name: Name) -> Result<Value> {
    map::load(link, with_model(file, calibration))?;
    let place = MapPlace {
        name,
        anchor: file.map.anchor.on_board(),
        parity_m: parity_left_m(&file.map.evidence) as f32,
    };
    let stored = map::store_map(link, place, file.map.header.clone(), &file.map.nodes_nm)?;
    let mut last = StoredMap::None;
    for _ in 0..PATIENCE {
        link.pass(LOOK)?;
        last = link.status()?.stored_map;
        if matches!(last, StoredMap::InForce { slot, .. } if slot == stored.slot) {
            let name = stored.info.map(|info| info.name.to_string());
            return Ok(json!({ "slot": stored.slot, "name": name }));
        }
    }
    bail!(
        "the board: found the map stored in slot {} and not in force ({}), wanted it in force",
        stored.slot,
        super::status_map::text(&last, None)
    )
}

/// g_p that is left beyond the noise of four segments.
fn parity_left_m(evidence: &Evidence) -> f64 {
    let noise_m = 2.0 * evidence.segment_noise_m;
    (evidence.after_m[0].powi(2) - noise_m.powi(2))
        .max(0.0)
        .sqrt()
}

fn with_model(file: &MapFile, calibration: Calibration) -> Calibration {
    Calibration {
        model: file.map.model.clone(),
        quality: Quality::default(),
        poses: None,
        ..calibration
    }
}
