//! How the courier really moves: quintic legs between rests, an open-loop error at the end of each, and swinging after it
//! that dies away whatever it is told next.

use effects::motion::{Motion, Pose};

/// Legs kept: a delay asks for poses of the past.
const KEPT: usize = 8;

/// One move. A quintic in time from any pose, velocity and acceleration to rest; then a decaying swing about the end.
#[derive(Clone, Copy, Debug)]
pub struct Leg {
    /// Instant at which it begins, seconds.
    pub start_s: f64,
    /// Time to the end, seconds, above 0.
    pub duration_s: f64,
    /// Pose, velocity and acceleration at the start.
    pub from: [Pose; 3],
    /// Pose at rest.
    pub to: Pose,
    /// Amplitude of the swing after the end.
    pub swing: Pose,
    /// Swing's frequency, hertz.
    pub swing_hz: f64,
    /// Swing's time constant, seconds.
    pub decay_s: f64,
}

impl Leg {
    /// Standing at a pose since ever.
    pub fn rest(at: Pose) -> Self {
        let still = Pose::default();
        let from = [at, still, still];
        Self {
            start_s: f64::NEG_INFINITY,
            duration_s: 1.0,
            from,
            to: at,
            swing: still,
            swing_hz: 1.0,
            decay_s: 1.0,
        }
    }

    /// Instant at which the leg's end is reached, seconds.
    pub fn end_s(&self) -> f64 {
        self.start_s + self.duration_s
    }

    /// The move alone, without its swing.
    fn course(&self, time_s: f64) -> Pose {
        if time_s >= self.end_s() {
            return self.to;
        }
        let [position, velocity, acceleration] = self.from;
        let (u, t) = ((time_s - self.start_s) / self.duration_s, self.duration_s);
        let (u3, u4, u5) = (u.powi(3), u.powi(4), u.powi(5));
        let distance = self.to.plus(position, -1.0);
        position
            .plus(distance, 10.0 * u3 - 15.0 * u4 + 6.0 * u5)
            .plus(velocity, t * (u - 6.0 * u3 + 8.0 * u4 - 3.0 * u5))
            .plus(
                acceleration,
                0.5 * t * t * (u * u - 3.0 * u3 + 3.0 * u4 - u5),
            )
    }

    /// The swing about the end. Starts at 0 with no velocity: the pose stays smooth at the leg's end.
    fn swing(&self, time_s: f64) -> Pose {
        let since_end_s = time_s - self.end_s();
        if !(since_end_s.is_finite() && since_end_s > 0.0) {
            return Pose::default();
        }
        let turn = std::f64::consts::TAU * self.swing_hz * since_end_s;
        let factor = (-since_end_s / self.decay_s).exp() * (1.0 - turn.cos());
        Pose::default().plus(self.swing, factor)
    }
}

/// The last legs; a pose at any time from the oldest on.
#[derive(Clone, Debug)]
pub struct Trajectory {
    legs: Vec<Leg>,
}

impl Trajectory {
    /// Standing at a pose.
    pub fn standing(at: Pose) -> Self {
        Self {
            legs: vec![Leg::rest(at)],
        }
    }

    /// Begins a leg; it goes on smoothly from where the courier is if `from` was taken by [`Trajectory::course_state`]. What
    /// is left of earlier swings dies away under it; a leg that is cut short has none.
    pub fn push(&mut self, leg: Leg) {
        if self.legs.len() == KEPT {
            self.legs.remove(0);
        }
        if let Some(last) = self.legs.last_mut()
            && last.end_s() > leg.start_s
        {
            last.swing = Pose::default();
        }
        self.legs.push(leg);
    }

