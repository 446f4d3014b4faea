//! A session of the board, as far as it concerns the estimate.

use courier_sensor::calibration::record::{Calibration, Poses};
use courier_sensor::calibration::{
    GatedFit, Plan, Planner, Range, Regression, RelativePose, Sample,
};
use courier_sensor::frame::Coordinate;
use courier_sensor::geometry::Geometry;
use courier_sensor::model::{ErrorModel, TermTable};

const GEOMETRY: Geometry = Geometry::PAPER;
/// Poses held out, as a session does unless asked otherwise.
const HELD_OUT: u32 = 200;

/// A self-motion: poses, largest angle, how poses are chosen.
#[derive(Clone, Copy)]
pub struct Motion {
    /// Poses that are fitted.
    pub poses: u32,
    /// Largest angle to either side.
    pub turn_rad: f32,
    /// How they are chosen.
    pub plan: Plan,
}

fn sample(p: &[f64; 4]) -> Sample {
    let coordinate = |p: &f64| {
        let turns = p / f64::from(GEOMETRY.pitch_m);
        Coordinate {
            teeth: turns.round() as i32,
            fraction_turns: (turns - turns.round()) as f32,
        }
    };
    let mut sample = Sample::ZERO;
    (0..4).for_each(|i| sample.unmodified[i] = coordinate(&p[i]));
    sample
}

/// What the record of a session holds, its unmodified outputs at a pose told by `readings`, metres. `floor_m` is the least noise that its
/// gate believes.
pub fn session(
    motion: Motion,
    floor_m: f64,
    seed: u64,
    mut readings: impl FnMut(RelativePose) -> [f64; 4],
) -> Calibration {
    let model = ErrorModel::zero(TermTable::equation_3());
    let regression = Regression::new(&GEOMETRY, &model).unwrap();
    let mut fit = Box::new(GatedFit::new());
    fit.reset(regression.unknowns(), floor_m as f32);
    let range = Range {
        travel_m: 10.0 * GEOMETRY.pitch_m,
        turn_rad: motion.turn_rad,
    };
    let mut planner = Planner::new(range, seed);
    let mut visit = |pose| sample(&readings(pose));
    let origin = visit(RelativePose::default());
    for _ in 0..motion.poses {
        let pose = match motion.plan {
            Plan::Random => planner.random(),
            Plan::Optimal => planner.optimal(fit.estimator(), &regression, &origin),
        };
        let seen = visit(pose);
        fit.add(&regression, &seen);
    }
    fit.review_startup(&regression);
    let worst_m = fit.worst_deviation_m(&regression);
    fit.estimator_mut().solve().unwrap();
    let innovations: Vec<f64> = (0..HELD_OUT)
        .map(|_| {
            let seen = visit(planner.random());
            f64::from(fit.innovation(&regression, &seen).unwrap().0)
        })
        .collect();
    let mean = innovations.iter().sum::<f64>() / f64::from(HELD_OUT);
    let square =
        innovations.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / f64::from(HELD_OUT - 1);
    let mut calibration = Calibration::identity(GEOMETRY);
    calibration.model = regression.model(&fit.estimator().solution().values);
    calibration.amplitude_counts = [20_000.0; 4];
    let counts = [motion.poses as u16, HELD_OUT as u16];
    calibration.poses = Some(Poses::new(motion.plan, seed, range, &origin, counts));
    let quality = &mut calibration.quality;
    (quality.residual_after_m, quality.predicted_worst_m) = (square.sqrt() as f32, worst_m);
    quality.poses = fit.estimator().rows.rows() as u16;
    quality.condition_number = fit.estimator().solution().condition;
    (quality.rank, quality.unknowns) = (
        fit.estimator().solution().rank as u16,
        regression.unknowns() as u16,
    );
    calibration
}
