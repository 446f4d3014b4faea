//! The covariance of a joint calibration by what its record keeps of it.
//!
//! The record has the noise of segments and displacements as the poses showed it, how many poses there were, how many unknowns the last
//! accepted step fitted, which tells the step, and the worst predicted deviation of a correction. Poses lie evenly about the beacon, so the
//! board's own rows (`Constraints::rows`) at poses of its planner have the products that are to be expected. How far the courier turned
//! is not in the record; the worst predicted deviation tells it.

use crate::coefficients::coefficients;
use crate::expected::HELD_OUT;
use crate::workspace::mean_square_growth;
pub use courier_sensor::calibration::joint::Unknown as Fitted;
use courier_sensor::calibration::joint::{
    Constraints, Groups, JointSolver, Layout, Priors, ReadingNoise, Values, Weighting,
    about_sensor, entered, foreseen_under_beacon, sensor::TERMS as DIODE_TERMS,
};
use courier_sensor::calibration::record::{Beacon, Calibration};
use courier_sensor::calibration::{Planner, Range, Sample};
use nalgebra::{Cholesky, DMatrix};
use std::f64::consts::TAU;

/// Poses that stand for the expectation. Derived from the scatter of their products, 1/√1000 = 3 %, which is that of a
/// calibration as well.
const POSES: u32 = 1000;
/// Noise that held-out poses show is less than the board's if it is below this share of it: by two of its own standard errors, of
/// 5 %. Derived from those two errors: a board that is no quieter is taken for one once in 44.
const LESS: f32 = 0.9;
/// Any. By definition always the same, so that the answer is.
const SEED: u64 = 1;
/// Range along x and y, pitches, unless that was asked otherwise: the record does not say. By definition that of
/// `JointConfig::default` (paper, 3.2.1).
const TRAVEL_PITCHES: f32 = 2.0;
/// Largest angles that are tried, radians. By definition those between which a joint calibration is made: refused below the one,
/// and allowed up to the other (`JointConfig::validate`).
const TURNS_RAD: [f32; 2] = [3.0e-3, 0.05];
/// Steps of the search for the angle, each half of the one before. Derived from halving: 2^-8 is 0.4 % of the range.
const STEPS: u32 = 8;
/// Points of a tooth, along and across, at which the board looks at its prediction. Derived from four a period of order 6 along,
/// and of order 2 across.
const PHASES: [usize; 2] = [24, 8];
/// The worst deviation is that of poses that were drawn, and of the step that was tried last: it may be off by this share from any that a
/// turn gives.
const FITS: f64 = 0.3;

/// Height and lever arm.
pub const LENGTHS: [Fitted; 3] = [Fitted::Height, Fitted::Lever(0), Fitted::Lever(1)];

/// The diode's own errors, in the order of a record's `beacon.sensor`.
pub fn sensor_unknowns() -> impl Iterator<Item = Fitted> {
    let terms = DIODE_TERMS.len();
    let further =
        (0..2).flat_map(move |axis| (0..terms).map(move |term| Fitted::Nonlinearity(axis, term)));
    [Fitted::GainDifference, Fitted::Turn]
        .into_iter()
        .chain(further)
}

/// What a record tells of its joint fit.
#[derive(Clone, Debug)]
pub struct JointDesign {
    /// The unknowns that were fitted.
    pub unknowns: Vec<Fitted>,
    /// Their covariance, in products of their units.
    pub covariance: DMatrix<f64>,
    /// Degrees of freedom of the noise.
    pub freedom: f64,
    /// Poses, noise and turn, for people.
    pub source: String,
}

/// By a joint calibration's record.
///
/// # Errors
/// Why it cannot be told.
pub fn of(calibration: &Calibration) -> Result<JointDesign, String> {
    let beacon = calibration
        .beacon
        .as_ref()
        .ok_or("it has no beacon, and a joint calibration has one")?;
    let quality = &calibration.quality;
    if quality.poses == 0 || !(beacon.segment_sd_m > 0.0) || !(beacon.displacement_sd_m > 0.0) {
        return Err("it was not made by a self-calibration".into());
    }
    let mut problem = Problem::new(calibration, beacon)?;
    let worst_m = f64::from(quality.predicted_worst_m);
    let (mut low, mut high) = (TURNS_RAD[0], TURNS_RAD[1]);
    let mut step = high - low;
    for _ in 0..STEPS {
        step *= 0.5;
        let middle = low + step;
        // The further it turned, the better the coefficients are known.
        match problem.covariance(middle) {
            Some(covariance) if problem.worst_m(&covariance) <= worst_m => high = middle,
            _ => low = middle,
        }
    }
    let turn_rad = 0.5 * (low + high);
    let covariance = problem
        .covariance(turn_rad)
        .ok_or("its unknowns are not told by any turn")?;
    let found_m = problem.worst_m(&covariance);
    if !((found_m / worst_m - 1.0).abs() <= FITS) {
        return Err(format!(
            "its predicted deviation of {worst_m:e} m fits no turn, whose is {found_m:e} m"
        ));
    }
    // The board weighs by no less than the noise that was stated; its held-out poses may have shown less.
    let shown_m = shown_m(calibration);
    let segment_m = if shown_m < LESS * beacon.segment_sd_m {
        shown_m
    } else {
        beacon.segment_sd_m
    };
    problem.constraints.noise.segment_m = segment_m;
    let covariance = problem.covariance(turn_rad).unwrap_or(covariance);
    let (poses, count) = (f64::from(quality.poses), problem.free.len() as f64);
    // Random rows, three a pose: the expected inverse of their products is that of the expected products, times this (Wishart 1928).
    let scatter = 3.0 * poses / (3.0 * poses - count - 1.0).max(1.0);
    Ok(JointDesign {
        unknowns: problem
            .free
            .iter()
            .map(|&index| problem.constraints.layout.unknown(index))
            .collect(),
        covariance: scatter * covariance,
        freedom: (poses - count).clamp(1.0, HELD_OUT - 1.0),
        source: format!(
            "by the record: {} poses under the beacon, {:.3} µm noise of a segment, {:.3} µm of a displacement, turned by ±{:.1}° as the predicted deviation tells",
            quality.poses,
            1.0e6 * segment_m,
            1.0e6 * beacon.displacement_sd_m,
            turn_rad.to_degrees()
        ),
    })
}

