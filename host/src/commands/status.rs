//! `courier status`.

use super::status_map;
use super::status_next::next;
use crate::json::Json;
use crate::output::{Files, Kind};
use crate::board::{Choice, Link, map, update};
use crate::terminal::{figure, pairs};
use anyhow::{Result, bail};
use courier_sensor::calibration::rest_watch::RestKind;
use courier_sensor::calibration::watch::Standing;
use courier_sensor::frame::Status;
use courier_sensor::geometry::Geometry;
use courier_sensor::health::{Trouble, option_faults, troubles};
use courier_sensor::link::message::{
    Action, Activity, BoardStatus, ConverterTest, FaultReport, Health, Hello, InForce, MemoryTest,
    Reply, ResetCause,
};
use courier_sensor::teeth::Grid;
use courier_sensor::update::order::{UpdateOrder, UpdateStatus};
use serde::Serialize;
use std::process::ExitCode;

/// Show who a board is, how it is, and why it last restarted.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  courier --sim-flash board.bin status --json")]
pub struct Args {
    #[command(flatten)]
    json: Json,
}

/// What `--json` writes.
const ANSWER: Kind = Kind::json("an answer of `courier status`", &["board", "status"]);

impl Args {
    /// The files that it reads and writes.
    pub fn files(&self) -> Files {
        Files::default().json(&self.json, ANSWER)
    }
}

/// What `--json` prints.
#[derive(Serialize)]
struct Output {
    board: Hello,
    status: BoardStatus,
    status_bits: Vec<&'static str>,
    status_bits_seen: Vec<&'static str>,
    last_fault: Option<FaultReport>,
    /// How its firmware stands, if it takes updates.
    update: Option<UpdateStatus>,
    /// What is not as it should be of what the board has found out about itself, in words.
    troubles: Vec<String>,
    /// What has become of the stored tooth maps, in words.
    stored_map: String,
    /// What to do next, in sentences.
    next: Vec<String>,
}

/// Asks and prints.
///
/// # Errors
/// The board cannot be reached.
pub fn run(args: &Args, choice: &Choice) -> Result<ExitCode> {
    let mut board = choice.open()?;
    let Reply::Status(status) = board.link.ask(Action::Status)? else {
        bail!(super::STRANGE_REPLY)
    };
    let Reply::LastFault(last_fault) = board.link.ask(Action::LastFault)? else {
        bail!(super::STRANGE_REPLY)
    };
    // A board without a first stage refuses the question.
    let update = update::ask(&mut board.link, UpdateOrder::Status).ok();
    let joint = is_joint(&mut board.link, status.in_force)?;
    let place = match status_map::slot(&status.stored_map) {
        Some(slot) => map::slot(&mut board.link, slot).ok().and_then(|slot| slot.info),
        None => None,
    };
    let place = place.as_ref().map(|info| info.name.as_str());
    let output = Output {
        stored_map: status_map::text(&status.stored_map, place),
        next: next(&status, joint),
        troubles: troubles(&status.health)
            .iter()
            .map(Trouble::to_string)
            .collect(),
        board: board.link.hello().clone(),
        status_bits: names(status.status),
        status_bits_seen: names(status.status_seen),
        status,
        last_fault,
        update,
    };
    board.close()?;
    args.json.tell(ANSWER, &output, || text(&output))?;
    Ok(ExitCode::SUCCESS)
}

/// Whether a joint calibration is in force.
fn is_joint(link: &mut Link, in_force: InForce) -> Result<bool> {
    Ok(in_force != InForce::None && map::in_force(link)?.beacon.is_some())
}

/// Names of the bits that are set, as in docs/faults.md.
fn names(bits: u32) -> Vec<&'static str> {
    Status::from_bits_truncate(bits)
        .iter_names()
        .map(|(name, _)| name)
        .collect()
}

fn text(output: &Output) -> String {
    let (board, status) = (&output.board, &output.status);
    let mut rows = vec![
        (
            "board",
            format!(
                "{}, firmware {}, {} Hz",
                board.board, board.firmware, board.rate_hz
            ),
        ),
        ("device", board.device.to_string()),
        ("uptime", format!("{} s", status.time.uptime_s)),
        ("last start", cause(status.reset).to_owned()),
        ("calibration", in_force(status.in_force)),
        ("in service", status.watch.to_string()),
        ("recalibration", status.recalibration.to_string()),
        ("tooth map", tooth_map(status.map)),
        ("stored maps", output.stored_map.clone()),
        (
            "stored at start",
            status
                .boot
                .map_or_else(|| "in force".to_owned(), |why| why.to_string()),
        ),
        ("activity", activity(status).to_owned()),
        (
            "samples",
            format!(
                "{} taken, {} missed, {} not taken up, {} not sent",
                status.samples, status.missed, status.dropped_frames, status.lost_telemetry
            ),
        ),
        ("self-test", self_test(&status.health)),
        ("status", bits(status.status)),
        ("since last asked", bits(status.status_seen)),
    ];
    let after = rows.iter().position(|(name, _)| *name == "in service");
    let place = after.map_or(rows.len(), |after| after + 1);
    let (of_beacon, of_parity) = (&status.beacon_watch, &status.parity_watch);
    if of_beacon.standing != Standing::Unwatched {
        let words = of_beacon.words(RestKind::Beacon).to_string();
        rows.insert(place, ("beacon in service", words));
    }
    // While it is learned the line above says so.
    if !matches!(of_parity.standing, Standing::Unwatched | Standing::Learning) {
        let words = of_parity.words(RestKind::Parity).to_string();
        rows.insert(place, ("g_p in service", words));
    }
    rows.extend(readings(status));
    if let Some(temperature_c) = status.temperature_c {
        rows.push(("temperature", format!("{temperature_c:.1} °C")));
    }
    if let Some(cycles) = status.isr_cycles_worst {
        rows.push(("longest interrupt", format!("{cycles} cycles")));
    }
    if let Some(fault) = &output.last_fault {
        rows.push((
            "last fault",
            format!(
                "{} after {} s at {:#x}: {}",
                cause(fault.cause),
                fault.uptime_s, fault.program_counter, fault.message
            ),
        ));
    }
    if let Some(update) = &output.update {
        rows.push(("updates", standing(update)));
    }
    rows.extend(output.next.iter().map(|step| ("next", step.clone())));
    pairs(&rows)
}

