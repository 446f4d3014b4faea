//! Straight flights of a simulated courier, commanded to its board: the board goes there, the interferometer looks on.

use super::linked;
use anyhow::{Result, ensure};
use board_link::Simulated;
use courier_sensor::app::background::SELF_MOTION_M_PER_S;
use courier_sensor::drivers::motion::Target;
use courier_sensor::frame::Frame;
use effects::motion::Pose;
use hal_sim::world::Witness;
use std::collections::HashMap;

/// Speed on the way to its start, m/s.
const POSITIONING_M_PER_S: f32 = SELF_MOTION_M_PER_S;
/// Rest before the flight, 0.25 s at 20 kHz: the swing after a stop must not be carried into a straight line, samples.
const CALM_SAMPLES: u32 = 5000;
/// A straight flight along y over `length_m` about `middle`: frames at 1 kHz, and what the interferometer read at each.
///
/// # Errors
/// A motion that never ends.
pub fn fly_along(
    board: &mut Simulated,
    middle: Pose,
    length_m: f64,
    speed_m_per_s: f32,
) -> Result<Vec<(Frame, Witness)>> {
    let end = line_up(board, middle, 0.5 * length_m)?;
    let start = line_up(board, middle, -0.5 * length_m)?;
    linked::go(board, start, POSITIONING_M_PER_S)?;
    linked::rest(board, CALM_SAMPLES)?;
    board.world.watch();
    let frames = linked::fly(board, end, speed_m_per_s)?;
    let (_, witnesses) = board.world.unwatch();
    let numbered = |witness: Witness| (board.number_at(witness.time_ns), witness);
    let witnesses: HashMap<u32, Witness> = witnesses.into_iter().map(numbered).collect();
    let wanted = frames.len();
    let of = |frame: Frame| Some((frame, *witnesses.get(&frame.sequence)?));
    let flight: Vec<_> = frames.into_iter().filter_map(of).collect();
    // A conversion that came late has another one's number: its frame is left out.
    ensure!(
        2 * flight.len() >= wanted,
        "the interferometer: found {} readings for {wanted} frames, wanted half of them at least",
        flight.len()
    );
    Ok(flight)
}

/// Goes to a pose and waits there.
///
/// # Errors
/// A motion that never ends.
pub fn stand_at(board: &mut Simulated, pose: Pose) -> Result<()> {
    let goal = Target {
        x_m: pose.x_m as f32,
        y_m: pose.y_m as f32,
        theta_rad: pose.theta_rad as f32,
    };
    linked::go(board, goal, POSITIONING_M_PER_S)?;
    linked::rest(board, CALM_SAMPLES)
}

/// The command that brings the courier to `along_m` on the line through `middle`. The controller is open loop and tens of
/// micrometres off; the phase of the platen sensor tells by how much, and angle alike.
fn line_up(board: &mut Simulated, middle: Pose, along_m: f64) -> Result<Target> {
    let pitch_m = f64::from(linked::geometry(board)?.pitch_m);
    let mut goal = Target {
        x_m: middle.x_m as f32,
        y_m: (middle.y_m + along_m) as f32,
        theta_rad: middle.theta_rad as f32,
    };
    linked::go(board, goal, POSITIONING_M_PER_S)?;
    let pose = linked::pose(board)?;
    let off_turns = f64::from(pose.x.fraction_turns) - middle.x_m / pitch_m;
    goal.x_m -= ((off_turns - off_turns.round()) * pitch_m) as f32;
    goal.theta_rad -= pose.theta_rad - middle.theta_rad as f32;
    Ok(goal)
}
