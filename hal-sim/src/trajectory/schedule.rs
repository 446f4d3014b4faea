//! A schedule of moves: the true motion of the open-loop courier, and what it was commanded.

use super::OpenLoop;
use super::Profile;
use super::open_loop::PlaceError;
use core::f64::consts::TAU;
use effects::motion::{Motion, Pose};
use effects::random::{ChaCha8Rng, SeedableRng};

/// Shape of a move in the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Path {
    /// All three coordinates in step.
    Straight,
    /// About a point of the body (metres from the platen sensor's centre, body frame) that stays in place.
    Pivot {
        /// The point.
        body_m: [f64; 2],
    },
}

#[derive(Clone, Copy, Debug)]
struct Leg {
    start_s: f64,
    profile: Profile,
    path: Path,
    from: Pose,
    to: Pose,
    error_from: Pose,
    error_to: Pose,
    ringing: Pose,
}

/// Moves in time order. Before the first the courier stands at its home, after the last where that ended.
///
/// Appending while time runs makes it the live courier behind a motion controller; appending all at once, a plan.
#[derive(Clone, Debug)]
pub struct Schedule {
    open_loop: OpenLoop,
    place_error: PlaceError,
    pitch_m: f64,
    home: Pose,
    legs: Vec<Leg>,
    rng: ChaCha8Rng,
}

/// Ramp of every move, seconds: the motors' acceleration of some m/s^2 at the usual speeds.
const RAMP_S: f64 = 0.06;

/// Arm at which an angle counts as a distance when a speed is given, metres.
const ARM_M: f64 = 0.1;

impl Schedule {
    /// A courier that stands at `home`, which it hits exactly: it is where the platen's origin is.
    #[must_use]
    pub fn new(home: Pose, open_loop: OpenLoop, pitch_m: f64, seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let place_error = PlaceError::draw(&mut rng);
        Self {
            open_loop,
            place_error,
            pitch_m,
            home,
            legs: Vec::new(),
            rng,
        }
    }

    /// Moves to a pose, starting at `start_s`, at most at `speed_m_s`. A move that is under way is cut short: the new one
    /// starts from where the courier is, at rest. Returns the end of the move, before settling.
    pub fn go_to(&mut self, start_s: f64, target: Pose, speed_m_s: f64, path: Path) -> f64 {
        let from = self.commanded(start_s);
        let error_from = self.error(start_s);
        let way = target.plus(from, -1.0);
        let distance = way.x_m.hypot(way.y_m).max(ARM_M * way.theta_rad.abs());
        let profile = Profile::new(distance, speed_m_s, RAMP_S);
        let stop_error = self.open_loop.stop_error(&mut self.rng);
        let ringing = self.open_loop.ringing(&mut self.rng);
        let error_to = stop_error.plus(self.open_loop.error_at(&self.place_error, target), 1.0);
        self.legs.retain(|leg| leg.start_s < start_s);
        self.legs.push(Leg {
            start_s,
            profile,
            path,
            from,
            to: target,
            error_from,
            error_to,
            ringing,
        });
        start_s + profile.duration_s()
    }

    /// Stops where it is.
    pub fn stop(&mut self, now_s: f64) {
        let here = self.commanded(now_s);
        let error = self.error(now_s);
        let profile = Profile::new(0.0, 1.0, RAMP_S);
        let still = Leg {
            start_s: now_s,
            profile,
            path: Path::Straight,
            from: here,
            to: here,
            error_from: error,
            error_to: error,
            ringing: Pose::default(),
        };
        self.legs.push(still);
    }

    /// Whether the last move has ended and its ringing died away.
    #[must_use]
    pub fn settled(&self, now_s: f64) -> bool {
        now_s >= self.settled_at_s()
    }

    /// When the last move will have settled.
    #[must_use]
    pub fn settled_at_s(&self) -> f64 {
        let end = |leg: &Leg| leg.start_s + leg.profile.duration_s() + self.open_loop.settling_s();
        self.legs.last().map_or(f64::NEG_INFINITY, end)
    }

    /// Forgets moves that ended more than `keep_s` before now: for a courier that runs for long.
    pub fn forget(&mut self, now_s: f64, keep_s: f64) {
        let ended = self
            .legs
            .partition_point(|leg| leg.start_s + leg.profile.duration_s() < now_s - keep_s);
        if ended > 1 {
            self.legs.drain(..ended - 1);
        }
    }

    /// Commanded pose at a time.
    #[must_use]
    pub fn commanded(&self, time_s: f64) -> Pose {
        self.leg(time_s).map_or(self.home, |leg| {
            leg.commanded(leg.profile.at(time_s - leg.start_s))
        })
    }

    fn leg(&self, time_s: f64) -> Option<&Leg> {
        let last = self.legs.last()?;
        if last.start_s <= time_s {
            return Some(last);
        }
        self.legs
            .partition_point(|leg| leg.start_s <= time_s)
            .checked_sub(1)
            .map(|i| &self.legs[i])
    }

    /// Slowly varying part of the miss: from one stop's error to the next's.
    fn error(&self, time_s: f64) -> Pose {
        self.leg(time_s).map_or(Pose::default(), |leg| {
            leg.error(leg.profile.at(time_s - leg.start_s))
        })
    }

    fn ringing(&self, leg: &Leg, time_s: f64) -> Pose {
        let since = time_s - leg.start_s - leg.profile.duration_s();
        if since <= 0.0 || since > 2.0 * self.open_loop.settling_s() {
            return Pose::default();
        }
        let wave = (-since / self.open_loop.decay_s).exp()
            * (TAU * self.open_loop.ringing_hz * since).sin();
        Pose::default().plus(leg.ringing, wave)
    }
}

impl Leg {
    fn commanded(&self, progress: f64) -> Pose {
        let way = self.to.plus(self.from, -1.0);
        let straight = self.from.plus(way, progress);
        let Path::Pivot { body_m: [bx, by] } = self.path else {
            return straight;
        };
        // The point's own place moves straight; the centre follows from the angle.
        let arm = |theta: f64| {
            let (sine, cosine) = theta.sin_cos();
            Pose::new(cosine * bx - sine * by, sine * bx + cosine * by, 0.0)
        };
        let point_from = self.from.plus(arm(self.from.theta_rad), 1.0);
        let point_to = self.to.plus(arm(self.to.theta_rad), 1.0);
        let point = point_from.plus(point_to.plus(point_from, -1.0), progress);
        point.plus(arm(straight.theta_rad), -1.0)
    }

    fn error(&self, progress: f64) -> Pose {
        self.error_from
            .plus(self.error_to.plus(self.error_from, -1.0), progress)
    }
}

impl Motion for Schedule {
    fn pose(&self, time_s: f64) -> Pose {
        let Some(leg) = self.leg(time_s) else {
            return self
                .home
                .plus(self.open_loop.detent(self.home, self.pitch_m), 1.0);
        };
        let progress = leg.profile.at(time_s - leg.start_s);
        let commanded = leg.commanded(progress);
        commanded
            .plus(leg.error(progress), 1.0)
            .plus(self.open_loop.detent(commanded, self.pitch_m), 1.0)
            .plus(self.ringing(leg, time_s), 1.0)
    }
}
