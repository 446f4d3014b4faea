//! The joint calibration's session under a beacon: poses, buffer, then the schedule's steps. A state machine like
//! [`crate::Session`], with one more duty for its caller: [`JointSession::work`], again and again, which makes the
//! schedule's steps, slice by slice, when the poses are complete.
//!
//! It starts where the courier stands with the coordination sensor under the beacon, and turns about that sensor as far as
//! the entered lever arm is right. Memory: 41 KiB of poses, 20 KiB of estimator, to live in a static.

mod verdict;

use crate::average::{PoseMean, UNUSABLE};
use crate::frame::{Frame, SEGMENTS, Status};
use crate::joint::config::JointConfig;
use crate::joint::constraint::Constraints;
use crate::joint::layout::{Groups, JOINT_UNKNOWNS};
use crate::joint::outcome::JointOutcome;
use crate::joint::plan::about_sensor;
use crate::joint::sample::{JointBuffer, JointSample};
use crate::joint::solver::JointSolver;
use crate::joint::steps::{JointProgress, StepReport, Trial};
use crate::outcome::Refusal;
use crate::plan::{Plan, Planner, Range, RelativePose};
use crate::port::{Action, MotionEvent, Progress, Stage};
use crate::sample::Sample;
use crate::spread::Spread;
use crate::start_error::StartError;
use crate::visit::{Visit, VisitRules, Visited};

/// What makes a frame under the beacon useless beside [`UNUSABLE`].
const BEACON: Status = Status::BEACON_MISSING.union(Status::BEACON_SATURATED);

/// The session. One at a time; starts idle.
#[derive(Debug)]
pub struct JointSession {
    config: Option<JointConfig>,
    /// Of the same session.
    constraints: Option<Constraints>,
    visit: Visit,
    planner: Planner,
    buffer: JointBuffer,
    solver: JointSolver,
    progress: JointProgress,
    origin: Sample,
    light_counts: f32,
    stage: Stage,
    done: u32,
    lost: u32,
    trial: Trial,
    /// Whether a step is being made.
    is_trying: bool,
    reports: heapless::Vec<StepReport, 5>,
    turn: Spread,
    raw: Spread,
    in_force: Spread,
    sums: [f32; SEGMENTS],
    temperature_sum_k: f32,
    outcome: Option<JointOutcome>,
}

impl Default for JointSession {
    fn default() -> Self {
        Self::idle()
    }
}

impl JointSession {
    /// Nothing under way.
    #[must_use]
    pub const fn idle() -> Self {
        Self {
            config: None,
            constraints: None,
            visit: Visit::none(),
            planner: Planner::new(
                Range {
                    travel_m: 0.0,
                    turn_rad: 0.0,
                },
                0,
            ),
            // Constants of zeros: memory that is cleared in its place.
            buffer: const { JointBuffer::new() },
            solver: const { JointSolver::new() },
            progress: JointProgress {
                values: [0.0; JOINT_UNKNOWNS],
                accepted: Groups::empty(),
            },
            origin: Sample::ZERO,
            light_counts: 0.0,
            stage: Stage::Finished,
            done: 0,
            lost: 0,
            trial: Trial::idle(),
            is_trying: false,
            reports: heapless::Vec::new(),
            turn: Spread::EMPTY,
            raw: Spread::EMPTY,
            in_force: Spread::EMPTY,
            sums: [0.0; SEGMENTS],
            temperature_sum_k: 0.0,
            outcome: None,
        }
    }

