//! What a planned self-motion can tell, before anything moves.
//!
//! The firmware's own rows (whitened, `Constraints::rows`) at the poses to be visited, with errors of zero; from their triangle in
//! f64: each unknown's predicted standard deviation, directions that stay undetermined, groups whose columns span nearly
//! the same space (principal angles), and which change of motion parts them. The algebra is [`guided::triangle`]'s, which guided
//! calibration uses as well.

mod angles;
mod course;
mod needed;
mod poses;
mod problem;
mod question;

pub use angles::Angle;
pub use course::{Course, Told};
pub use needed::Needed;
pub use problem::Parameter;
pub use question::{Motion, Question};

use angles::OTHERS;
use problem::Problem;
use serde::Serialize;

/// Groups closer than this are said to be confused. Derived from the sine: their common part is known 20 times worse than each
/// alone.
const CONFUSED_DEG: f64 = 3.0;
/// What another motion would do for a group.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Remedy {
    /// The group.
    pub group: String,
    /// The change of motion.
    pub change: String,
    /// Smallest principal angle from all other groups as planned, degrees.
    pub angle_deg: f64,
    /// With the change.
    pub angle_after_deg: f64,
    /// Worst predicted deviation within the group as planned (none: undetermined).
    pub deviation: Option<f64>,
    /// With the change.
    pub deviation_after: Option<f64>,
}

/// The answer.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Isolability {
    /// The motion.
    pub motion: Motion,
    /// Condition number, columns equally long; none if directions are undetermined.
    pub condition_number: Option<f64>,
    /// Directions of the unknowns that the poses do not determine.
    pub undetermined_directions: usize,
    /// What no motion determines, and by which convention it is chosen.
    pub gauge: Vec<&'static str>,
    /// All unknowns.
    pub parameters: Vec<Parameter>,
    /// Each group against all others, and those pairs that are closer than 20°.
    pub angles: Vec<Angle>,
    /// For each confused group, what would part it from the others.
    pub remedies: Vec<Remedy>,
    /// How many poses of this plan the coefficients need; none where it does not determine them all.
    pub needed: Option<Needed>,
}

/// Answers.
#[must_use]
pub fn analyse(question: &Question) -> Isolability {
    let problem = Problem::new(question);
    let angles = problem.angles();
    let confused: Vec<&Angle> = angles
        .iter()
        .filter(|a| a.other == OTHERS && a.angle_deg < CONFUSED_DEG)
        .collect();
    let changes = changes(question.motion, question.geometry.pitch_m);
    let mut remedies = Vec::new();
    for (change, motion) in &changes {
        let after = Problem::new(&Question {
            motion: *motion,
            ..question.clone()
        });
        for angle in &confused {
            remedies.push(Remedy {
                group: angle.group.clone(),
                change: change.clone(),
                angle_deg: angle.angle_deg,
                angle_after_deg: after.angle_from_others(&angle.group),
                deviation: problem.worst_deviation(&angle.group),
                deviation_after: after.worst_deviation(&angle.group),
            });
        }
    }
    let (condition_number, undetermined_directions) = problem.triangle.condition();
    Isolability {
        motion: question.motion,
        condition_number,
        undetermined_directions,
        gauge: gauge(question.motion.beacon),
        parameters: problem.parameters(),
        angles,
        remedies,
        needed: needed::of(question, &problem),
    }
}

/// Changes of a motion that may help: a larger angle, the beacon, both.
fn changes(motion: Motion, pitch_m: f32) -> Vec<(String, Motion)> {
    let (turn_rad, travel_m) = (26.2e-3f32, 2.0 * pitch_m);
    let mut changes = Vec::new();
    if motion.turn_rad < 0.9 * turn_rad {
        changes.push(("turn by ±1.5°".to_owned(), Motion { turn_rad, ..motion }));
    }
    if !motion.beacon {
        changes.push((
            "go under a beacon".to_owned(),
            Motion {
                beacon: true,
                travel_m,
                ..motion
            },
        ));
        if motion.turn_rad < 0.9 * turn_rad {
            let both = Motion {
                beacon: true,
                travel_m,
                turn_rad,
                ..motion
            };
            changes.push(("go under a beacon and turn by ±1.5°".to_owned(), both));
        }
    }
    changes.push((
        "four times the poses".to_owned(),
        Motion {
            poses: 4 * motion.poses,
            ..motion
        },
    ));
    changes
}

