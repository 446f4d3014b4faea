//! Ordinary motion of a courier: from place to place, as an assembly system would send it.

use effects::motion::{Motion, Pose};
use effects::random::{ChaCha8Rng, SeedableRng, uniform};
use hal_sim::trajectory::Profile;

/// Where a courier works and how it goes there.
#[derive(Clone, Copy, Debug)]
pub struct Work {
    /// Middle of the place.
    pub middle: Pose,
    /// Half its sides along x and y, metres.
    pub half_m: [f64; 2],
    /// Largest angle either way, radians.
    pub turn_rad: f64,
    /// Highest speed, m/s.
    pub speed_m_s: f64,
    /// Rest at each end of a way, seconds at most.
    pub rest_s: f64,
}

impl Work {
    /// 40 mm a side, as the paper's fly-bys are long, and its calibration's ±0.5°, at the board's own speed.
    pub const ORDINARY: Self = Self {
        middle: Pose {
            x_m: 0.02,
            y_m: 0.02,
            theta_rad: 0.0,
        },
        half_m: [0.02; 2],
        turn_rad: 8.727e-3,
        speed_m_s: 0.2,
        rest_s: 0.5,
    };
}

/// Ramp of a move, seconds.
const RAMP_S: f64 = 0.06;

/// The motion, drawn as time goes on.
pub struct Traffic {
    work: Work,
    /// Where it goes again and again, if it does.
    stops: Vec<Pose>,
    next: usize,
    rng: ChaCha8Rng,
    from: Pose,
    to: Pose,
    start_s: f64,
    profile: Profile,
    end_s: f64,
}

impl Traffic {
    pub fn new(work: Work, seed: u64) -> Self {
        Self {
            work,
            stops: Vec::new(),
            next: 0,
            rng: ChaCha8Rng::seed_from_u64(seed),
            from: work.middle,
            to: work.middle,
            start_s: 0.0,
            profile: Profile::new(0.0, 1.0, RAMP_S),
            end_s: 0.0,
        }
    }

    /// This work from now on.
    pub fn set_work(&mut self, work: Work) {
        self.work = work;
        self.stops.clear();
    }

    /// Other work from now on: anywhere on 0.1 m of the platen, within 5 to 40 mm and 0.2° to 0.5°, at 50 to 500 mm/s, with rests of up to
    /// 2 to 10 s; every third goes over the same three to eight stops again and again.
    pub fn change_work(&mut self) {
        let mut draw = |low: f64, high: f64| uniform(&mut self.rng, low, high);
        let middle = Pose::new(draw(0.0, 0.1), draw(0.0, 0.1), draw(-2.0e-3, 2.0e-3));
        let work = Work {
            middle,
            half_m: [draw(2.5e-3, 20.0e-3), draw(2.5e-3, 20.0e-3)],
            turn_rad: draw(3.5e-3, 8.727e-3),
            speed_m_s: draw(0.05, 0.5),
            rest_s: draw(2.0, 10.0),
        };
        let repeats = draw(0.0, 3.0) < 1.0;
        let stops = if repeats { draw(3.0, 9.0) as usize } else { 0 };
        self.work = work;
        self.stops = (0..stops).map(|_| self.anywhere()).collect();
    }

    fn anywhere(&mut self) -> Pose {
        let work = self.work;
        let mut within = |half: f64| uniform(&mut self.rng, -1.0, 1.0) * half;
        let by = Pose::new(
            within(work.half_m[0]),
            within(work.half_m[1]),
            within(work.turn_rad),
        );
        work.middle.plus(by, 1.0)
    }

    /// Goes on to a time.
    pub fn advance(&mut self, time_s: f64) {
        while time_s >= self.end_s {
            let to = match self.stops.get(self.next % self.stops.len().max(1)) {
                Some(stop) => *stop,
                None => self.anywhere(),
            };
            self.next += 1;
            (self.from, self.to) = (self.to, to);
            let way = self.to.plus(self.from, -1.0);
            self.start_s = self.end_s;
            self.profile = Profile::new(way.x_m.hypot(way.y_m), self.work.speed_m_s, RAMP_S);
            let rest_s = uniform(&mut self.rng, 0.0, self.work.rest_s);
            self.end_s = self.start_s + self.profile.duration_s() + rest_s;
        }
    }

    /// Until when it rests from a time on: no reading tells anything new by then.
    pub fn rests_until_s(&self, time_s: f64) -> Option<f64> {
        (time_s > self.start_s + self.profile.duration_s() && time_s < self.end_s)
            .then_some(self.end_s)
    }
}

impl Motion for Traffic {
    fn pose(&self, time_s: f64) -> Pose {
        let progress = self.profile.at(time_s - self.start_s);
        self.from.plus(self.to.plus(self.from, -1.0), progress)
    }
}