    /// Starts from where the courier stands, under the beacon.
    ///
    /// # Errors
    /// [`StartError`]; nothing is changed.
    #[inline(never)] // or it is compiled as its caller is, for less smallness
    pub fn start(&mut self, config: &mut JointConfig) -> Result<(), StartError> {
        if self.is_running() {
            return Err(StartError::Busy);
        }
        config.validate()?;
        let (constraints, values) = config.prepare()?;
        self.solver
            .set_priors(&constraints, &values, &config.priors);
        self.solver.begin_plan(&constraints, &values, Groups::PAPER);
        self.planner = Planner::new(config.visits.range, config.visits.seed);
        self.progress = JointProgress {
            values,
            accepted: Groups::empty(),
        };
        self.keep(config);
        self.constraints = Some(constraints);
        self.buffer.clear();
        self.reports.clear();
        (self.done, self.lost, self.is_trying) = (0, 0, false);
        (self.turn, self.raw, self.in_force) = (Spread::EMPTY, Spread::EMPTY, Spread::EMPTY);
        (self.sums, self.temperature_sum_k) = ([0.0; SEGMENTS], 0.0);
        self.outcome = None;
        self.stage = Stage::Origin;
        self.visit.go(RelativePose::default(), 0);
        Ok(())
    }

    #[inline(never)] // a copy is a kilobyte of stack
    fn keep(&mut self, config: &JointConfig) {
        self.config = Some(config.clone());
    }

