//! Elementary motions: straight ways from where the courier stands, at three speeds, turned or not. Poses are in the frame that motions
//! are told in.

use diagnosis::design::excitation::Path;
use effects::motion::Pose;
use serde::Serialize;

/// Where motions may go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Area {
    /// Its middle.
    pub centre: Pose,
    /// Reach of long motions to either side along x and y, m.
    pub half_m: f64,
    /// Largest angle to either side, rad.
    pub turn_rad: f64,
}

impl Area {
    /// That of a survey: forty teeth along each axis, half a degree to either side.
    #[must_use]
    pub fn of_survey(centre: Pose) -> Self {
        Self {
            centre,
            half_m: 20.0e-3,
            turn_rad: 8.727e-3,
        }
    }
}

/// One motion.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Move {
    /// Where it begins.
    pub from: Pose,
    /// Where it ends; the same: the courier stands still.
    pub to: Pose,
    /// Peak speed, m/s.
    pub speed_m_s: f64,
}

/// Speeds, m/s: fast, usual, slow. By definition those of a survey.
pub const SPEEDS_M_S: [f64; 3] = [0.2, 0.05, 0.01];
/// Reach of short motions, m. Derived from the diode's 5 mm, which four teeth to either side do not leave with the beacon over
/// the middle.
const SHORT_M: f64 = 4.0e-3;
/// Arm at which an angle counts as a distance, m. By definition the motion controller's.
pub const ARM_M: f64 = 0.1;
/// Peak speed over the mean of a move from rest to rest. Derived from a polynomial of fifth degree: 15/8.
const EASE: f64 = 1.875;
/// Rest behind each motion, s: a controller settles in it.
const REST_S: f64 = 0.05;
/// Time for which the courier stands still where that is what is wanted, s. A prior: ten periods of 20 Hz.
const STILL_S: f64 = 0.5;
/// Samples by which a motion is foreseen. Derived from the longest way, of which each is half a millimetre.
const FORESEEN: usize = 80;
/// Ways that are shorter are none, m. Derived from the pitch: a hundredth of a tooth.
const NOWHERE_M: f64 = 1.0e-5;

impl Move {
    /// How far it goes, m; a turn counts at the arm of the controller.
    #[must_use]
    pub fn distance_m(&self) -> f64 {
        let (a, b) = (&self.from, &self.to);
        (b.x_m - a.x_m)
            .hypot(b.y_m - a.y_m)
            .max(ARM_M * (b.theta_rad - a.theta_rad).abs())
    }

    /// True if nothing moves.
    #[must_use]
    pub fn is_still(&self) -> bool {
        self.distance_m() < NOWHERE_M
    }

    /// How long it takes with the rest behind it, s.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        if self.is_still() {
            STILL_S
        } else {
            EASE * self.distance_m() / self.speed_m_s + REST_S
        }
    }

    /// Name of the run, as recordings have them.
    #[must_use]
    pub fn name(&self) -> String {
        if self.is_still() {
            return "still".into();
        }
        let mm = |from: f64, to: f64| 1.0e3 * (to - from);
        let way = [
            ("x", mm(self.from.x_m, self.to.x_m)),
            ("y", mm(self.from.y_m, self.to.y_m)),
            ("turn", mm(self.from.theta_rad, self.to.theta_rad)),
        ];
        let moved = way.iter().filter(|(_, by)| by.abs() > 1.0e3 * NOWHERE_M);
        let words: Vec<String> = moved.map(|(axis, by)| format!("{axis}{by:+.0}")).collect();
        format!("{}_{:.0}mm_s", words.join("_"), 1.0e3 * self.speed_m_s)
    }

    /// The way, as it is foreseen.
    #[must_use]
    pub fn path(&self) -> Path {
        let by = |part: f64| {
            let eased = part.powi(3) * (10.0 + part * (6.0 * part - 15.0));
            [
                eased * (self.to.x_m - self.from.x_m),
                eased * (self.to.y_m - self.from.y_m),
                eased * (self.to.theta_rad - self.from.theta_rad),
            ]
        };
        let last = (FORESEEN - 1) as f64;
        Path {
            steps: (0..FORESEEN).map(|k| by(k as f64 / last)).collect(),
            step_s: self.seconds() / last,
        }
    }
}