    /// Pose, velocity and acceleration of the move at an instant, swings aside, by central differences of 0.1 ms.
    pub fn course_state(&self, time_s: f64) -> [Pose; 3] {
        const STEP_S: f64 = 1.0e-4;
        let [before, at, after] = [-STEP_S, 0.0, STEP_S].map(|step| self.course(time_s + step));
        let velocity = Pose::default()
            .plus(after, 0.5 / STEP_S)
            .plus(before, -0.5 / STEP_S);
        let second = after.plus(at, -2.0).plus(before, 1.0);
        [
            at,
            velocity,
            Pose::default().plus(second, 1.0 / (STEP_S * STEP_S)),
        ]
    }

    fn course(&self, time_s: f64) -> Pose {
        let running = self.legs.iter().rev().find(|leg| leg.start_s <= time_s);
        running.map_or(self.legs[0].from[0], |leg| leg.course(time_s))
    }

    /// The leg that runs, or ran last.
    pub fn last(&self) -> &Leg {
        self.legs.last().expect("there is always a leg")
    }
}

impl Motion for Trajectory {
    fn pose(&self, time_s: f64) -> Pose {
        let begun = self.legs.iter().filter(|leg| leg.start_s <= time_s);
        begun.fold(self.course(time_s), |pose, leg| {
            pose.plus(leg.swing(time_s), 1.0)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn leg(start_s: f64, from: [Pose; 3]) -> Leg {
        let (to, swing) = (
            Pose::new(0.02, -0.01, 0.004),
            Pose::new(2.0e-5, 0.0, 1.0e-4),
        );
        Leg {
            start_s,
            duration_s: 0.2,
            from,
            to,
            swing,
            swing_hz: 60.0,
            decay_s: 0.012,
        }
    }

    #[test]
    fn pose_and_velocity_have_no_steps() {
        let mut trajectory = Trajectory::standing(Pose::default());
        trajectory.push(leg(1.0, trajectory.course_state(1.0)));
        // Taken over in the middle of the move, back to where it came from.
        let turned = Leg {
            to: Pose::default(),
            ..leg(1.1, trajectory.course_state(1.1))
        };
        trajectory.push(turned);
        let at = |index: i32| trajectory.pose(0.99 + f64::from(index) * 1.0e-5).x_m;
        for index in 1..50_000 {
            let second_difference = at(index + 1) - 2.0 * at(index) + at(index - 1);
            // 60 m/s^2 is what the swing starts with (20 um, 60 Hz: 2.8) and the quintics need (0.02 m in 0.2 s: 5 to 30).
            assert!(
                second_difference.abs() < 60.0 * 1.0e-10,
                "{index}: {second_difference}"
            );
        }
    }

    #[test]
    fn a_swing_is_not_taken_for_acceleration() {
        let mut trajectory = Trajectory::standing(Pose::default());
        trajectory.push(leg(0.0, trajectory.course_state(0.0)));
        let rest = trajectory.legs[1].to;
        // The courier still swings by some micrometres when it is told to stay.
        let stay = Leg {
            to: rest,
            swing: Pose::default(),
            ..leg(0.205, trajectory.course_state(0.205))
        };
        trajectory.push(stay);
        let farthest = (0..200)
            .map(|ms| trajectory.pose(0.205 + f64::from(ms) * 1.0e-3).x_m - rest.x_m)
            .fold(0.0, |far: f64, off| far.max(off.abs()));
        assert!(farthest > 1.0e-6 && farthest < 40.0e-6, "{farthest}");
    }

    #[test]
    fn comes_to_rest_at_its_end() {
        let mut trajectory = Trajectory::standing(Pose::default());
        trajectory.push(leg(0.0, trajectory.course_state(0.0)));
        assert_eq!(trajectory.pose(-1.0), Pose::default());
        let rest = trajectory
            .pose(0.2 + 0.2)
            .plus(Pose::new(0.02, -0.01, 0.004), -1.0);
        assert!(
            rest.x_m.abs() < 1.0e-11 && rest.y_m == 0.0 && rest.theta_rad.abs() < 1.0e-10,
            "{rest:?}"
        );
    }
}