fn gauge(beacon: bool) -> Vec<&'static str> {
    let mut gauge = vec![
        "constants: g_p tells k1 - k2 - k3 + k4 only; it is spread equally, each pair's mean is left alone",
    ];
    if beacon {
        gauge.push("each pair's mean constant is exchangeable with the beacon's place: it is zero");
        gauge
            .push("the diode's centre is exchangeable with the lever arm, its mean gain with h: neither is an unknown");
        gauge.push(
            "a common turn of diode, lever arm and constants changes nothing: the angle offset is held where the diode's angle is free",
        );
    }
    gauge
}

#[cfg(test)]
mod tests {
    use super::*;
    use courier_sensor::geometry::Geometry;

    fn question(turn_deg: f32, beacon: bool, lateral_m: f32) -> Question {
        let geometry = Geometry {
            lateral_m,
            ..Geometry::PAPER
        };
        let travel_m = if beacon { 2.0 } else { 10.0 } * geometry.pitch_m;
        let motion = Motion {
            poses: 1000,
            travel_m,
            turn_rad: turn_deg.to_radians(),
            beacon,
            chosen: false,
            seed: 1,
        };
        Question {
            geometry,
            motion,
            noise_m: 1.0e-6,
            sensor_terms: false,
        }
    }

    fn lateral_angle(question: &Question) -> f64 {
        Problem::new(question).angle_from_others("lateral terms")
    }

    /// The paper's failure: lateral terms from g_p alone. The angles are those computed independently before (domain facts):
    /// zero if l_o is half the span, 0.1° to 0.6° otherwise at ±0.5°, 1° to 5° at ±1.5°.
    #[test]
    fn lateral_terms_cannot_be_told_from_the_parity_alone() {
        for lateral_mm in [1.0f32, 2.0, 3.0, 4.0, 6.0] {
            let half = lateral_angle(&question(0.5, false, lateral_mm * 1e-3));
            let three = lateral_angle(&question(1.5, false, lateral_mm * 1e-3));
            println!("l_o = {lateral_mm} mm: {half:.2}° at ±0.5°, {three:.2}° at ±1.5°");
            assert!((0.02..1.0).contains(&half), "{half}");
            assert!((0.3..7.0).contains(&three), "{three}");
        }
        assert!(lateral_angle(&question(0.5, false, 4.85e-3)) < 0.02);
    }

    #[test]
    fn the_failure_is_explained_and_the_beacon_is_the_remedy() {
        let answer = analyse(&question(0.5, false, 3.0e-3));
        let lateral = answer
            .angles
            .iter()
            .find(|a| a.group == "lateral terms" && a.other == OTHERS)
            .unwrap();
        assert!(lateral.angle_deg < CONFUSED_DEG);
        let pair = answer
            .angles
            .iter()
            .find(|a| a.group == "own order 1" && a.other == "lateral terms")
            .unwrap();
        assert!(
            (pair.angle_deg - lateral.angle_deg).abs() < 0.3,
            "{pair:?} {lateral:?}"
        );
        let under_beacon = answer
            .remedies
            .iter()
            .find(|r| {
                r.group == "lateral terms" && r.change == "go under a beacon and turn by ±1.5°"
            })
            .unwrap();
        assert!(
            under_beacon.angle_after_deg > 10.0 && under_beacon.deviation_after.unwrap() < 0.15e-6,
            "{under_beacon:?}"
        );
    }

    #[test]
    fn a_motion_without_rotation_leaves_directions_undetermined() {
        let still = analyse(&question(0.0, true, 3.0e-3));
        assert!(still.undetermined_directions > 0 && still.condition_number.is_none());
        let lever = still.parameters.iter().find(|p| p.name == "l_x").unwrap();
        assert_eq!((lever.deviation, lever.rests_on), (None, "prior"));
        // 1 um / 9.7 mm * 90 mm over 15.1 mrad rms and the root of 1000 poses: 19.4 um.
        let turning = analyse(&question(1.5, true, 3.0e-3));
        assert_eq!(turning.undetermined_directions, 0);
        let lever = turning.parameters.iter().find(|p| p.name == "l_x").unwrap();
        assert!((18.0e-6..21.0e-6).contains(&lever.deviation.unwrap()) && lever.rests_on == "data");
    }
}