    /// Nothing under way, whatever there was: in place, and of use also where the memory was just cleared.
    pub fn make_idle(&mut self) {
        (self.config, self.constraints) = (None, None);
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
    pub fn outcome(&self) -> Option<&JointOutcome> {
        self.outcome.as_ref()
    }

    /// Steps made so far.
    #[must_use]
    pub fn reports(&self) -> &[StepReport] {
        &self.reports
    }

    /// How far it is.
    #[must_use]
    pub fn progress(&self) -> Progress {
        let of = self.config.as_ref().map_or(0, |config| match self.stage {
            Stage::Origin => 1,
            Stage::Fit => config.visits.poses,
            Stage::HeldOut => config.visits.held_out_poses,
            Stage::Solving => config.steps().len() as u32,
            Stage::Finished => 0,
        });
        Progress {
            stage: self.stage,
            done: self.done,
            of,
            lost: self.lost,
            worst_deviation_m: f32::INFINITY,
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
        self.is_visiting() && self.visit.wants_all_frames()
    }

    /// Takes a frame. While [`JointSession::wants_all_frames`] says so every one; otherwise they are the clock, and some may be left out.
    #[inline(never)] // or it is compiled as its caller is, for less smallness
    pub fn frame(&mut self, frame: &Frame) {
        let (true, Some(rules)) = (self.is_visiting(), self.rules()) else {
            return;
        };
        match self.visit.frame(frame, &rules) {
            Visited::Nothing => {}
            Visited::Mean(mean) => self.use_pose(&mean),
            Visited::Unsteady(unsteady) => {
                let (spread_m, limit_m) = (unsteady.spread_m, unsteady.limit_m);
                self.lose(Refusal::NotStill {
                    spread_m,
                    limit_m,
                    lost: self.lost + 1,
                });
            }
            Visited::BadFrames(refusal) => match refusal {
                // A beacon that comes and goes costs poses; anything else is the board's or the platen sensor's fault.
                Refusal::BadFrames { status, .. } if BEACON.contains(status) => self.lose(refusal),
                _ => self.refuse(refusal),
            },
            Visited::NotSettled(refusal) => self.refuse(refusal),
        }
    }

    /// Goes on with the schedule's steps if the poses are complete; true if there was something to do. A step takes 0.5 to
    /// 6 s at 170 MHz; a call at most 110,000 cycles, and at the end of a pass over the poses what the solution costs.
    #[inline(never)] // or it is compiled as its caller is, for less smallness
    pub fn work(&mut self) -> bool {
        if self.stage != Stage::Solving {
            return false;
        }
        let (Some(config), Some(constraints)) = (&self.config, &mut self.constraints) else {
            return false;
        };
        let (trial, solver, progress) = (&mut self.trial, &mut self.solver, &mut self.progress);
        if !self.is_trying {
            match config.steps().get(self.reports.len()) {
                Some(&step) => trial.begin(step, constraints, solver, progress),
                None => self.decide(),
            }
            self.is_trying = true;
            return true;
        }
        match trial.slice(constraints, solver, &self.buffer, progress) {
            Ok(None) => {}
            Ok(Some(report)) => {
                (self.is_trying, self.done) = (false, self.done + 1);
                let _ = self.reports.push(report); // as many places as steps
                self.check_after();
            }
            Err(error) => self.refuse(error.into()),
        }
        true
    }

    /// Whether poses are still to be visited.
    fn is_visiting(&self) -> bool {
        !matches!(self.stage, Stage::Solving | Stage::Finished)
    }

    fn rules(&self) -> Option<VisitRules> {
        let config = self.config.as_ref()?;
        Some(
            config
                .visits
                .rules(config.geometry.pitch_m, UNUSABLE.union(BEACON)),
        )
    }

    fn use_pose(&mut self, mean: &PoseMean) {
        if self.stage == Stage::Origin {
            self.origin = mean.sample;
            self.light_counts = mean.light_counts;
            self.stage = Stage::Fit;
            return self.go_on();
        }
        let (Some(config), Some(constraints)) = (&self.config, &self.constraints) else {
            return;
        };
        let limit_share = config.limits.light_share;
        let (light_counts, reference_counts) = (mean.light_counts, self.light_counts);
        if (light_counts - reference_counts).abs() > limit_share * reference_counts.abs() {
            let lost = self.lost + 1;
            return self.lose(Refusal::Light {
                light_counts,
                reference_counts,
                limit_share,
                lost,
            });
        }
        let geometry = &config.geometry;
        let [x, y] = self.origin_teeth();
        let deflection = mean.tan_psi.map(|t| t / geometry.tan_full_scale);
        if let Some(sample) = JointSample::new(&[x, y, x, y], &mean.sample, deflection) {
            if config.visits.plan == Plan::Optimal && self.stage == Stage::Fit {
                let entered = &self.progress.values;
                self.solver.add_to_plan(constraints, entered, &sample);
            }
            self.buffer.push(sample);
        }
        let pitch_m = geometry.pitch_m;
        let [p1, p2, p3, p4] = mean.sample.unmodified;
        self.turn
            .add((p1.minus_turns(p3) + p2.minus_turns(p4)) * pitch_m / (2.0 * geometry.span_m));
        if self.stage == Stage::HeldOut {
            self.raw.add(mean.sample.parity_m(pitch_m));
            self.in_force.add(mean.parity_in_force_m);
        }
        for (sum, amplitude) in self.sums.iter_mut().zip(mean.amplitude_counts) {
            *sum += amplitude;
        }
        self.temperature_sum_k += mean.sample.temperature_delta_k;
        self.next_pose();
    }

    /// Whole teeth that positions are counted from: one number a pair, so that its difference stays.
    fn origin_teeth(&self) -> [i32; 2] {
        [
            self.origin.unmodified[0].teeth,
            self.origin.unmodified[1].teeth,
        ]
    }

    fn lose(&mut self, why: Refusal) {
        self.lost += 1;
        let limit = self.config.as_ref().map_or(0.0, |config| {
            config.limits.lost_share * config.visits.total() as f32
        });
        if self.lost as f32 > limit || self.stage == Stage::Origin {
            self.refuse(why);
        } else {
            self.next_pose();
        }
    }

    fn next_pose(&mut self) {
        self.done += 1;
        self.go_on();
    }

    fn go_on(&mut self) {
        let of = self.progress().of;
        if self.stage == Stage::Fit && self.done >= of {
            self.buffer.hold_out_rest();
            (self.stage, self.done) = (Stage::HeldOut, 0);
        } else if self.stage == Stage::HeldOut && self.done >= of {
            (self.stage, self.done) = (Stage::Solving, 0);
            return self.check_motion();
        }
        let (Some(config), Some(constraints)) = (&self.config, &self.constraints) else {
            return;
        };
        let pose = if self.stage == Stage::Fit && config.visits.plan == Plan::Optimal {
            let (entered, start) = (&self.progress.values, &self.origin);
            self.solver
                .choose(constraints, entered, start, &mut self.planner)
        } else {
            about_sensor(config.geometry.lever_m, self.planner.centred(false))
        };
        self.visit.go(pose, self.done);
    }
}
