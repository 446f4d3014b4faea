//! The still poses of a session for a recording: one sample each, with the interferometer's and the plant's word at the same
//! conversion.

use super::record::Recorder;
use crate::board::Simulated;
use anyhow::Result;
use courier_sensor::calibration::Stage;
use courier_sensor::link::report::Progress;
use courier_sensor::link::telemetry::{Channels, Sample};
use hal_sim::world::Witness;
use std::collections::VecDeque;
use std::time::Duration;

/// Time between two looks at a session of which every pose is to be seen.
pub const LOOK: Duration = Duration::from_micros(2500);
/// Samples sent: one in this many.
const DECIMATION: u16 = 20;
/// So long before a pose was seen to be done the courier stood there: the look, the link and a part of the averaging.
pub(super) const BEFORE: u32 = 80;
/// Samples and witnesses kept: twice what a block of telemetry may be late.
const KEPT: usize = 4000;

/// Watches a session.
pub struct StillPoses {
    last: (Stage, u32),
    wanted: VecDeque<u32>,
    samples: VecDeque<Sample>,
    witnesses: VecDeque<(u64, Witness)>,
}

impl StillPoses {
    /// From before the order on.
    ///
    /// # Errors
    /// The board cannot be reached.
    pub fn start(board: &mut Simulated) -> Result<Self> {
        board.link.stream(Channels::RECORDING, DECIMATION)?;
        board.world.watch();
        Ok(Self {
            last: (Stage::Origin, 0),
            wanted: VecDeque::new(),
            samples: VecDeque::new(),
            witnesses: VecDeque::new(),
        })
    }

    /// A look at the session; records the poses whose samples have come.
    ///
    /// # Errors
    /// The board cannot be reached, or the recording cannot be written.
    pub fn look(
        &mut self,
        board: &mut Simulated,
        now: &Progress,
        recorder: &mut Recorder,
    ) -> Result<()> {
        if (now.stage, now.done) != self.last {
            self.last = (now.stage, now.done);
            self.wanted
                .push_back(board.sequence().saturating_sub(BEFORE));
        }
        self.gather(board)?;
        self.record(board, recorder)
    }

    /// Waits for what is still on its way, and ends the stream.
    ///
    /// # Errors
    /// As [`StillPoses::look`].
    pub fn finish(mut self, board: &mut Simulated, recorder: &mut Recorder) -> Result<()> {
        for _ in 0..40 {
            board.link.pass(LOOK)?;
            self.gather(board)?;
        }
        self.record(board, recorder)?;
        board.world.unwatch();
        board.link.stream(Channels::empty(), 0)
    }

    fn gather(&mut self, board: &mut Simulated) -> Result<()> {
        let samples = &mut self.samples;
        board.link.listen(|sample| {
            samples.push_back(*sample);
            Ok(())
        })?;
        let (first, seen) = board.world.unwatch();
        board.world.watch();
        self.witnesses.extend((first..).zip(seen));
        let old = |length: usize| length.saturating_sub(KEPT);
        self.samples.drain(..old(self.samples.len()));
        self.witnesses.drain(..old(self.witnesses.len()));
        Ok(())
    }

    fn record(&mut self, board: &Simulated, recorder: &mut Recorder) -> Result<()> {
        let first = board.world.first_conversion();
        while let Some(wanted) = self.wanted.front() {
            let mut samples = self.samples.iter();
            let Some(sample) = samples.find(|sample| sample.sequence >= *wanted) else {
                return Ok(());
            };
            self.wanted.pop_front();
            let conversion = first + u64::from(sample.sequence);
            let found = self
                .witnesses
                .iter()
                .find(|(number, _)| *number == conversion);
            if let Some((_, witness)) = found {
                recorder.pose(board, sample, witness)?;
            }
        }
        Ok(())
    }
}
