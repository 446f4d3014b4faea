//! How well each group is known after so many poses of a motion: by it a calibration is as long as it must be and no longer.

use super::problem::{Problem, Rows};
use super::question::Question;
use serde::Serialize;

/// Poses between two looks. Cost alone: what is told between two looks is not computed.
const STEP: usize = 20;

/// How well a group is known.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Told {
    /// The group.
    pub group: String,
    /// Worst predicted deviation within it, m; none where it is not determined.
    pub deviation_m: Option<f64>,
}

/// What each group is known to along a motion.
#[derive(Clone, Debug)]
pub struct Course {
    /// After each number of poses.
    steps: Vec<(u32, Vec<Told>)>,
}

impl Course {
    /// Of the motion that a question names.
    #[must_use]
    pub fn new(question: &Question) -> Self {
        let rows = Rows::new(question);
        let mut problem = rows.before();
        let mut steps = Vec::new();
        for from in (0..rows.len()).step_by(STEP) {
            let to = rows.len().min(from + STEP);
            problem = rows.with(problem, from..to);
            steps.push((to as u32, told(&problem)));
        }
        Self { steps }
    }

    /// After so many poses.
    #[must_use]
    pub fn after(&self, poses: u32) -> &[Told] {
        let done = self.steps.iter().take_while(|(at, _)| *at <= poses).last();
        done.map_or(&[], |(_, told)| told)
    }

    /// Groups that the whole motion does not tell to a deviation, m.
    #[must_use]
    pub fn missed(&self, wanted_m: f64) -> Vec<Told> {
        let last = self.steps.last().map_or(&[][..], |(_, told)| told);
        let missed = last.iter().filter(|told| !told.is_within(wanted_m));
        missed.cloned().collect()
    }

    /// Poses after which every group is told to a deviation, but for those that the whole motion does not.
    #[must_use]
    pub fn enough(&self, wanted_m: f64) -> Option<u32> {
        let missed = self.missed(wanted_m);
        let well =
            |told: &Told| told.is_within(wanted_m) || missed.iter().any(|m| m.group == told.group);
        let found = self.steps.iter().find(|(_, all)| all.iter().all(well));
        found.map(|(poses, _)| *poses)
    }
}

impl Told {
    /// True where it is known as well as is wanted.
    #[must_use]
    pub fn is_within(&self, wanted_m: f64) -> bool {
        self.deviation_m.is_some_and(|m| m <= wanted_m)
    }
}

fn told(problem: &Problem) -> Vec<Told> {
    let variances = problem.triangle.variances();
    let of = |(group, columns): (String, Vec<usize>)| {
        let worst = columns.iter().map(|c| variances[*c]).fold(0.0, f64::max);
        Told {
            group,
            deviation_m: worst.is_finite().then(|| worst.sqrt()),
        }
    };
    problem.groups().into_iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::isolability::Motion;
    use courier_sensor::geometry::Geometry;

    fn course(beacon: bool) -> Course {
        Course::new(&Question {
            geometry: Geometry::PAPER,
            motion: Motion {
                poses: 200,
                travel_m: 2.0 * Geometry::PAPER.pitch_m,
                turn_rad: 26.18e-3,
                beacon,
                chosen: false,
                seed: 1,
            },
            noise_m: 1.0e-6,
            sensor_terms: false,
        })
    }

    #[test]
    fn more_poses_tell_more_and_a_beacon_parts_what_the_parity_cannot() {
        let alone = course(false);
        let missed: Vec<String> = alone.missed(1.0e-6).into_iter().map(|t| t.group).collect();
        assert_eq!(missed, ["own order 1", "lateral terms"]);
        let enough = alone.enough(1.0e-6).unwrap();
        assert!(enough < 200 && enough > 20, "{enough}");
        let order_4 = |poses| {
            let told = alone.after(poses).iter().find(|t| t.group == "own order 4");
            told.unwrap().deviation_m.unwrap()
        };
        assert!(order_4(200) < 0.8 * order_4(100));
        let under = course(true).missed(1.0e-6);
        assert!(
            under.iter().all(|told| told.group != "lateral terms"),
            "{under:?}"
        );
    }
}
