//! What a planned self-motion can tell, before anything moves.
//!
//! The firmware's own rows (whitened, [`Constraints::rows`]) at the poses to be visited, with errors of zero; from their triangle in
//! f64: each unknown's predicted standard deviation, directions that stay undetermined, groups whose columns span nearly
//! the same space (principal angles; Björck and Golub 1973), and which change of motion parts them.

use courier_sensor::calibration::joint::{
    Constraints, Groups, JointSolver, Layout, Priors, ReadingNoise, Unknown, Values, Weighting,
    about_sensor, entered, foreseen_under_beacon,
};
use courier_sensor::calibration::{
    GatedFit, Planner, Range, Regression, RelativePose, Sample, foreseen,
};
use courier_sensor::geometry::Geometry;
use courier_sensor::model::{ErrorModel, TermTable};
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

/// Groups closer than this are said to be confused: their common part is known 20 times worse than each alone.
const CONFUSED_DEG: f64 = 3.0;
/// Singular values below this share of the largest, columns equally long, are nothing: the rows are of f32.
const UNDETERMINED: f64 = 1.0e-5;
/// A column that moves all poses together by less than this many deviations, the unknown off by its prior's, is rounding.
const UNFELT: f64 = 1.0e-2;
/// An unknown whose deviation is above this share of its prior's is the prior's.
const PRIORS_OWN: f64 = 0.7;

/// A planned self-motion.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Motion {
    /// Poses.
    pub poses: u32,
    /// Range in x and y, metres.
    pub travel_m: f32,
    /// Largest angle to either side, radians.
    pub turn_rad: f32,
    /// Turning about the coordination sensor under a beacon: g_x and g_y are there as well as g_p.
    pub beacon: bool,
    /// Whether poses are chosen instead of drawn.
    pub chosen: bool,
    /// Of the pose generator.
    pub seed: u64,
}

/// What is asked.
#[derive(Clone, Debug)]
pub struct Question {
    /// Geometry.
    pub geometry: Geometry,
    /// The motion.
    pub motion: Motion,
    /// Noise of a pose's averaged readings, metres.
    pub noise_m: f32,
    /// Whether the diode's own errors are among the unknowns.
    pub sensor_terms: bool,
}

/// One unknown.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Parameter {
    /// Its name.
    pub name: String,
    /// Unit of the deviations.
    pub unit: &'static str,
    /// Predicted standard deviation by the poses alone; none where they do not determine it.
    pub deviation: Option<f64>,
    /// With what is believed before.
    pub deviation_with_prior: f64,
    /// The prior's own.
    pub prior: f64,
    /// `data` or `prior`: which of them the result would rest on.
    pub rests_on: &'static str,
}

/// How far apart two groups are.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Angle {
    /// A group.
    pub group: String,
    /// Another, or all others.
    pub other: String,
    /// Smallest principal angle of their columns, degrees: 90 is independent, 0 is the same.
    pub angle_deg: f64,
}

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
}

/// Answers.
#[must_use]
pub fn analyse(question: &Question) -> Isolability {
    let problem = Problem::new(question);
    let mut answer = problem.answer(question.motion);
    let confused: Vec<&Angle> = answer
        .angles
        .iter()
        .filter(|a| a.other == OTHERS && a.angle_deg < CONFUSED_DEG)
        .collect();
    let changes = changes(question.motion);
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
    answer.remedies = remedies;
    answer
}

const OTHERS: &str = "all others";

