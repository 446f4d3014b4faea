//! What a board's raw samples show of its wires and stated values while it calibrates itself.
//!
//! The board fits what it is told; that two plugs are exchanged it cannot know. Here its readings are held against each other as those
//! of a recording are.

use crate::board::Link;
use crate::findings::{self, SEGMENTS};
use crate::recorder::{self, WANTED};
use crate::terminal::warn;
use anyhow::{Result, bail};
use courier_sensor::link::message::Action;
use courier_sensor::link::report::Progress;
use courier_sensor::link::telemetry::{Channels, Sample};
use recording::{Recording, Samples};

/// Rows a second: poses are some tenths of a second apart.
const ROWS_PER_S: f64 = 100.0;
/// Rows of the first look; the next ones come at twice as many each. Ten seconds hold some thirty poses, as many as a relation needs.
const FIRST_LOOK: usize = 1000;

/// The samples of a session so far.
pub struct Witness {
    seen: Recording,
    rate_hz: f64,
    first: Option<u32>,
    next_look: usize,
}

impl Witness {
    /// Lets the board send samples from now on.
    ///
    /// # Errors
    /// The board cannot be reached or refuses.
    pub fn start(link: &mut Link) -> Result<Self> {
        let rate_hz = f64::from(link.hello().rate_hz);
        let meta = recorder::meta(link);
        link.drop_samples()?;
        let decimation = (rate_hz / ROWS_PER_S)
            .round()
            .clamp(1.0, f64::from(u16::MAX));
        link.stream(WANTED, decimation as u16)?;
        Ok(Self {
            seen: Recording {
                meta,
                samples: Samples::default(),
                warnings: Vec::new(),
            },
            rate_hz,
            first: None,
            next_look: FIRST_LOOK,
        })
    }

    /// Takes what has come, and looks at it where that is due: a session on readings that cannot be right is ended, and the calibration in
    /// force stays.
    ///
    /// # Errors
    /// Wires, units or the pitch of the segments cannot be right; the line says what would be. The board cannot be reached.
    pub fn look(&mut self, link: &mut Link, now: &Progress) -> Result<()> {
        link.listen(|sample| {
            self.take(sample);
            Ok(())
        })?;
        if self.seen.samples.len() < self.next_look || now.ending.is_some() {
            return Ok(());
        }
        self.next_look *= 2;
        let (wrong, _) = findings::sorted(&self.seen, SEGMENTS);
        if wrong.is_empty() {
            return Ok(());
        }
        link.ask(Action::Abort)?;
        link.stream(Channels::empty(), 0)?;
        bail!(
            "{}; the session was ended, the calibration in force before stays",
            findings::refusal("the board's readings", &wrong)
        )
    }

    fn take(&mut self, sample: &Sample) {
        let first = *self.first.get_or_insert(sample.sequence);
        let row = recorder::row(sample, first, self.rate_hz);
        row.iter().for_each(|row| self.seen.samples.push(row));
    }

    /// Ends the stream and tells in a line each what all samples show. True if nothing that the session uses is wrong.
    ///
    /// # Errors
    /// The board cannot be reached.
    pub fn end(self, link: &mut Link) -> Result<bool> {
        link.stream(Channels::empty(), 0)?;
        let (wrong, others) = findings::sorted(&self.seen, SEGMENTS);
        let all = wrong.iter().chain(&others);
        all.for_each(|finding| warn(&finding.to_string()));
        Ok(wrong.is_empty())
    }
}