/// Whether the firmware is on trial, and whose signature it trusts.
fn standing(update: &UpdateStatus) -> String {
    let trial = match update.trial_left_s {
        Some(left_s) => format!("on trial for {left_s} s, "),
        None => String::new(),
    };
    let key = match update.development_key {
        true => "signed by anybody (development key)",
        false => "signed with the key in the firmware",
    };
    format!("{trial}{key}")
}

/// What was tested, and how it went.
fn self_test(health: &Health) -> String {
    let converters = match health.converters {
        ConverterTest::NotRun => None,
        ConverterTest::Passed => Some("converters passed".to_owned()),
        ConverterTest::Failed(_) => Some("converters failed".to_owned()),
    };
    let memory = match health.memory {
        MemoryTest::NotRun => None,
        MemoryTest::Passed => Some("memory passed".to_owned()),
        MemoryTest::Failed { .. } => Some("memory failed".to_owned()),
    };
    let options = health.option_bytes.map(|bits| match &option_faults(bits)[..] {
        [] => format!("option bytes {bits:#010x} as wanted"),
        _ => format!("option bytes {bits:#010x} to be set"),
    });
    let clock = health
        .slow_clock_hz
        .map(|hz| format!("slow clock {hz} Hz"));
    let pulses = health.unanswered.map(|conversions| match conversions {
        0 => "a pulse of BUSY for each conversion".to_owned(),
        _ => "pulses of BUSY that do not fit the conversions".to_owned(),
    });
    let faults = match health.faults_in_a_row {
        0 => None,
        faults => Some(format!("{faults} faults in a row")),
    };
    let safe_mode = health.safe_mode.then(|| "safe mode".to_owned());
    let all = [
        converters, memory, options, pulses, clock, faults, safe_mode,
    ];
    all.into_iter().flatten().collect::<Vec<_>>().join(", ")
}

fn activity(status: &BoardStatus) -> &'static str {
    match status.activity {
        Activity::Calibrating => "calibrating",
        Activity::Solving => "calibrating: solving",
        Activity::Idle if status.moving => "moving",
        Activity::Idle => "none",
    }
}

fn cause(reset: ResetCause) -> &'static str {
    match reset {
        ResetCause::PowerOn => "power on",
        ResetCause::Pin => "reset pin or debug probe",
        ResetCause::Requested => "as ordered by a host",
        ResetCause::BrownOut => "supply too low",
        ResetCause::Watchdog => "watchdog",
        ResetCause::Panic => "panic",
        ResetCause::HardFault => "hard fault",
    }
}

/// Status bits in words and by name.
fn bits(bits: u32) -> String {
    let status = Status::from_bits_truncate(bits);
    match names(bits) {
        names if names.is_empty() => status.to_string(),
        names => format!("{status} ({})", names.join(" ")),
    }
}

/// What the sensors say, by the last frame.
fn readings(status: &BoardStatus) -> [(&'static str, String); 4] {
    let pitch_m = Geometry::PAPER.pitch_m;
    let pose = &status.pose;
    let amplitudes = status.amplitude_counts.map(|counts| format!("{counts:.0}"));
    let [x_mm, y_mm] = [pose.x, pose.y].map(|place| 1.0e3 * place.metres(pitch_m));
    let [theta_x, theta_y] = [pose.theta_x_rad, pose.theta_y_rad].map(|rad| 1.0e3 * rad);
    let parity_um = figure(1.0e6 * f64::from(status.parity_m));
    [
        ("amplitudes", amplitudes.join(" ") + " counts"),
        ("x, y", format!("{x_mm:.4} mm, {y_mm:.4} mm")),
        ("θ_x, θ_y", format!("{theta_x:.4} mrad, {theta_y:.4} mrad")),
        ("g_p", format!("{parity_um} µm")),
    ]
}

fn tooth_map(map: Option<[Grid; 2]>) -> String {
    map.map_or("none".to_owned(), |[x, y]| {
        format!(
            "in force, x {} by {} nodes, y {} by {}",
            x.nodes[0], x.nodes[1], y.nodes[0], y.nodes[1]
        )
    })
}

fn in_force(in_force: InForce) -> String {
    match in_force {
        InForce::None => "none in force".to_owned(),
        InForce::Unsaved => "in force, not stored".to_owned(),
        InForce::Stored(place) => {
            format!("in force, slot {}, number {}", place.slot, place.sequence)
        }
    }
}
