//! What the board sees at each pose of a joint session: means over the end of each standstill, for another method to fit, and for the
//! tooth map.

use crate::board::Simulated;
use crate::demo::still::{BEFORE, LOOK};
use crate::teeth::TeethPose;
use anyhow::{Result, ensure};
use courier_sensor::calibration::joint::{JointBuffer, JointSample};
use courier_sensor::calibration::{Sample, Stage};
use courier_sensor::frame::SEGMENTS;
use courier_sensor::geometry::Geometry;
use courier_sensor::link::report::Progress;
use courier_sensor::link::telemetry::{self, Channels};
use courier_sensor::settings::Settings;
use std::collections::VecDeque;

/// Samples sent: one in this many.
const DECIMATION: u32 = 5;
/// Samples of a standstill's end that are averaged, those not sent among them: 16 ms of the 80 ms that the courier rests.
const WINDOW: u32 = 320;
/// Means' noise is a sample's over the root of this.
pub const AVERAGED: u32 = WINDOW / DECIMATION;
/// Looks after the session's end in which the last samples come.
const LAST_LOOKS: usize = 40;

/// Telemetry and the session's progress go in, averaged poses come out.
pub struct Poses {
    /// Stage, poses done, poses lost at the last look.
    last: (Stage, u32, u32),
    /// Last sample of a standstill, and the stage that the pose belongs to.
    wanted: VecDeque<(u32, Stage)>,
    samples: VecDeque<telemetry::Sample>,
    geometry: Geometry,
    origin_teeth: [i32; SEGMENTS],
    is_held_out: bool,
    /// Poses in the order of their visit.
    pub buffer: Box<JointBuffer>,
    /// The same in metres from the board's tooth count zero.
    pub teeth: Vec<TeethPose>,
}

impl Poses {
    /// From before the order on.
    ///
    /// # Errors
    /// The board cannot be reached.
    pub fn start(board: &mut Simulated) -> Result<Self> {
        board.link.drop_samples()?;
        let channels = Channels::UNMODIFIED.union(Channels::TAN_PSI);
        board.link.stream(channels, DECIMATION as u16)?;
        Ok(Self {
            last: (Stage::Origin, 0, 0),
            wanted: VecDeque::new(),
            samples: VecDeque::new(),
            geometry: Settings::default().geometry,
            origin_teeth: [0; SEGMENTS],
            is_held_out: false,
            buffer: Box::new(JointBuffer::new()),
            teeth: Vec::new(),
        })
    }

    /// A look at the session; takes the poses whose samples have come.
    ///
    /// # Errors
    /// The board cannot be reached.
    pub fn look(&mut self, board: &mut Simulated, now: &Progress) -> Result<()> {
        let now = (now.stage, now.done, now.lost);
        let before = core::mem::replace(&mut self.last, now);
        let is_visited = !matches!(before.0, Stage::Solving | Stage::Finished);
        if is_visited && (before.0, before.1) != (now.0, now.1) && before.2 == now.2 {
            let end = board.sequence().saturating_sub(BEFORE);
            self.wanted.push_back((end, before.0));
        }
        self.gather(board)
    }

    /// Waits for what is still on its way, and ends the stream.
    ///
    /// # Errors
    /// As [`Poses::look`]; samples were lost on the link.
    pub fn finish(mut self, board: &mut Simulated) -> Result<Self> {
        for _ in 0..LAST_LOOKS {
            board.link.pass(LOOK)?;
            self.gather(board)?;
        }
        board.link.stream(Channels::empty(), 0)?;
        let (lost, missing) = (board.link.lost(), self.wanted.len());
        ensure!(
            lost == 0 && missing == 0,
            "the poses: found {lost} samples lost on the link and {missing} poses without samples, wanted none"
        );
        Ok(self)
    }

    fn gather(&mut self, board: &mut Simulated) -> Result<()> {
        let samples = &mut self.samples;
        board.link.listen(|sample| {
            samples.push_back(*sample);
            Ok(())
        })?;
        while let Some((end, stage)) = self.wanted.front().copied()
            && self.samples.back().is_some_and(|last| last.sequence >= end)
        {
            self.wanted.pop_front();
            self.take(end, stage);
        }
        let oldest = board.sequence().saturating_sub(2 * (WINDOW + BEFORE));
        let is_open = self.wanted.is_empty();
        while is_open
            && let Some(first) = self.samples.front()
            && first.sequence < oldest
        {
            self.samples.pop_front();
        }
        Ok(())
    }

    /// A pose whose standstill ended with that sample.
    fn take(&mut self, end: u32, stage: Stage) {
        let begin = end.saturating_sub(WINDOW);
        let stand = self.samples.iter().skip_while(|s| s.sequence <= begin);
        let stand = stand.take_while(|s| s.sequence <= end);
        let Some((sample, deflection)) = mean(stand, self.geometry.tan_full_scale) else {
            return;
        };
        if stage == Stage::Origin {
            let [x, y] = [0, 1].map(|i: usize| sample.unmodified[i].teeth);
            self.origin_teeth = [x, y, x, y];
            return;
        }
        if stage == Stage::HeldOut && !self.is_held_out {
            self.is_held_out = true;
            self.buffer.hold_out_rest();
        }
        let metres = sample.unmodified.map(|o| o.metres(self.geometry.pitch_m));
        self.teeth.push(TeethPose {
            outputs_m: metres,
            deflection: deflection.map(f64::from),
        });
        if let Some(sample) = JointSample::new(&self.origin_teeth, &sample, deflection) {
            self.buffer.push(sample);
        }
    }
}

/// Mean outputs and deflection; none of nothing.
fn mean<'a>(
    stand: impl Iterator<Item = &'a telemetry::Sample>,
    full_scale: f32,
) -> Option<(Sample, [f32; 2])> {
    let seen: Vec<_> = stand
        .filter_map(|sample| sample.unmodified.zip(sample.tan_psi))
        .collect();
    let share = 1.0 / seen.len() as f32;
    let first = seen.first()?.0;
    let mut sample = Sample {
        unmodified: first,
        ..Sample::ZERO
    };
    let mut deflection = [0.0; 2];
    for (unmodified, tan_psi) in &seen {
        for i in 0..SEGMENTS {
            sample.unmodified[i].fraction_turns += share * unmodified[i].minus_turns(first[i]);
        }
        for (mean, tan_psi) in deflection.iter_mut().zip(tan_psi) {
            *mean += share * tan_psi / full_scale;
        }
    }
    Some((sample, deflection))
}
