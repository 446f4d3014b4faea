//! The watch over the calibration in force in the background: its frames, what it says in every frame, and what it keeps.

use super::Background;
use crate::calibration::rest_watch::{RestKind, RestVerdict};
use crate::calibration::watch::Verdict;
use embedded_io::{Read, ReadReady, Write, WriteReady};
use embedded_storage::nor_flash::NorFlash;

impl<S, F> Background<'_, '_, S, F>
where
    S: Read + ReadReady + Write + WriteReady,
    F: NorFlash,
{
    /// Lets the watch over the calibration look at the frame.
    pub(super) fn watch(&mut self) {
        let rate_hz = self.keeper.settings().rate_hz;
        if self.watcher.is_due(self.samples, rate_hz) {
            self.watch_frame(rate_hz);
            self.recalibrate_by_itself();
        }
    }

    #[inline(never)] // a row of the watch on the stack
    fn watch_frame(&mut self, rate_hz: f32) {
        let task = &mut *self.task;
        let (in_force, outputs) = (self.keeper.in_force(), self.keeper.outputs());
        if self.watcher.follow(in_force, outputs, task) {
            if let Some(kept) = self.keeper.kept() {
                self.watcher.restore(&kept);
            }
            for kind in RestKind::ALL {
                if let Some(kept) = self.keeper.kept_of_rests(kind) {
                    self.watcher.restore_rests(kind, &kept);
                }
            }
        }
        let geometry = &self.keeper.settings().geometry;
        let learns = self.hinders().is_none();
        let task = &mut *self.task;
        if self.watcher.frame(
            &self.last,
            (self.samples, rate_hz),
            (learns, geometry),
            task,
        ) {
            self.keep_watch();
        }
        if self.watcher.is_to_keep_mode(self.keeper.changes()) && self.may_store().is_ok() {
            // Where it is not kept, the other slot may tell it, and it holds until the next restart.
            self.keeper.keep_mode(self.watcher.mode());
        }
        let has_told = self.watcher.has_told();
        if has_told != self.keeper.says_drifted() && !self.task.is_running() {
            // Where the interrupt has not taken the last settings yet, it is tried again at the next look.
            let _ = self.keeper.say_drifted(has_told);
        }
    }

    /// Keeps what the watch has found, over a restart: 1 ms of flash. Nothing is stored before a new image was accepted.
    #[inline(never)]
    fn keep_watch(&mut self) {
        if !self.keeper.is_stored() || self.may_store().is_err() {
            return;
        }
        if let Some(kept) = self.watcher.to_keep() {
            // Without room, or where the flash does not take it, the next restart finds what was kept before.
            self.keeper.keep(&kept);
            self.watcher.has_kept();
        }
        for kind in RestKind::ALL {
            if let Some(kept) = self.watcher.rests_to_keep(kind) {
                self.keeper.keep_of_rests(kind, &kept);
                self.watcher.has_kept_rests(kind);
            }
        }
    }

    /// How the calibration in force stands.
    pub fn verdict(&self) -> Verdict {
        self.watcher.verdict()
    }

    /// How it stands by the courier's rests.
    pub fn rest_verdict(&self, kind: RestKind) -> RestVerdict {
        self.watcher.rest_verdict(kind)
    }
}
