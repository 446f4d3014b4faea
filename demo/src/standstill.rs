//! What the samples of a session say of each standstill: both the recording and the joint calibration's poses take them from here.

use anyhow::Result;
use board_link::Simulated;
use courier_sensor::link::telemetry::{Channels, Sample};
use std::collections::VecDeque;
use std::time::Duration;

/// Time between two looks at a session of which every pose is to be seen.
pub const LOOK: Duration = Duration::from_micros(2500);
/// So long before a pose was seen to be done the courier stood there: the look, the link and a part of the averaging, samples.
const BEFORE: u32 = 80;
/// Looks after the session's end in which the last samples come.
const LAST_LOOKS: usize = 40;

/// Samples on their way, and the standstills that wait for theirs; each has a mark of the caller's.
pub struct Standstills<T> {
    wanted: VecDeque<(u32, T)>,
    samples: VecDeque<Sample>,
    /// Numbers of samples that a standstill needs up to its end.
    window: u32,
}

impl<T: Copy> Standstills<T> {
    /// Asks for the stream; standstills will want samples of the last `window` numbers.
    ///
    /// # Errors
    /// The board cannot be reached.
    pub fn start(
        board: &mut Simulated,
        channels: Channels,
        decimation: u32,
        window: u32,
    ) -> Result<Self> {
        board.link.drop_samples()?;
        board.link.stream(channels, decimation as u16)?;
        Ok(Self {
            wanted: VecDeque::new(),
            samples: VecDeque::new(),
            window,
        })
    }

    /// A standstill has just been seen to be over.
    pub fn over(&mut self, board: &Simulated, mark: T) {
        let end = board.sequence().saturating_sub(BEFORE);
        self.wanted.push_back((end, mark));
    }

    /// Takes what has come. Old samples go where no standstill waits for them.
    ///
    /// # Errors
    /// The board cannot be reached.
    pub fn gather(&mut self, board: &mut Simulated) -> Result<()> {
        let reach = 2 * (self.window + BEFORE);
        let oldest = board.sequence().saturating_sub(reach);
        if self.wanted.is_empty() {
            while self.samples.front().is_some_and(|s| s.sequence < oldest) {
                self.samples.pop_front();
            }
        }
        let samples = &mut self.samples;
        board.link.listen(|sample| {
            samples.push_back(*sample);
            Ok(())
        })
    }

    /// The next standstill whose samples have all come: number of its last one, and its mark.
    pub fn next(&mut self) -> Option<(u32, T)> {
        let (end, _) = self.wanted.front()?;
        let has_come = self.samples.back().is_some_and(|s| s.sequence >= *end);
        has_come.then(|| self.wanted.pop_front()).flatten()
    }

    /// What has come and is kept, oldest first.
    pub fn samples(&self) -> impl Iterator<Item = &Sample> {
        self.samples.iter()
    }

    /// Standstills that still wait.
    pub fn waiting(&self) -> usize {
        self.wanted.len()
    }

    /// Waits for what is still on its way, and ends the stream.
    ///
    /// # Errors
    /// The board cannot be reached.
    pub fn finish(&mut self, board: &mut Simulated) -> Result<()> {
        for _ in 0..LAST_LOOKS {
            board.link.pass(LOOK)?;
            self.gather(board)?;
        }
        board.link.stream(Channels::empty(), 0)
    }
}
