//! The motion controller at the far end of its serial line, bytes in and bytes out, and the courier that it moves.
//!
//! Open loop: it ends tens of micrometres off and does not know it. A motion whose heartbeat is missing it brakes by itself. [`MotionWire::line`] is the firmware's end (embedded-io),
//! [`MotionWire::motion`] the true motion for the plant. Both run the controller up to the time they are asked for.

mod controller;
mod line;

pub use controller::{ControllerConfig, LEVER_M, Misbehaviour};
pub use line::Line;

use super::clock::Clock;
use super::trajectory::Trajectory;
use crate::trajectory::PlaceError;
use controller::Controller;
use courier_sensor::link::framing::{Decoder, FrameCounters};
use effects::motion::{Motion, Pose};
use effects::random::{ChaCha8Rng, SeedableRng};
use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;

/// Both ends of the line and the courier. Clones are the same.
#[derive(Clone)]
pub struct MotionWire(Rc<RefCell<Controller>>);

impl MotionWire {
    /// A courier at rest at `start`.
    pub fn new(clock: Clock, config: ControllerConfig, start: Pose, seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        Self(Rc::new(RefCell::new(Controller {
            config,
            clock,
            place_error: PlaceError::draw(&mut rng),
            rng,
            told: Trajectory::standing(start),
            truth: Trajectory::standing(start),
            to_controller: VecDeque::new(),
            to_sensor: VecDeque::new(),
            decoder: Decoder::new(),
            brakes_ns: None,
            misbehaviour: Misbehaviour::None,
        })))
    }

    /// The firmware's end of the line.
    pub fn line(&self) -> Line {
        Line(self.0.clone())
    }

    /// The courier's true motion.
    pub fn motion(&self) -> CourierMotion {
        CourierMotion(self.0.clone())
    }

    /// Lets the controller be at fault from now on.
    pub fn misbehave(&self, misbehaviour: Misbehaviour) {
        self.0.borrow_mut().misbehaviour = misbehaviour;
    }

    /// What the controller has received.
    pub fn received(&self) -> FrameCounters {
        self.0.borrow().decoder.counters()
    }
}

/// True motion of the simulated courier.
#[derive(Clone)]
pub struct CourierMotion(Rc<RefCell<Controller>>);

impl Motion for CourierMotion {
    fn pose(&self, time_s: f64) -> Pose {
        let mut controller = self.0.borrow_mut();
        controller.run_until((time_s * 1e9).max(0.0) as u64);
        let pose = controller.truth.pose(time_s);
        match controller.misbehaviour {
            Misbehaviour::Sways(amplitude_m) => {
                let turn = std::f64::consts::TAU * 3.0 * time_s;
                pose.plus(Pose::new(1.0, 0.7, 1.0), amplitude_m * turn.sin())
            }
            _ => pose,
        }
    }
}
