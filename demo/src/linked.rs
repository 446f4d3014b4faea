//! Flights over the debug link, on whichever board there is.

use anyhow::{Result, bail};
use board_link::{Simulated, map};
use command_line::terminal::warn;
use courier_sensor::drivers::motion::Target;
use courier_sensor::frame::{Frame, Pose, RawFrame, Segment};
use courier_sensor::geometry::Geometry;
use courier_sensor::link::message::{Action, InForce, Reply};
use courier_sensor::link::telemetry::{Channels, Sample};
use std::time::Duration;

/// What a flight is judged by.
const CHANNELS: Channels = Channels::STATUS
    .union(Channels::RAW)
    .union(Channels::UNMODIFIED)
    .union(Channels::CALIBRATED)
    .union(Channels::POSE)
    .union(Channels::PARITY)
    .union(Channels::TAN_PSI);
/// Frames of a flight that are kept: one in this many, 1 kHz.
const DECIMATION: u16 = 20;
/// One flight takes 16 000 samples at 20 kHz: a motion of more than this never ends, samples.
const MOTION_LIMIT: u32 = 400_000;
/// Samples between two looks at a motion.
const LOOK_SAMPLES: u32 = 50;
/// Time of a sample at 20 kHz.
const SAMPLE: Duration = Duration::from_micros(50);

fn order(board: &mut Simulated, target: Target, speed_m_per_s: f32) -> Result<()> {
    let action = Action::GoTo {
        target,
        speed_m_per_s,
    };
    match board.link.ask(action)? {
        Reply::Done => Ok(()),
        _ => bail!("the board: found a strange reply to an order to move"),
    }
}

/// Waits for the end of a motion; `look` is called meanwhile and once afterwards.
fn settle(board: &mut Simulated, mut look: impl FnMut(&mut Simulated) -> Result<()>) -> Result<()> {
    for _ in 0..MOTION_LIMIT / LOOK_SAMPLES {
        rest(board, LOOK_SAMPLES)?;
        look(board)?;
        if !board.link.status()?.moving {
            return look(board);
        }
    }
    bail!("the motion controller has not settled after {MOTION_LIMIT} samples")
}

/// Goes to a pose and waits until the motion controller says that it has settled.
///
/// # Errors
/// A motion that never ends, or a board that cannot be reached.
pub fn go(board: &mut Simulated, goal: Target, speed_m_per_s: f32) -> Result<()> {
    order(board, goal, speed_m_per_s)?;
    settle(board, |_| Ok(()))
}

/// As [`go`]; gives one frame in [`DECIMATION`].
///
/// # Errors
/// As [`go`].
pub fn fly(board: &mut Simulated, goal: Target, speed_m_per_s: f32) -> Result<Vec<Frame>> {
    let mut frames = Vec::new();
    board.link.stream(CHANNELS, DECIMATION)?;
    order(board, goal, speed_m_per_s)?;
    settle(board, |board| {
        board.link.listen(|sample| {
            frames.push(frame(sample));
            Ok(())
        })
    })?;
    board.link.stream(Channels::empty(), 0)?;
    let (lost, came) = (board.link.lost(), frames.len());
    anyhow::ensure!(
        came > lost as usize,
        "the flight: {lost} samples were missed or not sent and {came} came, wanted more than half"
    );
    if lost > 0 {
        warn(&format!(
            "the flight: {lost} of {} samples were missed or not sent; each of the others stands at its own time",
            came + lost as usize
        ));
    }
    Ok(frames)
}

/// Lets so many samples pass.
///
/// # Errors
/// The board cannot be reached.
pub fn rest(board: &mut Simulated, samples: u32) -> Result<()> {
    board.link.pass(samples * SAMPLE)
}

/// Where the board says it is.
///
/// # Errors
/// The board cannot be reached.
pub fn pose(board: &mut Simulated) -> Result<Pose> {
    Ok(board.link.status()?.pose)
}

/// By which it says so.
///
/// # Errors
/// The board cannot be reached.
pub fn geometry(board: &mut Simulated) -> Result<Geometry> {
    if board.link.status()?.in_force == InForce::None {
        return Ok(Geometry::PAPER);
    }
    Ok(map::in_force(&mut board.link)?.geometry)
}

/// A frame as far as it was sent.
fn frame(sample: &Sample) -> Frame {
    let (quadrature_counts, electrode_counts) = sample.raw.unwrap_or_default();
    let unmodified = sample.unmodified.unwrap_or_default();
    let calibrated = sample.calibrated.unwrap_or_default();
    Frame {
        sequence: sample.sequence,
        status: sample.status.unwrap_or_default(),
        raw: RawFrame {
            quadrature_counts,
            electrode_counts,
            ..RawFrame::default()
        },
        segments: core::array::from_fn(|i| Segment {
            unmodified: unmodified[i],
            calibrated: calibrated[i],
            ..Segment::default()
        }),
        pose: sample.pose.unwrap_or_default(),
        parity_m: sample.parity_m.unwrap_or_default(),
        tan_psi: sample.tan_psi.unwrap_or_default(),
        ..Frame::default()
    }
}
