//! What the board sees at each pose of a joint session: means over the end of each standstill, for another method to fit, and for the
//! tooth map.

use crate::standstill::Standstills;
use anyhow::{Result, ensure};
use board_link::Simulated;
use courier_sensor::calibration::joint::{JointBuffer, JointSample};
use courier_sensor::calibration::{Sample, Stage};
use courier_sensor::frame::SEGMENTS;
use courier_sensor::geometry::Geometry;
use courier_sensor::link::report::Progress;
use courier_sensor::link::telemetry::{self, Channels};
use courier_sensor::settings::Settings;
use tooth_map::TeethPose;

/// Samples sent: one in this many.
const DECIMATION: u32 = 5;
/// Samples of a standstill's end that are averaged, those not sent among them: 16 ms of the 80 ms that the courier rests.
const WINDOW: u32 = 320;
/// Means' noise is a sample's over the root of this.
pub const AVERAGED: u32 = WINDOW / DECIMATION;
/// Samples that a mean needs at least: its noise is then 15 % more. The board drops frames while a solution or the flash takes longer
/// than their queue lasts.
const LEAST: usize = (AVERAGED - AVERAGED / 4) as usize;

/// Telemetry and the session's progress go in, averaged poses come out.
pub struct Poses {
    /// Stage, poses done, poses lost at the last look.
    last: (Stage, u32, u32),
    /// Marked by the stage that the pose belongs to.
    stills: Standstills<Stage>,
    /// Poses of which too few samples came.
    missing: usize,
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
        let channels = Channels::UNMODIFIED.union(Channels::TAN_PSI);
        Ok(Self {
            last: (Stage::Origin, 0, 0),
            stills: Standstills::start(board, channels, DECIMATION, WINDOW)?,
            missing: 0,
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
            self.stills.over(board, before.0);
        }
        self.stills.gather(board)?;
        self.take_all();
        Ok(())
    }

    /// Waits for what is still on its way, and ends the stream.
    ///
    /// # Errors
    /// As [`Poses::look`]; too many samples of a pose were lost.
    pub fn finish(mut self, board: &mut Simulated) -> Result<Self> {
        self.stills.finish(board)?;
        self.take_all();
        let missing = self.missing + self.stills.waiting();
        ensure!(
            missing == 0,
            "the poses: found {missing} with less than {LEAST} of {AVERAGED} samples, wanted none"
        );
        Ok(self)
    }

    fn take_all(&mut self) {
        while let Some((end, stage)) = self.stills.next() {
            self.take(end, stage);
        }
    }

    /// A pose whose standstill ended with that sample.
    fn take(&mut self, end: u32, stage: Stage) {
        let begin = end.saturating_sub(WINDOW);
        let stand = self.stills.samples().skip_while(|s| s.sequence <= begin);
        let stand = stand.take_while(|s| s.sequence <= end);
        let Some((sample, deflection)) = mean(stand, self.geometry.tan_full_scale) else {
            self.missing += 1;
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

/// Mean outputs and deflection; none of less than [`LEAST`].
fn mean<'a>(
    stand: impl Iterator<Item = &'a telemetry::Sample>,
    full_scale: f32,
) -> Option<(Sample, [f32; 2])> {
    let seen: Vec<_> = stand
        .filter_map(|sample| sample.unmodified.zip(sample.tan_psi))
        .collect();
    let first = seen.first().filter(|_| seen.len() >= LEAST)?.0;
    let share = 1.0 / seen.len() as f32;
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
