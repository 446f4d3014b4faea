//! The still poses of a session for a recording: one sample each, with the interferometer's and the plant's word at the same
//! conversion.

use super::record::Recorder;
use super::standstill::Standstills;
use anyhow::Result;
use board_link::Simulated;
use courier_sensor::calibration::Stage;
use courier_sensor::link::report::Progress;
use courier_sensor::link::telemetry::Channels;
use hal_sim::world::Witness;
use std::collections::VecDeque;

/// Samples sent: one in this many.
const DECIMATION: u32 = 20;
/// Witnesses kept: twice what a block of telemetry may be late.
const KEPT: usize = 4000;

/// Watches a session.
pub struct StillPoses {
    last: (Stage, u32),
    stills: Standstills<()>,
    witnesses: VecDeque<(u32, Witness)>,
}

impl StillPoses {
    /// From before the order on.
    ///
    /// # Errors
    /// The board cannot be reached.
    pub fn start(board: &mut Simulated) -> Result<Self> {
        let stills = Standstills::start(board, Channels::RECORDING, DECIMATION, DECIMATION)?;
        board.world.watch();
        Ok(Self {
            last: (Stage::Origin, 0),
            stills,
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
            self.stills.over(board, ());
        }
        self.stills.gather(board)?;
        self.witness(board);
        self.record(board, recorder)
    }

    /// Waits for what is still on its way, and ends the stream.
    ///
    /// # Errors
    /// As [`StillPoses::look`].
    pub fn finish(mut self, board: &mut Simulated, recorder: &mut Recorder) -> Result<()> {
        self.stills.finish(board)?;
        self.witness(board);
        self.record(board, recorder)?;
        board.world.unwatch();
        Ok(())
    }

    fn witness(&mut self, board: &Simulated) {
        let (_, seen) = board.world.unwatch();
        board.world.watch();
        let numbered = |witness: Witness| (board.number_at(witness.time_ns), witness);
        self.witnesses.extend(seen.into_iter().map(numbered));
        let old = self.witnesses.len().saturating_sub(KEPT);
        self.witnesses.drain(..old);
    }

    fn record(&mut self, board: &Simulated, recorder: &mut Recorder) -> Result<()> {
        while let Some((end, ())) = self.stills.next() {
            let Some(sample) = self.stills.samples().find(|sample| sample.sequence >= end) else {
                continue;
            };
            let mut witnesses = self.witnesses.iter();
            let found = witnesses.find(|(number, _)| *number == sample.sequence);
            if let Some((_, witness)) = found {
                recorder.pose(board, sample, witness)?;
            }
        }
        Ok(())
    }
}
