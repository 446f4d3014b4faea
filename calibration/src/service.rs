//! What runs in the sessions' memory while no calibration does: the watch's window, and the recalibration while working.

use crate::recalibration::{Learner, RecalibrationConfig};
use crate::watch::{Reading, Watch, Window};

/// Both, and the readings that they share.
#[derive(Clone, Debug)]
pub struct Service {
    /// The watch's.
    window: Window,
    /// The recalibration's.
    learner: Learner,
}

impl Default for Service {
    fn default() -> Self {
        Self::new()
    }
}

impl Service {
    /// All zeros.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            window: Window::new(),
            learner: Learner::new(),
        }
    }

    /// Both begin anew.
    pub fn forget(&mut self) {
        self.window.forget();
        self.learner.start(None);
    }

    /// The recalibration.
    #[must_use]
    pub fn learner(&self) -> &Learner {
        &self.learner
    }

    /// Takes a reading; whether a window is complete by it. `learns`: whether a candidate is looked for.
    #[inline(never)]
    pub fn take(&mut self, watch: &mut Watch, reading: &Reading, learns: bool) -> bool {
        if learns != self.learner.has_begun() {
            self.window.forget_cells();
            let (config, amended_m) = (watch.config(), watch.amended_m());
            let config = learns.then(|| RecalibrationConfig::of(config, amended_m));
            self.learner.start(config);
        }
        watch.take(&mut self.window, reading, &mut self.learner)
    }

    /// The candidate has come in force: a window that was begun with the outputs before does not count, and changes are counted from it. By
    /// how much the calibration has been amended in all, metres rms. `is_measure`: whether the watch's reference still counts; where it does not,
    /// another is learned, and all begins anew.
    #[inline(never)]
    pub fn adopt(&mut self, is_measure: bool) -> f32 {
        self.window.forget();
        if is_measure {
            self.learner.adopt()
        } else {
            self.learner.start(None);
            0.0
        }
    }
}
