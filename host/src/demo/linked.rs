//! Flights over the debug link, on whichever board there is.

use super::flight::{DECIMATION, MOTION_LIMIT};
use crate::board::{Simulated, map};
use anyhow::{Result, bail};
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

    /// Goes to a pose and waits until the motion controller says that it has settled.
    ///
    /// # Errors
    /// A motion that never ends, or a board that cannot be reached.
    pub(super) fn go(&mut self, goal: Target, speed_m_per_s: f32) -> Result<()> {
        self.order(goal, speed_m_per_s)?;
        self.settle(|_| Ok(()))
    }

    /// As [`Simulated::go`]; gives one frame in [`DECIMATION`].
    ///
    /// # Errors
    /// As [`Simulated::go`].
    pub(super) fn fly(&mut self, goal: Target, speed_m_per_s: f32) -> Result<Vec<Frame>> {
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

    /// Lets so many samples pass.
    ///
    /// # Errors
    /// The board cannot be reached.
    pub(super) fn rest(&mut self, samples: u32) -> Result<()> {
        self.link.pass(samples * SAMPLE)
    }

    /// Where the board says it is.
    ///
    /// # Errors
    /// The board cannot be reached.
    pub(super) fn pose(&mut self) -> Result<Pose> {
        Ok(self.link.status()?.pose)
    }

    /// By which it says so.
    ///
    /// # Errors
    /// The board cannot be reached.
    pub(super) fn geometry(&mut self) -> Result<Geometry> {
        if self.link.status()?.in_force == InForce::None {
            return Ok(Geometry::PAPER);
        }
        Ok(map::in_force(&mut self.link)?.geometry)
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
