//! Watches the calibration in force while the courier works: the background's frames, a few of them, into [`crate::calibration::watch`].
//!
//! The window lies in the memory of the calibration sessions, which none needs meanwhile. A calibration that is started takes it, and the
//! next window is begun anew; what has been told, the reference and the tests' sums lie here and stay.

use super::task::Task;
use crate::calibration::UNUSABLE;
use crate::calibration::record::Calibration;
use crate::calibration::watch::{Kept, Reading, Standing, Verdict, Watch, WatchConfig};
use crate::frame::Frame;

/// After a session's end its memory is left alone for so long, seconds: a host asks how it went.
const LEFT_ALONE_S: u64 = 60;
/// Looks at the frames a second, at most.
const LOOKS_A_SECOND: u64 = 1000;

/// The watch, and which calibration it is for.
#[derive(Clone, Debug)]
pub struct Watcher {
    /// Means something while there is a calibration in force.
    watch: Watch,
    watching: bool,
    /// [`super::keeper::Keeper::outputs`] that it is for.
    of: u8,
    /// How it stood when it was kept last, [`Watcher::stand`].
    kept: u8,
    /// Samples at which the next look is due.
    next: u64,
    /// Samples until which the sessions' memory is left alone.
    free_at: u64,
}

impl Default for Watcher {
    fn default() -> Self {
        Self::new()
    }
}

impl Watcher {
    /// Watches nothing.
    pub const fn new() -> Self {
        Self {
            watch: Watch::blank(),
            watching: false,
            of: 0,
            kept: 0,
            next: 0,
            free_at: 0,
        }
    }

    /// What is known.
    #[must_use]
    pub fn verdict(&self) -> Verdict {
        if self.watching {
            self.watch.verdict()
        } else {
            Verdict::default()
        }
    }

    /// Begins anew where other outputs are in force than before; `outputs` counts them. Whether it watches
    /// other ones now: what was kept of them can be put back by [`Watcher::restore`].
    pub fn follow(&mut self, in_force: Option<&Calibration>, outputs: u8, task: &mut Task) -> bool {
        if self.of == outputs {
            return false;
        }
        self.kept = 0;
        self.of = outputs;
        self.watching = in_force.is_some();
        if let Some(calibration) = in_force {
            self.watch.start(WatchConfig::of(&calibration.quality));
        }
        task.forget_watch();
        self.watching
    }

    /// Goes on from what was kept of the outputs in force.
    pub fn restore(&mut self, kept: &Kept) {
        self.watch.restore(kept);
        self.kept = self.stand();
    }

    /// What is to be kept, if that has changed in kind since it was kept last: the reference is known, a change is told or taken back, the
    /// calibration is stale. To be followed by [`Watcher::has_kept`].
    #[must_use]
    pub fn to_keep(&self) -> Option<Kept> {
        let is_new = self.watching && self.kept != self.stand();
        self.watch.kept().filter(|_| is_new)
    }

    /// It is kept, or cannot be: not again until it changes.
    pub fn has_kept(&mut self) {
        self.kept = self.stand();
    }

    fn stand(&self) -> u8 {
        match self.watch.verdict().standing {
            Standing::Unwatched | Standing::Learning => 0,
            Standing::Healthy | Standing::NotObservable => 1,
            Standing::Drifting => 2,
            Standing::Stale => 3,
        }
    }

    /// Whether a frame is to be looked at, at so many samples, and when is the next. Cheap: it is asked for every frame.
    pub fn is_due(&mut self, samples: u64, rate_hz: f32) -> bool {
        if samples < self.next {
            return false;
        }
        self.next = samples + (rate_hz as u64 / LOOKS_A_SECOND).max(1);
        true
    }

    /// Takes a frame; whether the verdict may have changed. While a session runs, and for a while after it, none.
    pub fn frame(&mut self, frame: &Frame, samples: u64, rate_hz: f32, task: &mut Task) -> bool {
        let rate_hz = (rate_hz as u64).max(1);
        if task.is_running() {
            self.free_at = samples + LEFT_ALONE_S * rate_hz;
        }
        if !self.watching || samples < self.free_at || frame.status.intersects(UNUSABLE) {
            return false;
        }
        let time_ms = samples * 1000 / rate_hz;
        let window = task.window();
        window.is_some_and(|window| self.watch.take(window, &Reading::of(frame, time_ms)))
    }

    /// Whether frames are to say that the calibration has drifted.
    #[must_use]
    pub fn has_told(&self) -> bool {
        self.watching && self.watch.has_told()
    }
}