/// The noise of a segment by the parity of held-out poses, metres; infinite where none is kept.
fn shown_m(calibration: &Calibration) -> f32 {
    let left_m = calibration.quality.residual_after_m;
    let (unknowns, values) = coefficients(calibration);
    let growth = mean_square_growth(&unknowns, &values, &calibration.geometry);
    let square = growth.iter().sum::<f64>();
    if left_m > 0.0 {
        left_m / square.sqrt() as f32
    } else {
        f32::INFINITY
    }
}

/// The rows of a joint fit, before anything moves.
struct Problem {
    constraints: Constraints,
    values: Values,
    free: Vec<usize>,
    /// Inverse variances of the priors.
    priors: Vec<f64>,
    poses: f64,
}

impl Problem {
    fn new(calibration: &Calibration, beacon: &Beacon) -> Result<Self, String> {
        let layout = Layout::new(&calibration.model)
            .ok_or("its terms are not those of a joint calibration")?;
        let noise = ReadingNoise {
            segment_m: beacon.segment_sd_m,
            displacement_m: beacon.displacement_sd_m,
        };
        let constraints = Constraints {
            geometry: calibration.geometry,
            layout,
            noise,
            stated_noise: noise,
            weighting: Weighting::Covariance,
        };
        let layout = &constraints.layout;
        let unknowns = usize::from(calibration.quality.unknowns);
        let groups = steps()
            .into_iter()
            .find(|groups| layout.free(*groups).len() == unknowns);
        let Some(groups) = groups else {
            return Err(format!(
                "{unknowns} unknowns were fitted last: not platen and coordination sensor together"
            ));
        };
        let mut values = entered(layout, &calibration.model, &calibration.geometry);
        let sensor =
            (0..layout.len()).filter(|&index| Groups::SENSOR.contains(layout.group(index)));
        for (index, value) in sensor.zip(&beacon.sensor) {
            values[index] = *value;
        }
        let free: Vec<usize> = layout
            .free(groups)
            .iter()
            .map(|&index| index.into())
            .collect();
        let mut solver = Box::new(JointSolver::new());
        solver.set_priors(&constraints, &values, &Priors::default());
        let priors = free
            .iter()
            .map(|&index| f64::from(solver.prior_deviation(index)).powi(-2))
            .collect();
        Ok(Self {
            free,
            priors,
            poses: f64::from(calibration.quality.poses),
            values,
            constraints,
        })
    }

    /// Covariance of the free unknowns by poses turned up to an angle; none where these and the priors do not tell all.
    fn covariance(&self, turn_rad: f32) -> Option<DMatrix<f64>> {
        let n = self.free.len();
        let geometry = &self.constraints.geometry;
        let travel_m = TRAVEL_PITCHES * geometry.pitch_m;
        let mut planner = Planner::new(Range { travel_m, turn_rad }, SEED);
        let share = (self.poses / f64::from(POSES)).sqrt();
        let mut rows = Vec::with_capacity(3 * POSES as usize * n);
        for _ in 0..POSES {
            let pose = about_sensor(geometry.lever_m, planner.centred(false));
            let sample =
                foreseen_under_beacon(&self.constraints, &self.values, &Sample::ZERO, &pose);
            for row in self.constraints.rows(&self.values, &sample).jacobian {
                rows.extend(self.free.iter().map(|&index| share * f64::from(row[index])));
            }
        }
        let rows = DMatrix::from_row_slice(3 * POSES as usize, n, &rows);
        let mut products = rows.tr_mul(&rows);
        for (k, prior) in self.priors.iter().enumerate() {
            products[(k, k)] += prior;
        }
        // In units of each unknown's own length: lengths and shares are far apart.
        let lengths: Vec<f64> = products
            .diagonal()
            .iter()
            .map(|square| square.sqrt())
            .collect();
        let scaled = DMatrix::from_fn(n, n, |a, b| products[(a, b)] / (lengths[a] * lengths[b]));
        let inverse = Cholesky::new(scaled)?.inverse();
        Some(DMatrix::from_fn(n, n, |a, b| {
            inverse[(a, b)] / (lengths[a] * lengths[b])
        }))
    }