/// Changes of a motion that may help: a larger angle, the beacon, both.
fn changes(motion: Motion) -> Vec<(String, Motion)> {
    let (turn_rad, travel_m) = (26.2e-3f32, 2.0 * Geometry::PAPER.pitch_m);
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

/// The triangle of a motion's rows.
struct Problem {
    layout: Layout,
    free: Vec<usize>,
    /// Columns equally long.
    triangle: DMatrix<f64>,
    lengths: Vec<f64>,
    priors: Vec<f64>,
}

impl Problem {
    fn new(question: &Question) -> Self {
        let model = ErrorModel::zero(TermTable::equation_9());
        let layout = Layout::new(&model).unwrap_or_default();
        let noise = ReadingNoise {
            segment_m: question.noise_m,
            displacement_m: question.noise_m,
        };
        let geometry = question.geometry;
        let constraints = Constraints {
            geometry,
            layout: layout.clone(),
            noise,
            stated_noise: noise,
            weighting: Weighting::Covariance,
        };
        let values = entered(&layout, &model, &geometry);
        let mut solver = Box::new(JointSolver::new());
        solver.set_priors(&constraints, &values, &Priors::default());
        let groups = groups(question);
        let free: Vec<usize> = layout.free(groups).iter().map(|&i| i.into()).collect();
        let channels = if question.motion.beacon { 3 } else { 1 };
        let rows = poses(question, &constraints, &values, &mut solver, groups)
            .into_iter()
            .flat_map(|pose| {
                let sample = foreseen_under_beacon(&constraints, &values, &start(), &pose);
                constraints
                    .rows(&values, &sample)
                    .jacobian
                    .into_iter()
                    .take(channels)
            })
            .flat_map(|row| free.iter().map(|&i| f64::from(row[i])).collect::<Vec<_>>())
            .collect::<Vec<f64>>();
        let jacobian = DMatrix::from_row_slice(rows.len() / free.len(), free.len(), &rows);
        let mut triangle = jacobian.qr().unpack_r();
        let priors: Vec<f64> = free
            .iter()
            .map(|&i| f64::from(solver.prior_deviation(i)))
            .collect();
        let mut lengths: Vec<f64> = triangle.column_iter().map(|c| c.norm()).collect();
        for ((mut column, length), prior) in
            triangle.column_iter_mut().zip(&mut lengths).zip(&priors)
        {
            if *length * prior < UNFELT {
                column.fill(0.0);
                *length = 1.0;
            } else {
                column /= *length;
            }
        }
        Self {
            layout,
            free,
            triangle,
            lengths,
            priors,
        }
    }

    fn answer(&self, motion: Motion) -> Isolability {
        let singular = self.triangle.clone().singular_values();
        let largest = singular.max();
        let undetermined_directions = self.free.len()
            - singular
                .iter()
                .filter(|&&s| s > UNDETERMINED * largest)
                .count();
        Isolability {
            motion,
            condition_number: (undetermined_directions == 0).then(|| largest / singular.min()),
            undetermined_directions,
            gauge: gauge(motion.beacon),
            parameters: self.parameters(),
            angles: self.angles(),
            remedies: Vec::new(),
        }
    }

    /// Predicted variances by the poses alone, infinite where undetermined.
    fn variances(&self) -> Vec<f64> {
        let svd = self.triangle.clone().svd(false, true);
        let Some(right) = svd.v_t else {
            return vec![f64::INFINITY; self.free.len()];
        };
        let largest = svd.singular_values.max();
        (0..self.free.len())
            .map(|column| {
                let parts = svd.singular_values.iter().enumerate().map(|(k, s)| {
                    let share = right[(k, column)].powi(2);
                    if *s > UNDETERMINED * largest {
                        share / (s * s)
                    } else if share > 1.0e-8 {
                        f64::INFINITY
                    } else {
                        0.0
                    }
                });
                parts.sum::<f64>() / self.lengths[column].powi(2)
            })
            .collect()
    }

    fn variances_with_priors(&self) -> Vec<f64> {
        let n = self.free.len();
        let mut stacked = DMatrix::zeros(2 * n, n);
        stacked
            .view_mut((0, 0), (self.triangle.nrows(), n))
            .copy_from(&self.triangle);
        for i in 0..n {
            stacked[(n + i, i)] = 1.0 / (self.priors[i] * self.lengths[i]);
        }
        let triangle = stacked.qr().unpack_r();
        (0..n)
            .map(|column| {
                let unit = DVector::from_fn(n, |i, _| {
                    if i == column {
                        1.0 / self.lengths[i]
                    } else {
                        0.0
                    }
                });
                triangle
                    .tr_solve_upper_triangular(&unit)
                    .map_or(f64::INFINITY, |v| v.norm_squared())
            })
            .collect()
    }

    fn parameters(&self) -> Vec<Parameter> {
        let (alone, with_prior) = (self.variances(), self.variances_with_priors());
        (0..self.free.len())
            .map(|column| {
                let unknown = self.layout.unknown(self.free[column]);
                let deviation_with_prior = with_prior[column].sqrt();
                let priors_own = deviation_with_prior > PRIORS_OWN * self.priors[column];
                Parameter {
                    name: unknown.to_string(),
                    unit: unit(unknown),
                    deviation: alone[column].is_finite().then(|| alone[column].sqrt()),
                    deviation_with_prior,
                    prior: self.priors[column],
                    rests_on: if priors_own { "prior" } else { "data" },
                }
            })
            .collect()
    }

    fn groups(&self) -> Vec<(String, Vec<usize>)> {
        let mut groups: Vec<(String, Vec<usize>)> = Vec::new();
        for (column, &index) in self.free.iter().enumerate() {
            let name = group_name(self.layout.unknown(index));
            match groups.iter_mut().find(|(other, _)| *other == name) {
                Some((_, columns)) => columns.push(column),
                None => groups.push((name, vec![column])),
            }
        }
        groups
    }

    fn angles(&self) -> Vec<Angle> {
        let groups = self.groups();
        let mut angles: Vec<Angle> = groups
            .iter()
            .map(|(name, _)| Angle {
                group: name.clone(),
                other: OTHERS.into(),
                angle_deg: self.angle_from_others(name),
            })
            .collect();
        for (i, (name, columns)) in groups.iter().enumerate() {
            for (other, other_columns) in &groups[i + 1..] {
                let angle_deg = self.angle(columns, other_columns);
                if angle_deg < 20.0 {
                    angles.push(Angle {
                        group: name.clone(),
                        other: other.clone(),
                        angle_deg,
                    });
                }
            }
        }
        angles
    }

    fn angle_from_others(&self, group: &str) -> f64 {
        let (own, others): (Vec<usize>, Vec<usize>) = (0..self.free.len())
            .partition(|&column| group_name(self.layout.unknown(self.free[column])) == group);
        self.angle(&own, &others)
    }

    /// Smallest principal angle between two sets of columns, degrees; by its sine, which is exact for small ones.
    fn angle(&self, a: &[usize], b: &[usize]) -> f64 {
        if a.is_empty() || b.is_empty() {
            return 90.0;
        }
        let [qa, qb] = [a, b].map(|columns| self.basis(columns));
        let rest = &qa - &qb * (qb.transpose() * &qa);
        let sine = if qa.ncols() == 0 {
            0.0
        } else {
            rest.singular_values().min()
        };
        sine.clamp(0.0, 1.0).asin().to_degrees()
    }

    /// Orthonormal basis of some columns' span; dependent ones give fewer.
    fn basis(&self, columns: &[usize]) -> DMatrix<f64> {
        let picked = self.triangle.select_columns(columns);
        let svd = picked.svd(true, false);
        let keep: Vec<usize> = (0..svd.singular_values.len())
            .filter(|&i| svd.singular_values[i] > UNDETERMINED)
            .collect();
        svd.u.map_or_else(
            || DMatrix::zeros(self.triangle.nrows(), 0),
            |u| u.select_columns(&keep),
        )
    }

    fn worst_deviation(&self, group: &str) -> Option<f64> {
        let variances = self.variances();
        let of_group = (0..self.free.len())
            .filter(|&c| group_name(self.layout.unknown(self.free[c])) == group);
        let worst = of_group.map(|c| variances[c]).fold(0.0, f64::max);
        worst.is_finite().then(|| worst.sqrt())
    }
}

fn groups(question: &Question) -> Groups {
    let platen = Groups::PLATEN | Groups::LATERAL;
    match (question.motion.beacon, question.sensor_terms) {
        (false, _) => platen,
        (true, false) => Groups::PAPER,
        (true, true) => Groups::PAPER | Groups::SENSOR,
    }
}

/// The first pose: nothing is known of its phases, and nothing depends on them.
fn start() -> Sample {
    Sample::ZERO
}

fn poses(
    question: &Question,
    constraints: &Constraints,
    values: &Values,
    solver: &mut JointSolver,
    groups: Groups,
) -> Vec<RelativePose> {
    let Motion {
        poses,
        travel_m,
        turn_rad,
        beacon,
        chosen,
        seed,
    } = question.motion;
    let mut planner = Planner::new(Range { travel_m, turn_rad }, seed);
    let lever_m = question.geometry.lever_m;
    match (beacon, chosen) {
        (false, false) => (0..poses).map(|_| planner.random()).collect(),
        (true, false) => (0..poses)
            .map(|_| about_sensor(lever_m, planner.centred(false)))
            .collect(),
        (false, true) => chosen_for_platen(question, &mut planner),
        (true, true) => {
            solver.begin_plan(constraints, values, groups);
            (0..poses)
                .map(|_| {
                    let pose = solver.choose(constraints, values, &start(), &mut planner);
                    let sample = foreseen_under_beacon(constraints, values, &start(), &pose);
                    solver.add_to_plan(constraints, values, &sample);
                    pose
                })
                .collect()
        }
    }
}

fn chosen_for_platen(question: &Question, planner: &mut Planner) -> Vec<RelativePose> {
    let model = ErrorModel::zero(TermTable::equation_3());
    let Some(regression) = Regression::new(&question.geometry, &model) else {
        return Vec::new();
    };
    let mut fit = Box::new(GatedFit::new());
    fit.reset(regression.unknowns(), question.noise_m);
    (0..question.motion.poses)
        .map(|_| {
            let pose = planner.optimal(fit.estimator(), &regression, &start());
            fit.add(&regression, &foreseen(&regression, &start(), &pose));
            pose
        })
        .collect()
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

fn group_name(unknown: Unknown) -> String {
    match unknown {
        Unknown::Coefficient { term, .. } if term.lateral_order != 0 => "lateral terms".into(),
        Unknown::Coefficient { term, .. } => format!("own order {}", term.own_order),
        Unknown::ParityOffset => "parity offset".into(),
        Unknown::AngleOffset => "angle offset".into(),
        Unknown::Height => "height".into(),
        Unknown::Lever(_) => "lever arm".into(),
        Unknown::Place(_) => "beacon's place".into(),
        Unknown::GainDifference | Unknown::Turn => "diode misalignment".into(),
        Unknown::Nonlinearity(..) => "diode nonlinearity".into(),
    }
}

fn unit(unknown: Unknown) -> &'static str {
    match unknown {
        Unknown::Turn => "rad",
        Unknown::GainDifference | Unknown::Nonlinearity(..) => "1",
        _ => "m",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
