//! The background's half: everything below the interrupt. [`Background::poll`] is called again and again by the board's main loop.
//!
//! Frames come from the intake, all that the session wants, otherwise the newest; the session's wishes go to the motion controller; an accepted calibration goes to flash first and then in force; a stored tooth map comes in force under its beacon. What fails leaves the calibration in
//! force where it was. Knows no clock: time is the number of samples taken.

mod begin;
mod clock;
mod conclude;
mod events;
mod place_map;
mod recalibrate;
mod update;
mod watch;

use super::events::Events;
use super::frames::FrameReceiver;
use super::guide::Guide;
use super::homing::Homing;
use super::keeper::Keeper;
use super::sampler::Mailbox;
use super::task::Task;
use super::updates::Updates;
use super::watcher::Watcher;
use crate::calibration::joint::StepReport;
use crate::calibration::record::Method;
use crate::calibration::slots::{Place, Slots};
use crate::calibration::{Action, Evidence, Progress, Refusal as SessionRefusal};
use crate::device::Device;
use crate::drivers::motion::{MotionPort, PortCounters, Target};
use crate::frame::Frame;
use crate::link::message::Refusal;
use crate::maps::crossing::Crossing;
use crate::settings::Settings;
use crate::swap::SwapSender;
use embedded_io::{Read, ReadReady, Write, WriteReady};
use embedded_storage::nor_flash::NorFlash;

/// Speed of self-motions unless ordered otherwise, m/s.
pub const SELF_MOTION_M_PER_S: f32 = 0.2;
/// Frames taken from the queue at one poll: bounds the time between two looks at the motion port and the link.
const FRAMES_A_POLL: usize = 32;

/// How a session is run, beside what it fits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Errand {
    /// Highest speed between poses, m/s.
    pub speed_m_per_s: f32,
    /// Store the result when it is accepted.
    pub commit: bool,
}

/// How the last session ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ended {
    /// What is known about the fit.
    pub evidence: Evidence,
    /// The session's own verdict: refused, or accepted and where it is stored (none if that was not ordered).
    pub result: Result<Option<Place>, SessionRefusal>,
    /// Accepted, but could not be put in force or stored: the one before is in force.
    pub not_kept: Option<Refusal>,
}

/// Where the background lives: the ends that connect it to the interrupt, and its parts.
pub struct Background<'q, 'c, S, F> {
    frames: FrameReceiver<'q, 'c>,
    mailbox: &'q Mailbox,
    guide: Guide<S>,
    keeper: Keeper<'q, 'c, F>,
    updates: Option<&'q mut dyn Updates<F>>,
    task: &'q mut Task,
    homing: Homing,
    crossing: Crossing,
    /// Level of the reference mark's input.
    at_mark: bool,
    /// Of the keeper, when the stored maps were last looked at.
    changes_seen: Option<u8>,
    watcher: &'q mut Watcher,
    events: Events,
    method: Method,
    errand: Errand,
    ended: Option<Ended>,
    unix_offset_s: Option<u64>,
    temperature_c: Option<f32>,
    samples: u64,
    last: Frame,
}

