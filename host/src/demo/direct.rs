//! Flights on a simulated board whose parts are reached into, without a link.

use super::flight::{DECIMATION, MOTION_LIMIT, Pilot};
use anyhow::{Result, bail};
use courier_sensor::drivers::motion::Target;
use courier_sensor::frame::{Frame, Pose};
use courier_sensor::geometry::Geometry;
use hal_sim::board::SimBoard;
use hal_sim::world::World;

impl Pilot for SimBoard {
    fn go(&mut self, goal: Target, speed_m_per_s: f32) -> Result<()> {
        self.fly(goal, speed_m_per_s).map(drop)
    }

    fn fly(&mut self, goal: Target, speed_m_per_s: f32) -> Result<Vec<Frame>> {
        self.background.go_to(goal, speed_m_per_s)?;
        let mut frames = Vec::new();
        for _ in 0..MOTION_LIMIT {
            let frame = self.sample();
            if frame.sequence.is_multiple_of(u32::from(DECIMATION)) {
                frames.push(frame);
            }
            if !self.background.is_moving() {
                return Ok(frames);
            }
        }
        bail!("the motion controller has not settled after {MOTION_LIMIT} samples")
    }

    fn rest(&mut self, samples: u32) -> Result<()> {
        (0..samples).for_each(|_| {
            self.sample();
        });
        Ok(())
    }

    fn pose(&mut self) -> Result<Pose> {
        Ok(self.background.last_frame().pose)
    }

    fn geometry(&mut self) -> Result<Geometry> {
        Ok(self.background.keeper().settings().geometry)
    }

    fn world(&self) -> &World {
        &self.world
    }
}
