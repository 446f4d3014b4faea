//! How the courier is moved: by its motion controller, or by a hand that is told what to do.

use crate::board::{Link, motion, target};
use crate::recorder::{Recorder, Run};
use crate::terminal::print;
use anyhow::Result;
use courier_sensor::drivers::motion::Target;
use effects::motion::Pose;
use effects::random::{ChaCha8Rng, SeedableRng, normal};
use guided::hand;
use guided::motion::{ARM_M, Area, Move};
use indicatif::ProgressBar;
use recording::Samples;

/// Something that makes motions.
pub trait Mover {
    /// Where the courier stands, in the frame of the area.
    fn start(&mut self, area: &Area) -> Pose;

    /// Makes a motion while it is recorded, and says where the courier stands then.
    ///
    /// # Errors
    /// The board cannot be reached or refuses the motion.
    fn make(
        &mut self,
        link: &mut Link,
        recorder: &mut Recorder,
        bar: &ProgressBar,
        go: Move,
    ) -> Result<Pose>;
}

/// The board's motion controller.
#[derive(Default)]
pub struct Commanded {
    placed: bool,
}

impl Mover for Commanded {
    fn start(&mut self, area: &Area) -> Pose {
        area.centre
    }

    fn make(
        &mut self,
        link: &mut Link,
        recorder: &mut Recorder,
        bar: &ProgressBar,
        go: Move,
    ) -> Result<Pose> {
        let from = (!self.placed).then(|| target(go.from));
        self.placed = true;
        let run = Run {
            name: go.name(),
            from,
            to: (!go.is_still()).then(|| (target(go.to), go.speed_m_s as f32)),
            seconds: go.seconds(),
        };
        recorder.take_run(link, &run, bar, |_| false)?;
        Ok(go.to)
    }
}

/// A hand: it is told each motion, and what it makes of it is read off the segments.
pub struct ByHand {
    hand: Option<SimulatedHand>,
    quiet: bool,
    path: Followed,
}

// Priors without data: what a person does who pushes a courier by hand.
/// A hand has so many times the time that a controller would take, and [`REACTION_S`] to begin.
const PATIENCE: f64 = 4.0;
/// Time in which a hand begins, s.
const REACTION_S: f64 = 5.0;
/// A motion by hand is over when nothing has moved for this long, s.
const RESTED_S: f64 = 0.3;
/// And when it has gone this share of its way.
const MOST_OF_THE_WAY: f64 = 0.5;
/// A courier at rest moves less than this in that time, m: a fiftieth of a tooth, above the residual of a sensor that is not calibrated.
const AT_REST_M: f64 = 20.0e-6;

impl ByHand {
    /// A user's hand; or a simulated one, about a simulated courier. `quiet`: nothing is printed.
    #[must_use]
    pub fn new(hand: Option<SimulatedHand>, quiet: bool) -> Self {
        Self {
            hand,
            quiet,
            path: Followed::default(),
        }
    }
}

impl Mover for ByHand {
    fn start(&mut self, area: &Area) -> Pose {
        area.centre
    }

    fn make(
        &mut self,
        link: &mut Link,
        recorder: &mut Recorder,
        bar: &ProgressBar,
        go: Move,
    ) -> Result<Pose> {
        if !self.quiet {
            bar.suspend(|| print(&format!("now: {}", hand::order(&go))))?;
        }
        let to = match &mut self.hand {
            Some(hand) => Some(hand.push(link, go)?),
            None => None,
        };
        let seconds = if go.is_still() {
            go.seconds()
        } else {
            REACTION_S + PATIENCE * go.seconds()
        };
        let run = Run {
            name: go.name(),
            from: None,
            to,
            seconds,
        };
        let pitch_m = recorder.meta().geometry.pitch_m;
        let span_m = recorder.meta().geometry.span_m.unwrap_or(10.0 * pitch_m);
        let path = &mut self.path;
        path.begin();
        recorder.take_run(link, &run, bar, |samples| {
            path.follow(samples, pitch_m, span_m);
            !go.is_still() && path.is_over(MOST_OF_THE_WAY * go.distance_m())
        })?;
        Ok(Pose {
            x_m: go.from.x_m + path.moved[0],
            y_m: go.from.y_m + path.moved[1],
            theta_rad: go.from.theta_rad + path.moved[2],
        })
    }
}