/// The first two motions of any capture: slanted, there and back, turned on the way. They pass every tooth phase of all segments and tell
/// the segments of an axis apart, without which nothing can be asked.
#[must_use]
pub fn opening(at: Pose, area: &Area) -> [Move; 2] {
    let far = Pose {
        x_m: far_side(at.x_m, area.centre.x_m, 0.5 * area.half_m),
        y_m: far_side(at.y_m, area.centre.y_m, 0.5 * area.half_m),
        theta_rad: far_side(at.theta_rad, area.centre.theta_rad, area.turn_rad),
    };
    let back = Pose {
        x_m: 2.0 * area.centre.x_m - far.x_m,
        y_m: 2.0 * area.centre.y_m - far.y_m,
        theta_rad: 2.0 * area.centre.theta_rad - far.theta_rad,
    };
    let go = |from, to| Move {
        from,
        to,
        speed_m_s: SPEEDS_M_S[1],
    };
    [go(at, far), go(far, back)]
}

/// Motions that may follow where the courier stands.
#[must_use]
pub fn available(at: Pose, area: &Area) -> Vec<Move> {
    let mut list = Vec::new();
    let c = area.centre;
    let angles = [0.0, area.turn_rad, -area.turn_rad].map(|turn| c.theta_rad + turn);
    for (speed_m_s, half_m) in [
        (SPEEDS_M_S[0], area.half_m),
        (SPEEDS_M_S[1], area.half_m),
        (SPEEDS_M_S[1], SHORT_M),
        (SPEEDS_M_S[2], SHORT_M),
    ] {
        let [x_m, y_m] = [
            far_side(at.x_m, c.x_m, half_m),
            far_side(at.y_m, c.y_m, half_m),
        ];
        for [to_x_m, to_y_m] in [[x_m, at.y_m], [at.x_m, y_m], [x_m, y_m]] {
            for theta_rad in angles {
                list.push(Move {
                    from: at,
                    to: Pose {
                        x_m: to_x_m,
                        y_m: to_y_m,
                        theta_rad,
                    },
                    speed_m_s,
                });
            }
        }
    }
    for theta_rad in angles {
        let to = Pose { theta_rad, ..at };
        list.push(Move {
            from: at,
            to,
            speed_m_s: SPEEDS_M_S[2],
        });
    }
    // Slow motions over a long way would take longer than all others together.
    list.retain(|go| !go.is_still() && go.seconds() < LONGEST_S);
    list.push(Move {
        from: at,
        to: at,
        speed_m_s: SPEEDS_M_S[2],
    });
    list
}

/// Motions that take longer are not proposed, s. A bound on the work: the longest of a survey's takes 1.9 s.
const LONGEST_S: f64 = 2.0;

/// The side of an interval about a middle that is farther away.
fn far_side(at: f64, middle: f64, half: f64) -> f64 {
    if at > middle {
        middle - half
    } else {
        middle + half
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn motions_stay_in_their_area_and_begin_where_the_courier_stands() {
        let centre = Pose {
            x_m: 0.1,
            y_m: -0.2,
            theta_rad: 0.0,
        };
        let area = Area::of_survey(centre);
        let mut at = centre;
        for k in 0..50 {
            let all = available(at, &area);
            assert!(all.len() > 20, "{}", all.len());
            for go in &all {
                assert_eq!(go.from, at);
                let far = [go.to.x_m - centre.x_m, go.to.y_m - centre.y_m];
                assert!(far.iter().all(|f| f.abs() <= 1.000_001 * area.half_m));
                assert!((go.to.theta_rad).abs() <= 1.000_001 * area.turn_rad);
                assert!(go.seconds() > 0.02 && go.seconds() < LONGEST_S);
            }
            at = all[(7 * k) % all.len()].to;
        }
    }

    #[test]
    fn a_foreseen_way_goes_where_the_motion_does_and_no_faster() {
        let [_, go] = opening(Pose::default(), &Area::of_survey(Pose::default()));
        let path = go.path();
        let last = path.steps.last().unwrap();
        assert!((last[0] - (go.to.x_m - go.from.x_m)).abs() < 1e-12);
        let steps = path.steps.windows(2);
        let fastest = steps
            .map(|w| (w[1][0] - w[0][0]).hypot(w[1][1] - w[0][1]) / path.step_s)
            .fold(0.0, f64::max);
        assert!(fastest <= go.speed_m_s, "{fastest}");
        assert!(fastest > 0.9 * go.speed_m_s, "{fastest}");
    }
}
