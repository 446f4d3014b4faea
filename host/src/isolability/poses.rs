//! The poses that a motion would visit.

use super::question::{Motion, Question};
use courier_sensor::calibration::joint::{
    Constraints, Groups, JointSolver, Values, about_sensor, foreseen_under_beacon,
};
use courier_sensor::calibration::{
    GatedFit, Planner, Range, Regression, RelativePose, Sample, foreseen,
};
use courier_sensor::model::{ErrorModel, TermTable};

/// The first pose: nothing is known of its phases, and nothing depends on them.
pub(super) fn start() -> Sample {
    Sample::ZERO
}

/// In their order.
pub(super) fn visited(
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
            fit.add(&regression, &foreseen(&regression, &[], &start(), &pose));
            pose
        })
        .collect()
}
