//! The platen sensor's calibration session, equations (5) to (8), as a state machine without clock or I/O.
//!
//! Time is counted in samples, by the frames' sequence numbers. The caller hands in every frame
//! ([`Session::frame`]) and every word of the motion controller ([`Session::motion`]), and does what [`Session::poll`]
//! asks for. Each pose: go there, wait until settled, average, check that the courier stood still, gate, add a row. Then
//! as many random poses again that are not fitted: they decide. Nothing here changes the calibration in force.
//!
//! Memory: about 20 KiB, to live in a static. Runs below the interrupt; a frame costs some hundred cycles while
//! averaging, the last one of a pose about 30 rows' worth, twenty thousand cycles each; the final solve some hundred.

mod judge;
mod least_poses;

pub use least_poses::LEAST_POSES;

use super::average::{UNUSABLE, Unsteady};
use super::config::SessionConfig;
use super::gate::GatedFit;
use super::outcome::{Evidence, Outcome, Refusal};
use super::plan::{Plan, Planner, Range, RelativePose};
use super::port::{Action, MotionEvent, Progress, Stage};
use super::record::Poses;
use super::regression::Regression;
use super::sample::Sample;
use super::spread::Spread;
use super::start_error::StartError;
use super::visit::{Visit, VisitRules, Visited};
use crate::frame::{Frame, SEGMENTS};
use crate::math::sqrt;
use crate::model::ErrorModel;
use crate::range::within;

/// Poses between two looks at the predicted deviation. Cost alone: a session ends up to seven poses later than it could.
const LOOK_EVERY: u32 = 8;

/// The session. One at a time; starts idle.
#[derive(Debug)]
pub struct Session {
    config: Option<(SessionConfig, Regression)>,
    fit: GatedFit,
    visit: Visit,
    planner: Planner,
    origin: Sample,
    stage: Stage,
    done: u32,
    /// Poses of the fit, once it has ended.
    visited: u32,
    lost_still: u32,
    raw: Spread,
    held_out_raw: Spread,
    held_out_in_force: Spread,
    held_out: Spread,
    held_out_refused: u32,
    sums: [f32; SEGMENTS],
    temperature_sum_k: f32,
    worst_deviation_m: f32,
    outcome: Option<Outcome>,
}

impl Default for Session {
    fn default() -> Self {
        Self::idle()
    }
}

impl Session {
    /// Nothing under way.
    #[must_use]
    pub const fn idle() -> Self {
        Self {
            config: None,
            fit: const { GatedFit::new() }, // zeros: memory that is cleared in its place
            visit: Visit::none(),
            planner: Planner::new(
                Range {
                    travel_m: 0.0,
                    turn_rad: 0.0,
                },
                0,
            ),
            origin: Sample::ZERO,
            stage: Stage::Finished,
            done: 0,
            visited: 0,
            lost_still: 0,
            raw: Spread::EMPTY,
            held_out_raw: Spread::EMPTY,
            held_out_in_force: Spread::EMPTY,
            held_out: Spread::EMPTY,
            held_out_refused: 0,
            sums: [0.0; SEGMENTS],
            temperature_sum_k: 0.0,
            worst_deviation_m: f32::INFINITY,
            outcome: None,
        }
    }

    /// Starts from where the courier stands.
    ///
    /// # Errors
    /// [`StartError`]; nothing is changed.
    #[inline(never)] // or it is compiled as its caller is, for less smallness
    pub fn start(&mut self, config: &SessionConfig) -> Result<(), StartError> {
        if self.is_running() {
            return Err(StartError::Busy);
        }
        valid(config)?;
        let regression =
            Regression::new(&config.geometry, &config.model).ok_or(StartError::Terms)?;
        let least = least_poses::least_poses(regression.unknowns() as u32);
        enough(config.visits.poses, least)?;
        let parity_noise_m =
            2.0 * config.visits.frame_noise_m / sqrt(config.visits.frames_per_pose as f32);
        // The stated noise is an upper bound; a tenth of it is the least that is believed.
        self.fit.reset(regression.unknowns(), 0.1 * parity_noise_m);
        self.planner = Planner::new(config.visits.range, config.visits.seed);
        self.config = Some((config.clone(), regression));
        self.forget_numbers();
        self.stage = Stage::Origin;
        self.visit.go(RelativePose::default(), 0);
        Ok(())
    }

    fn forget_numbers(&mut self) {
        (self.done, self.lost_still, self.held_out_refused) = (0, 0, 0);
        self.raw = Spread::EMPTY;
        self.held_out_raw = Spread::EMPTY;
        self.held_out_in_force = Spread::EMPTY;
        self.held_out = Spread::EMPTY;
        self.sums = [0.0; SEGMENTS];
        self.temperature_sum_k = 0.0;
        self.worst_deviation_m = f32::INFINITY;
        self.outcome = None;
    }

    /// Nothing under way, whatever there was: in place, and of use also where the memory was just cleared.
    pub fn make_idle(&mut self) {
        self.config = None;
        self.outcome = None;
        self.stage = Stage::Finished;
        self.visit.forget();
    }

    /// Whether a session is under way.
    #[must_use]
    pub fn is_running(&self) -> bool {
        self.stage != Stage::Finished
    }

    /// What is to be done now, once.
    #[inline(never)] // or it is compiled as its caller is, for less smallness
    pub fn poll(&mut self) -> Option<Action> {
        self.visit.poll()
    }

    /// How it ended, once it has.
    #[must_use]
    pub fn outcome(&self) -> Option<&Outcome> {
        self.outcome.as_ref()
    }

