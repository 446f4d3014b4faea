//! Flights over the debug link, on whichever board there is.

use super::flight::{DECIMATION, MOTION_LIMIT, Pilot};
use crate::board::Simulated;
use anyhow::{Result, bail};
use courier_sensor::drivers::motion::Target;
use courier_sensor::frame::{Frame, Pose, RawFrame, Segment};
use courier_sensor::geometry::Geometry;
use courier_sensor::link::message::{Action, InForce, Reply, Source};
use courier_sensor::link::telemetry::{Channels, Sample};
use hal_sim::world::World;
use std::time::Duration;

/// What a flight is judged by.
const CHANNELS: Channels = Channels::STATUS
    .union(Channels::RAW)
    .union(Channels::UNMODIFIED)
    .union(Channels::CALIBRATED)
    .union(Channels::POSE)
    .union(Channels::PARITY)
    .union(Channels::TAN_PSI);
/// Samples between two looks at a motion.
const LOOK_SAMPLES: u32 = 50;
/// Time of a sample at 20 kHz.
const SAMPLE: Duration = Duration::from_micros(50);

impl Simulated {
    fn order(&mut self, target: Target, speed_m_per_s: f32) -> Result<()> {
        let action = Action::GoTo {
            target,
            speed_m_per_s,
        };
        match self.link.ask(action)? {
            Reply::Done => Ok(()),
            _ => bail!("the board: found a strange reply to an order to move"),
        }
    }

    /// Waits for the end of a motion; `look` is called meanwhile and once afterwards.
    fn settle(&mut self, mut look: impl FnMut(&mut Self) -> Result<()>) -> Result<()> {
        for _ in 0..MOTION_LIMIT / LOOK_SAMPLES {
            self.rest(LOOK_SAMPLES)?;
            look(self)?;
            if !self.link.status()?.moving {
                return look(self);
            }
        }
        bail!("the motion controller has not settled after {MOTION_LIMIT} samples")
    }
}

impl Pilot for Simulated {
    fn go(&mut self, goal: Target, speed_m_per_s: f32) -> Result<()> {
        self.order(goal, speed_m_per_s)?;
        self.settle(|_| Ok(()))
    }

    fn fly(&mut self, goal: Target, speed_m_per_s: f32) -> Result<Vec<Frame>> {
        let mut frames = Vec::new();
        self.link.stream(CHANNELS, DECIMATION)?;
        self.order(goal, speed_m_per_s)?;
        self.settle(|board| {
            board.link.listen(|sample| {
                frames.push(frame(sample));
                Ok(())
            })
        })?;
        self.link.stream(Channels::empty(), 0)?;
        let lost = self.link.lost();
        anyhow::ensure!(lost == 0, "the flight: {lost} samples lost on the link");
        Ok(frames)
    }

    fn rest(&mut self, samples: u32) -> Result<()> {
        self.link.pass(samples * SAMPLE)
    }

    fn pose(&mut self) -> Result<Pose> {
        Ok(self.link.status()?.pose)
    }

    fn geometry(&mut self) -> Result<Geometry> {
        if self.link.status()?.in_force == InForce::None {
            return Ok(Geometry::PAPER);
        }
        match self.link.ask(Action::Read(Source::InForce))? {
            Reply::Calibration(calibration) => Ok(calibration.geometry),
            _ => bail!("the board: found a strange reply to a question for its calibration"),
        }
    }

    fn world(&self) -> &World {
        &self.world
    }
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
