//! `courier monitor`.

use crate::output::{Files, Kind};
use crate::board::{Choice, geometry};
use crate::json::Lines;
use crate::live::Live;
use crate::monitor_file::MonitorFile;
use crate::monitor_server::MonitorServer;
use crate::seen::Seen;
use crate::terminal::{figure, warn};
use anyhow::{Result, ensure};
use courier_sensor::frame::Pose;
use courier_sensor::geometry::Geometry;
use courier_sensor::link::telemetry::{Channels, Sample};
use serde::Serialize;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::process::ExitCode;

/// Watch a board's pose, parity and status as they come.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  courier monitor --rate-hz 50 --seconds 10\n  courier monitor --rate-hz 200 --mcap watched.mcap\n  courier monitor --rate-hz 50 --serve")]
pub struct Args {
    /// Lines a second.
    #[arg(long, default_value_t = 10.0, value_name = "HZ")]
    rate_hz: f64,
    /// Write what comes into this new MCAP file as well, for Foxglove and PlotJuggler: all but the last second is there even if this
    /// command is ended.
    #[arg(long, value_name = "FILE")]
    mcap: Option<PathBuf>,
    /// Let programs connect and draw while it runs: Foxglove, Lichtblick and PlotJuggler, by Foxglove's WebSocket. Other computers can connect
    /// only if an address of this one is given.
    #[arg(long, value_name = "ADDRESS:PORT", num_args = 0..=1, default_missing_value = "127.0.0.1:8765")]
    serve: Option<SocketAddr>,
    #[command(flatten)]
    live: Live,
}

/// What `--json` writes.
const LINES: Kind = Kind::Lines { what: "lines of `courier monitor`", keys: &["sequence", "t_s"] };

impl Args {
    /// The files that it reads and writes.
    pub fn files(&self) -> Files {
        Files::default().json(&self.live.json, LINES)
    }
}

/// One line of `--json`.
#[derive(Serialize)]
struct Line {
    sequence: u32,
    t_s: f64,
    x_m: f64,
    y_m: f64,
    theta_x_rad: f32,
    theta_y_rad: f32,
    parity_m: f32,
    status: Vec<&'static str>,
}

/// Streams and prints.
///
/// # Errors
/// The board cannot be reached, or a rate that it cannot send.
pub fn run(args: &Args, choice: &Choice) -> Result<ExitCode> {
    args.live.seconds()?;
    let mut besides = Besides::new(args)?;
    let mut board = choice.open()?;
    let board_hz = f64::from(board.link.hello().rate_hz);
    let decimation = (board_hz / args.rate_hz).round();
    ensure!(
        (1.0..=f64::from(u16::MAX)).contains(&decimation),
        "--rate-hz: found {}, wanted {:.2} to {board_hz}",
        args.rate_hz,
        board_hz / f64::from(u16::MAX)
    );
    let pitch_m = geometry::in_force(&mut board.link).unwrap_or(Geometry::PAPER).pitch_m;
    let channels = Channels::STATUS | Channels::POSE | Channels::PARITY;
    board.link.stream(channels, decimation as u16)?;
    let mut lines = args.live.json.lines()?;
    args.live.watch(&mut board.link, |link| {
        link.listen(|sample| line(sample, board_hz, pitch_m, &mut lines, &mut besides))
    })?;
    besides.end()?;
    let lost = board.link.lost();
    board.link.stream(Channels::empty(), 0)?;
    if lost > 0 {
        warn(&format!("{lost} samples were lost on the way"));
    }
    board.close()?;
    Ok(ExitCode::SUCCESS)
}

/// Who takes what is seen besides the terminal.
struct Besides {
    file: Option<MonitorFile>,
    server: Option<MonitorServer>,
}

impl Besides {
    fn new(args: &Args) -> Result<Self> {
        let server = args.serve.map(MonitorServer::new).transpose()?;
        if let Some(server) = &server {
            eprintln!("to draw it while it runs, connect to ws://{}", server.address()?);
        }
        let file = args.mcap.as_deref().map(MonitorFile::new).transpose()?;
        Ok(Self { file, server })
    }

    fn push(&mut self, seen: &Seen) -> Result<()> {
        if let Some(file) = &mut self.file {
            file.push(seen)?;
        }
        if let Some(server) = &mut self.server {
            server.push(seen)?;
        }
        Ok(())
    }

    fn end(self) -> Result<()> {
        self.file.map_or(Ok(()), MonitorFile::end)
    }
}

fn line(sample: &Sample, board_hz: f64, pitch_m: f32, lines: &mut Lines, besides: &mut Besides) -> Result<()> {
    let Pose {
        x,
        y,
        theta_x_rad,
        theta_y_rad,
        ..
    } = sample.pose.unwrap_or_default();
    let bits = sample.status.unwrap_or_default();
    let line = Line {
        sequence: sample.sequence,
        t_s: f64::from(sample.sequence) / board_hz,
        x_m: x.metres(pitch_m),
        y_m: y.metres(pitch_m),
        theta_x_rad,
        theta_y_rad,
        parity_m: sample.parity_m.unwrap_or_default(),
        status: bits.iter_names().map(|(name, _)| name).collect(),
    };
    let parity_um = figure(1.0e6 * f64::from(line.parity_m));
    let names = line.status.join(" ");
    besides.push(&Seen {
        t_s: line.t_s,
        place_m: [line.x_m, line.y_m],
        theta_rad: [theta_x_rad, theta_y_rad].map(f64::from),
        parity_m: f64::from(line.parity_m),
        status: (bits.bits(), &names),
    })?;
    lines.push(&line, || format!(
        "{:10.3} s  x {:10.4} mm  y {:10.4} mm  θ {:8.4} mrad  g_p {parity_um:>7} µm  {}",
        line.t_s,
        1.0e3 * line.x_m,
        1.0e3 * line.y_m,
        0.5e3 * (theta_x_rad + theta_y_rad),
        bits
    ))
}