    /// The fit so far, or of the last session.
    #[must_use]
    pub fn fit(&self) -> &GatedFit {
        &self.fit
    }

    /// Which poses it visited, once it has ended with a calibration.
    #[must_use]
    pub fn poses(&self) -> Option<Poses> {
        let (config, _) = self.config.as_ref()?;
        let visits = &config.visits;
        let count = |n: u32| u16::try_from(n).ok();
        let counts = [count(self.visited)?, count(self.held_out.count() as u32)?];
        Some(Poses::new(
            visits.plan,
            visits.seed,
            visits.range,
            &self.origin,
            counts,
        ))
    }

    /// How far it is.
    #[must_use]
    pub fn progress(&self) -> Progress {
        let of = self
            .config
            .as_ref()
            .map_or(0, |(config, _)| match self.stage {
                Stage::Origin => 1,
                Stage::Fit => config.visits.poses,
                Stage::HeldOut => config.visits.held_out_poses,
                Stage::Solving | Stage::Finished => 0,
            });
        let lost = self.lost();
        Progress {
            stage: self.stage,
            done: self.done,
            of,
            lost,
            worst_deviation_m: self.worst_deviation_m,
        }
    }

    /// Ends it by the user's wish.
    pub fn abort(&mut self) {
        if self.is_running() {
            self.refuse(Refusal::Aborted);
        }
    }

    /// Takes what the motion controller said.
    #[inline(never)] // or it is compiled as its caller is, for less smallness
    pub fn motion(&mut self, event: MotionEvent) {
        if let (true, Some(rules)) = (self.is_running(), self.rules())
            && let Some(refusal) = self.visit.motion(event, &rules)
        {
            self.refuse(refusal);
        }
    }

    /// Whether every frame is of use: the courier rests at a pose, or its frames are averaged.
    #[must_use]
    pub fn wants_all_frames(&self) -> bool {
        self.is_running() && self.visit.wants_all_frames()
    }

    /// Takes a frame. While [`Session::wants_all_frames`] says so every one; otherwise they are the clock, and some may be left out.
    #[inline(never)] // or it is compiled as its caller is, for less smallness
    pub fn frame(&mut self, frame: &Frame) {
        let (true, Some(rules)) = (self.is_running(), self.rules()) else {
            return;
        };
        match self.visit.frame(frame, &rules) {
            Visited::Nothing => {}
            Visited::Mean(mean) => self.use_pose(&mean),
            Visited::Unsteady(unsteady) => self.lose(unsteady),
            Visited::BadFrames(refusal) | Visited::NotSettled(refusal) => self.refuse(refusal),
        }
    }

    fn rules(&self) -> Option<VisitRules> {
        let (config, _) = self.config.as_ref()?;
        Some(config.visits.rules(config.geometry.pitch_m, UNUSABLE))
    }

    fn lose(&mut self, Unsteady { spread_m, limit_m }: Unsteady) {
        self.lost_still += 1;
        if self.lost_still > self.loss_limit() || self.stage == Stage::Origin {
            let lost = self.lost_still;
            self.refuse(Refusal::NotStill {
                spread_m,
                limit_m,
                lost,
            });
        } else {
            self.next_pose();
        }
    }

    /// Counts the pose and goes on.
    fn next_pose(&mut self) {
        self.done += 1;
        self.go_on();
    }

    fn go_on(&mut self) {
        if self.stage == Stage::Fit && (self.done >= self.planned() || self.target_met()) {
            self.end_fit();
        }
        match self.stage {
            Stage::Fit => {
                let pose = self.choose();
                self.visit.go(pose, self.done);
            }
            Stage::HeldOut if self.done >= self.planned() => self.decide(),
            Stage::HeldOut => {
                let pose = self.planner.random();
                self.visit.go(pose, self.done);
            }
            Stage::Origin | Stage::Solving | Stage::Finished => {}
        }
    }

    fn planned(&self) -> u32 {
        self.progress().of
    }

    fn choose(&mut self) -> RelativePose {
        match &self.config {
            Some((config, regression)) if config.visits.plan == Plan::Optimal => self
                .planner
                .optimal(self.fit.estimator(), regression, &self.origin),
            _ => self.planner.random(),
        }
    }

    fn target_met(&mut self) -> bool {
        let Some((config, regression)) = &self.config else {
            return false;
        };
        if self.done > 0 && self.done.is_multiple_of(LOOK_EVERY) {
            self.worst_deviation_m = self.fit.worst_deviation_m(regression);
        }
        self.worst_deviation_m < config.target_deviation_m
    }

    #[inline(never)] // called from a dozen places
    fn refuse(&mut self, refusal: Refusal) {
        let evidence = self.evidence();
        self.finish(Err(refusal), evidence);
    }

    #[inline(never)]
    fn finish(&mut self, result: Result<ErrorModel, Refusal>, evidence: Evidence) {
        self.outcome = Some(Outcome { result, evidence });
        self.stage = Stage::Finished;
        self.visit.stop();
    }
}

// Each for itself, with the error that its caller passes on as it is: an error that is made in the caller's frame costs another copy of
// the configuration there, 0.9 KiB of the stack.
#[inline(never)]
fn valid(config: &SessionConfig) -> Result<(), StartError> {
    Ok(config.validate()?)
}

#[inline(never)]
fn enough(poses: u32, least: u32) -> Result<(), StartError> {
    Ok(within("poses", poses as f32, least as f32, 1.0e6)?)
}