/// How far the courier has gone in one motion, by the segments' own readings: their patterns are hundredths of a tooth.
#[derive(Default)]
struct Followed {
    seen: usize,
    first: Option<[f64; 3]>,
    moved: [f64; 3],
    /// Since when nothing moves, s, and where.
    rests: Option<(f64, [f64; 3])>,
    now_s: f64,
}

impl Followed {
    fn begin(&mut self) {
        *self = Self {
            seen: self.seen,
            ..Self::default()
        };
    }

    fn follow(&mut self, samples: &Samples, pitch_m: f64, span_m: f64) {
        for i in self.seen..samples.len() {
            let p: Option<Vec<f64>> = (0..4)
                .map(|s| samples.unmodified_m(s, i, pitch_m))
                .collect();
            let Some([a, b, c, d]) = p.as_deref().and_then(|p| p.first_chunk().copied()) else {
                continue;
            };
            let pose = [
                0.5 * (a + c),
                0.5 * (b + d),
                0.5 * ((a - c) + (b - d)) / span_m,
            ];
            let first = *self.first.get_or_insert(pose);
            self.moved = std::array::from_fn(|k| pose[k] - first[k]);
            self.now_s = samples.t_s()[i];
            let stays = |there: &[f64; 3]| {
                (0..3).all(|k| (pose[k] - there[k]).abs() * [1.0, 1.0, span_m][k] < AT_REST_M)
            };
            if !self.rests.as_ref().is_some_and(|(_, there)| stays(there)) {
                self.rests = Some((self.now_s, pose));
            }
        }
        self.seen = samples.len();
    }

    fn is_over(&self, way_m: f64) -> bool {
        let gone = self.moved[0]
            .hypot(self.moved[1])
            .max(ARM_M * self.moved[2].abs());
        let rested = self
            .rests
            .is_some_and(|(since, _)| self.now_s - since > RESTED_S);
        gone > way_m && rested
    }
}

/// A hand about a simulated courier: it does more or less what it is told.
pub struct SimulatedHand {
    rng: ChaCha8Rng,
    at: Pose,
}

/// Scatter of a hand's way and pace, a standard deviation as a share; and of where it ends, m and rad. A prior: what a person does
/// who sees a ruler beside the courier.
const CLUMSY: f64 = 0.15;
/// See [`CLUMSY`].
const CLUMSY_M: f64 = 0.5e-3;
/// See [`CLUMSY`].
const CLUMSY_RAD: f64 = 0.5e-3;

impl SimulatedHand {
    /// Beside a courier that stands there in its controller's frame.
    #[must_use]
    pub fn new(at: Pose, seed: u64) -> Self {
        Self {
            rng: ChaCha8Rng::seed_from_u64(seed),
            at,
        }
    }

    /// Where it will push the courier, and how fast.
    fn push(&mut self, link: &mut Link, go: Move) -> Result<(Target, f32)> {
        motion::rest(link)?;
        let mut clumsy = |by: f64, least: f64| {
            if by == 0.0 {
                0.2 * least * normal(&mut self.rng)
            } else {
                by * (1.0 + CLUMSY * normal(&mut self.rng)) + least * normal(&mut self.rng)
            }
        };
        self.at = Pose {
            x_m: self.at.x_m + clumsy(go.to.x_m - go.from.x_m, CLUMSY_M),
            y_m: self.at.y_m + clumsy(go.to.y_m - go.from.y_m, CLUMSY_M),
            theta_rad: self.at.theta_rad + clumsy(go.to.theta_rad - go.from.theta_rad, CLUMSY_RAD),
        };
        let pace = (2.0 * CLUMSY * normal(&mut self.rng)).exp();
        let speed_m_s = (go.speed_m_s * pace).clamp(0.002, 0.4);
        Ok((target(self.at), speed_m_s as f32))
    }
}
