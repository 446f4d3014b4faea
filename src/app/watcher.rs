//! Watches the calibration in force while the courier works: the background's frames, a few of them, into [`crate::calibration::watch`].
//!
//! The window lies in the memory of the calibration sessions, which none needs meanwhile. A calibration that is started takes it, and the
//! next window is begun anew; what has been told, the reference and the tests' sums lie here and stay.

use super::task::Task;
use crate::calibration::Service;
use crate::calibration::UNUSABLE;
use crate::calibration::quotient;
use crate::calibration::recalibration::{Idle, Mode, Recalibration, State};
use crate::calibration::record::Calibration;
use crate::calibration::rest_watch::{
    Glance, RestKept, RestKind, RestVerdict, RestWatch, stated_m,
};
use crate::calibration::watch::{Amounts, Kept, Reading, Standing, Verdict, Watch, WatchConfig};
use crate::frame::Frame;
use crate::geometry::Geometry;

/// After a session's end its memory is left alone for so long, seconds: a host asks how it went.
const LEFT_ALONE_S: u32 = 60;
/// Looks at the frames a second, at most.
const LOOKS_A_SECOND: u32 = 1000;

/// The watch, and which calibration it is for.
#[derive(Clone, Debug)]
pub struct Watcher {
    /// Means something while there is a calibration in force.
    watch: Watch,
    /// Over the courier's rests, by [`RestKind`].
    rests: [RestWatch; 2],
    watching: bool,
    /// [`super::keeper::Keeper::outputs`] that it is for.
    of: u8,
    /// How it stood when it was kept last, [`Watcher::stand`].
    kept: u8,
    rests_kept: [u8; 2],
    /// What becomes of candidates.
    mode: Mode,
    /// Whether none is looked for, beside what the background says, and why. No option, of which nothing would not be zeros.
    is_idle: bool,
    idle_why: Idle,
    /// [`super::keeper::Keeper::changes`] at which the mode was kept.
    mode_kept: u8,
    /// Candidates that came in force, and when the last did.
    adopted: u16,
    adopted_s: u32,
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
    /// Watches nothing, and looks for no candidates until a mode is set: all zeros, so that a static of it is no part of the image.
    pub const fn new() -> Self {
        Self {
            watch: Watch::blank(),
            rests: [const { RestWatch::blank() }; 2],
            watching: false,
            of: 0,
            kept: 0,
            rests_kept: [0; 2],
            mode: Mode::Off,
            is_idle: false,
            idle_why: Idle::Off,
            mode_kept: 0,
            adopted: 0,
            adopted_s: 0,
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

    /// What is known by rests.
    #[must_use]
    pub fn rest_verdict(&self, kind: RestKind) -> RestVerdict {
        self.rests[kind as usize].verdict()
    }

    /// Begins anew where other outputs are in force than before; `outputs` counts them. Whether it watches
    /// other ones now: what was kept of them can be put back by [`Watcher::restore`].
    pub fn follow(&mut self, in_force: Option<&Calibration>, outputs: u8, task: &mut Task) -> bool {
        if self.of == outputs {
            return false;
        }
        (self.kept, self.rests_kept) = (0, [0; 2]);
        self.of = outputs;
        self.is_idle = false;
        self.watching = in_force.is_some();
        if let Some(calibration) = in_force {
            self.watch.start(WatchConfig::of(
                &calibration.quality,
                &calibration.model,
                &calibration.geometry,
            ));
        }
        let beacon = in_force.and_then(|calibration| {
            let beacon = calibration.beacon.as_ref()?;
            Some(stated_m(beacon, &calibration.geometry))
        });
        // Of g_p it states what it left on held-out poses.
        let parity = in_force.map(|_| [self.watch.config().residual_m, 0.0]);
        for ((watch, kind), stated_m) in self
            .rests
            .iter_mut()
            .zip(RestKind::ALL)
            .zip([beacon, parity])
        {
            watch.start(kind, stated_m);
        }
        task.forget_service();
        self.watching
    }

    /// Goes on from what was kept of the outputs in force.
    pub fn restore(&mut self, kept: &Kept) {
        self.watch.restore(kept);
        self.kept = self.stand();
    }

    /// The same for rests.
    pub fn restore_rests(&mut self, kind: RestKind, kept: &RestKept) {
        self.rests[kind as usize].restore(kept);
        self.has_kept_rests(kind);
    }

    /// What is to be kept of rests, as [`Watcher::to_keep`]. To be followed by [`Watcher::has_kept_rests`].
    #[must_use]
    pub fn rests_to_keep(&self, kind: RestKind) -> Option<RestKept> {
        let is_new = self.rests_kept[kind as usize] != stand(self.rest_verdict(kind).standing);
        self.rests[kind as usize].kept().filter(|_| is_new)
    }

    /// It is kept, or cannot be: not again until it changes.
    pub fn has_kept_rests(&mut self, kind: RestKind) {
        self.rests_kept[kind as usize] = stand(self.rest_verdict(kind).standing);
    }

    /// What is to be kept, if that has changed in kind since it was kept last: the reference is known, a window has agreed with it, a change is
    /// told or taken back, the calibration is stale. To be followed by [`Watcher::has_kept`].
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
        stand(self.watch.verdict().standing) | u8::from(self.watch.is_measure()) << 2
    }

    /// Whether a frame is to be looked at, at so many samples, and when is the next. Cheap: it is asked for every frame.
    pub fn is_due(&mut self, samples: u64, rate_hz: f32) -> bool {
        if samples < self.next {
            return false;
        }
        self.next = samples + u64::from((rate_hz as u32 / LOOKS_A_SECOND).max(1));
        true
    }

    /// Takes a frame, at so many samples of this rate; whether the verdict may have changed. While a session runs, and for a while after it,
    /// none. `learns`: whether a candidate could come in force.
    pub fn frame(
        &mut self,
        frame: &Frame,
        (samples, rate_hz): (u64, f32),
        (learns, geometry): (bool, &Geometry),
        task: &mut Task,
    ) -> bool {
        let rate_hz = (rate_hz as u32).max(1);
        if task.is_running() {
            self.free_at = samples + u64::from(LEFT_ALONE_S * rate_hz);
        }
        if !self.watching || samples < self.free_at {
            return false;
        }
        let time_ms = quotient(samples * 1000, rate_hz);
        let now_s = quotient(time_ms, 1000) as u32;
        let mut by_rests = false;
        for (watch, kind) in self.rests.iter_mut().zip(RestKind::ALL) {
            let glance = Glance::of(kind, frame, geometry, UNUSABLE);
            by_rests |= watch.take(glance.as_ref(), now_s, geometry.pitch_m);
        }
        if frame.status.intersects(UNUSABLE) {
            return by_rests;
        }
        let learns = learns && self.mode != Mode::Off && !self.is_idle;
        let (watch, reading) = (&mut self.watch, Reading::of(frame, time_ms));
        let service = task.service();
        service.is_some_and(|service| service.take(watch, &reading, learns)) || by_rests
    }

    /// What becomes of candidates.
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// Sets it; a candidate may be looked for again.
    pub fn set_mode(&mut self, mode: Mode) {
        (self.mode, self.is_idle) = (mode, false);
    }

    /// No candidate is looked for, until another calibration comes in force or a mode is set.
    pub fn rest(&mut self, why: Idle) {
        (self.is_idle, self.idle_why) = (true, why);
    }

    /// Whether the mode is to be kept, as what is stored or in force has changed.
    pub fn is_to_keep_mode(&mut self, changes: u8) -> bool {
        core::mem::replace(&mut self.mode_kept, changes) != changes
    }

    /// Whether a candidate is proposed.
    pub fn proposes(&self, task: &Task) -> bool {
        self.changes_m(task).is_some()
    }

    /// What the candidate that is proposed takes off equation (3)'s corrections, metres.
    pub fn changes_m<'t>(&self, task: &'t Task) -> Option<&'t Amounts> {
        let learner = task.running_service().map(Service::learner)?;
        let is_open = self.watching && !self.is_idle;
        let is_believed = learner.proposal().is_some_and(|of| of.is_believed());
        (is_open && is_believed).then(|| learner.candidate_m())
    }

    /// The candidate is in force, as the outputs of this number. What is to be kept of the watch: nothing where its reference is no measure, and
    /// another is learned.
    pub fn adopted(&mut self, outputs: u8, uptime_s: u32, task: &mut Task) -> Option<Kept> {
        self.of = outputs;
        // Another record, behind which nothing is kept yet.
        self.rests_kept = [0; 2];
        self.adopted = self.adopted.saturating_add(1);
        self.adopted_s = uptime_s;
        let is_measure = self.watch.is_measure();
        let amended_m = task
            .service()
            .map_or(0.0, |service| service.adopt(is_measure));
        let kept = self.watch.kept().filter(|_| is_measure);
        let kept = kept.map(|kept| kept.amended(amended_m));
        self.watch.start(*self.watch.config());
        self.kept = 0;
        if let Some(kept) = &kept {
            self.restore(kept);
        }
        kept
    }

    /// How the recalibration stands, where this stands in its way.
    pub fn recalibration(&self, task: &Task, hindered: Option<Idle>) -> Recalibration {
        let off = (self.mode == Mode::Off).then_some(Idle::Off);
        let proposal = task
            .running_service()
            .and_then(|service| service.learner().proposal());
        let rests = self.is_idle.then_some(self.idle_why);
        let state = match (off.or(hindered).or(rests), proposal) {
            (Some(why), _) => State::Idle(why),
            (None, Some(of)) if of.is_believed() => State::Proposed(of),
            (None, Some(of)) => State::Testing(of),
            (None, None) if self.watch.is_measure() => State::Watching,
            (None, None) if self.watch.has_told() => State::Idle(Idle::ChangedBefore),
            (None, None) => State::Idle(Idle::NoReference),
        };
        Recalibration {
            mode: self.mode,
            state,
            adopted: self.adopted,
            adopted_s: (self.adopted > 0).then_some(self.adopted_s),
        }
    }

    /// Whether frames are to say that the calibration has drifted.
    #[must_use]
    pub fn has_told(&self) -> bool {
        self.watching && (self.watch.has_told() || self.rests.iter().any(RestWatch::has_told))
    }
}

/// What is kept anew when it changes.
fn stand(standing: Standing) -> u8 {
    match standing {
        Standing::Unwatched | Standing::Learning => 0,
        Standing::Healthy | Standing::NotObservable => 1,
        Standing::Drifting => 2,
        Standing::Stale => 3,
    }
}