impl<'q, 'c, S, F> Background<'q, 'c, S, F>
where
    S: Read + ReadReady + Write + WriteReady,
    F: NorFlash,
{
    /// Nothing in force but the board's own settings. `task` and `watcher` are where sessions and the watch live. To be followed by
    /// [`Background::start`].
    pub fn new(
        ends: (FrameReceiver<'q, 'c>, SwapSender<'q, 'c>, &'q Mailbox),
        motion: MotionPort<S>,
        slots: Slots<F>,
        settings: Settings,
        device: Device,
        (task, watcher): (&'q mut Task, &'q mut Watcher),
    ) -> Self {
        let (frames, swap, mailbox) = ends;
        Self {
            frames,
            mailbox,
            guide: Guide::new(motion),
            keeper: Keeper::new(slots, swap, settings, device),
            updates: None,
            task,
            homing: Homing::default(),
            crossing: Crossing::default(),
            at_mark: false,
            changes_seen: None,
            watcher,
            events: Events::default(),
            method: Method::Platen,
            errand: Errand {
                speed_m_per_s: SELF_MOTION_M_PER_S,
                commit: true,
            },
            ended: None,
            unix_offset_s: None,
            temperature_c: None,
            samples: 0,
            last: Frame::default(),
        }
    }

    /// For a board with two banks of flash and a first stage: takes new firmware from now on. `make` gets the bank that no code runs from.
    /// To be called before [`Background::start`].
    pub fn offer_updates(&mut self, make: impl FnOnce(&mut F) -> &'q mut dyn Updates<F>) {
        self.updates = Some(make(self.keeper.flash_mut()));
    }

    /// Starts from what is stored: the newest valid record comes in force; without one frames say
    /// [`UNCALIBRATED`](crate::frame::Status::UNCALIBRATED) and [`Keeper::boot`] why. In safe mode what is stored is left alone ([`super::restarts`]).
    ///
    /// The motion controller is told to stop: what was under way before a restart is nobody's any more.
    pub fn start(&mut self, safe_mode: bool) {
        self.keeper.start(safe_mode);
        self.watcher.set_mode(self.keeper.mode());
        self.guide.halt();
    }

    /// One turn of the main loop. Returns how many frames it took.
    pub fn poll(&mut self) -> usize {
        let taken = self.take_frames();
        self.follow_maps(taken > 0);
        self.move_on();
        self.say_what_is_wanted();
        taken
    }

    /// Tells whether the input of the reference mark is on. To be called before each turn, on a board that has one.
    pub fn set_at_mark(&mut self, is_on: bool) {
        self.at_mark = is_on;
    }

    #[inline(never)] // frames on the stack only while it runs
    fn take_frames(&mut self) -> usize {
        let mut taken = 0;
        while taken < FRAMES_A_POLL && self.take() {
            taken += 1;
            self.events.see(self.last.status);
            // The last frame of a pose may keep the session busy for milliseconds: what comes meanwhile is of no use to it.
            self.mailbox.set_wants_all(false);
            self.task.frame(&self.last);
            self.watch();
            self.say_what_is_wanted();
        }
        taken
    }

    fn say_what_is_wanted(&self) {
        self.mailbox.set_wants_all(self.task.wants_all_frames());
    }

    /// Takes a frame, copied once: a frame is a quarter of a kilobyte.
    fn take(&mut self) -> bool {
        let before = self.last.sequence;
        if !self.frames.receive(&mut self.last) {
            return false;
        }
        self.samples += u64::from(self.last.sequence.wrapping_sub(before));
        true
    }

    /// Carries words between the sessions and the motion controller, and concludes a session that has ended.
    fn move_on(&mut self) {
        if let Some(event) = self.guide.poll(self.last.sequence) {
            self.task.motion(event);
        }
        match self.task.poll() {
            Some(Action::Go(pose)) => self.guide.go_relative(pose, self.errand.speed_m_per_s),
            Some(Action::Stop) => self.guide.halt(),
            None => {}
        }
        if self.ended.is_none() && self.task.has_ended() {
            self.conclude_task();
        }
    }

    /// A slice of what takes seconds on the target: to be called between two turns; false if there is nothing to do. It is
    /// over after half a millisecond, now and then after a fifth of a second.
    pub fn work(&mut self) -> bool {
        let checked = match &mut self.updates {
            Some(updates) => updates.work(self.keeper.flash_mut()),
            None => false,
        };
        self.task.work() || checked
    }

    /// Moves the courier, when no session does.
    ///
    /// # Errors
    /// [`Refusal::Busy`].
    pub fn go_to(&mut self, goal: Target, speed_m_per_s: f32) -> Result<(), Refusal> {
        self.idle()?;
        self.guide.go_to(goal, speed_m_per_s);
        Ok(())
    }

    /// Slots and what is in force; to change them only while no session runs.
    ///
    /// # Errors
    /// [`Refusal::Busy`].
    pub fn keeper_mut(&mut self) -> Result<&mut Keeper<'q, 'c, F>, Refusal> {
        self.idle()?;
        Ok(&mut self.keeper)
    }

    /// Whether the interrupt works with what was put in force last, as it does from its next sample on.
    pub fn is_settled(&mut self) -> bool {
        self.keeper.is_taken()
    }

    /// Slots and what is in force.
    pub fn keeper(&self) -> &Keeper<'q, 'c, F> {
        &self.keeper
    }

    /// Whether a calibration is under way.
    pub fn is_calibrating(&self) -> bool {
        self.task.is_running()
    }

    /// What the calibration under way, or the last one, rests on.
    pub fn method(&self) -> Method {
        self.method
    }

    /// How far it is.
    pub fn progress(&self) -> Progress {
        self.task.progress()
    }

    /// Steps that a joint calibration under way, or the last one, has made so far.
    pub fn reports(&self) -> &[StepReport] {
        self.task.reports()
    }

    /// How the last session ended, once it has.
    pub fn ended(&self) -> Option<&Ended> {
        self.ended.as_ref()
    }

    /// The last frame that came.
    pub fn last_frame(&self) -> &Frame {
        &self.last
    }

    /// Whether the courier is being moved.
    pub fn is_moving(&self) -> bool {
        self.guide.is_busy()
    }

    /// What the motion controller's line has brought.
    pub fn motion_counters(&self) -> PortCounters {
        self.guide.counters()
    }

    /// What the interrupt counts.
    pub fn mailbox(&self) -> &'q Mailbox {
        self.mailbox
    }

    fn idle(&self) -> Result<(), Refusal> {
        if self.is_calibrating() {
            Err(Refusal::Busy)
        } else {
            Ok(())
        }
    }
}