    /// The largest predicted deviation of a segment's correction, metres, as `JointSolver::worst_deviation_m` has it.
    fn worst_m(&self, covariance: &DMatrix<f64>) -> f64 {
        let layout = &self.constraints.layout;
        let mut worst: f64 = 0.0;
        for segment in 0..4 {
            let own: Vec<(usize, _, usize)> = self
                .free
                .iter()
                .enumerate()
                .filter_map(|(place, &index)| match layout.unknown(index) {
                    Fitted::Coefficient {
                        segment: of,
                        term,
                        part,
                    } if of == segment && term.theta_power == 0 => Some((place, term, part)),
                    _ => None,
                })
                .collect();
            for step in 0..PHASES[0] * PHASES[1] {
                let along = (step / PHASES[1]) as f64 / PHASES[0] as f64;
                let across = (step % PHASES[1]) as f64 / PHASES[1] as f64;
                let functional: Vec<(usize, f64)> = own
                    .iter()
                    .map(|(place, term, part)| {
                        let turns = along * f64::from(term.own_order)
                            + across * f64::from(term.lateral_order);
                        let (sine, cosine) = (TAU * turns).sin_cos();
                        (*place, [sine, cosine][*part])
                    })
                    .collect();
                let pairs = functional
                    .iter()
                    .flat_map(|a| functional.iter().map(move |b| (a, b)));
                worst = worst.max(pairs.map(|(a, b)| a.1 * covariance[(a.0, b.0)] * b.1).sum());
            }
        }
        worst.sqrt()
    }
}

/// What the steps fit that fit the platen together with the coordination sensor.
fn steps() -> [Groups; 4] {
    let both = Groups::PAPER | Groups::MISALIGNMENT;
    [
        Groups::PAPER,
        both,
        Groups::PAPER | Groups::NONLINEARITY,
        both | Groups::NONLINEARITY,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use courier_sensor::geometry::Geometry;
    use courier_sensor::model::{ErrorModel, TermTable};

    fn record() -> Calibration {
        let mut calibration = Calibration::identity(Geometry::PAPER);
        calibration.model = ErrorModel::zero(TermTable::equation_9());
        let (segment_sd_m, displacement_sd_m) = (1.0e-6, 1.0e-6);
        calibration.beacon = Some(Beacon {
            segment_sd_m,
            displacement_sd_m,
            ..Beacon::default()
        });
        let quality = &mut calibration.quality;
        (quality.poses, quality.unknowns, quality.rank) = (1000, 47, 47);
        quality.predicted_worst_m = 0.18e-6;
        calibration
    }

    /// The paper's synthetic problem: 1 µm of noise, 1000 poses, ±1.5°. The angle is known by the span to 1 µm / 9.7 mm, and the lever arm of
    /// 90 mm to that over 15.1 mrad rms and the root of the poses: 19.4 µm.
    #[test]
    fn the_paper_s_motion_knows_the_lever_arm_as_derived() {
        let calibration = record();
        let problem = Problem::new(&calibration, calibration.beacon.as_ref().unwrap()).unwrap();
        let covariance = problem.covariance(26.18e-3).unwrap();
        let of = |wanted: Fitted| {
            let layout = &problem.constraints.layout;
            let place = problem
                .free
                .iter()
                .position(|&k| layout.unknown(k) == wanted)
                .unwrap();
            covariance[(place, place)].sqrt()
        };
        let lever_m = of(Fitted::Lever(0));
        assert!((18.0e-6..21.0e-6).contains(&lever_m), "{lever_m:e}");
        // The turn is found again by the worst deviation alone.
        let mut calibration = record();
        calibration.quality.predicted_worst_m = problem.worst_m(&covariance) as f32;
        let design = super::of(&calibration).unwrap();
        assert!(design.source.contains("±1.5°"), "{}", design.source);
    }

    #[test]
    fn a_record_that_tells_none_is_named() {
        let told = |change: fn(&mut Calibration)| {
            let mut calibration = record();
            change(&mut calibration);
            of(&calibration).err().unwrap_or_default()
        };
        assert_eq!(told(|_| ()), "");
        assert!(told(|c| c.beacon = None).contains("no beacon"));
        assert!(told(|c| c.quality.poses = 0).contains("not made by"));
        assert!(told(|c| c.quality.unknowns = 5).contains("5 unknowns were fitted last"));
        assert!(told(|c| c.quality.predicted_worst_m = 9.0e-6).contains("fits no turn"));
        assert!(told(|c| c.model = ErrorModel::zero(TermTable::default())).contains("terms"));
    }
}
