//! The rows of a calibration's fit, made again from the poses that its record names.
//!
//! The board's own generator and planner are run as they were told (`courier_sensor::calibration::Planner`), from the start that the record
//! keeps, on a courier that has the record's own waves. So random poses are the actual ones. Rows are taken where the segments read, though, and
//! readings are off by what was left: by 4 µm of displaced teeth, rows of order 6 are off by a tenth. Where each pose was chosen by what was known
//! so far (`--plan optimal`), such readings now and then choose another of two that are nearly as good, too. These rows are then not the
//! actual ones, but of the same plan over the same candidates. So the poses are visited twice, with noise as large as what was left, and by how
//! much both differ tells how much the actual rows do.
//!
//! With `B = W^T (V^T V)^-1 W`, V the actual rows and W a root of the products that are taken for theirs, a difference has the expected mean square, but
//! scatters more about it, as does one whose scale was measured: about as with an F distribution of f degrees of freedom with `|B - 1|^2 = n^2 / f` for n
//! unknowns (of random rows, exactly: Hotelling 1931).

use crate::phases::Phases;
use crate::rows::{self, Rows};
use crate::significance::held_out_freedom;
use courier_sensor::calibration::record::{Calibration, Poses};
use courier_sensor::calibration::{
    PLATEN_UNKNOWNS, Plan, Planner, PlatenEstimator, Regression, RelativePose, Sample,
};
use courier_sensor::equations::outputs;
use courier_sensor::frame::SEGMENTS;
use nalgebra::{DMatrix, DVector};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

/// Visits to all poses. A bound on the work: the fewest that differ.
const RUNS: u64 = 2;

/// By a record and the poses that it names; none where they determine no fit.
pub fn rows(orders: &[u8], calibration: &Calibration, poses: &Poses) -> Option<Rows> {
    let regression = Regression::new(&calibration.geometry, &calibration.model)?;
    let visit = Visit::new(calibration, &regression, poses);
    let runs: Vec<Run> = (0..RUNS)
        .map(|number| visit.run(calibration, number))
        .collect::<Option<_>>()?;
    let mean = runs.iter().map(|run| &run.inverse).sum::<DMatrix<f64>>() / runs.len() as f64;
    let n = mean.nrows() as f64;
    // The mean is off by its own share of what the runs differ by: a mean square by its inverse is larger by that.
    let variance = between(&runs, &mean)?;
    let of_mean = variance / runs.len() as f64;
    let of_rows = (variance + of_mean) / (n * n);
    let mean_of = |of: fn(&Run) -> f64| runs.iter().map(of).sum::<f64>() / runs.len() as f64;
    let leverage = mean_of(|run| run.leverage);
    let of_scale = held_out_freedom(
        poses.held_out.into(),
        leverage,
        mean_of(|run| run.leverage_squares),
    )
    .recip();
    Some(Rows {
        per_pose: mean * (f64::from(calibration.quality.poses) * (1.0 + of_mean / n)),
        share: 1.0,
        leverage,
        freedom: (of_rows + of_scale).recip(),
        phases: Phases::new(orders, &rows::waves(calibration)),
        difference_rad: rows::radians_per_turn(calibration) * f64::from(poses.range.turn_rad),
    })
}

/// Variance of inverses between runs, all elements together, where their mean is brought to one; zero of a single one.
fn between(runs: &[Run], mean: &DMatrix<f64>) -> Option<f64> {
    let whiten = mean.clone().cholesky()?.l().try_inverse()?;
    let one = DMatrix::identity(mean.nrows(), mean.nrows());
    let off = |run: &Run| (&whiten * &run.inverse * whiten.transpose() - &one).norm_squared();
    Some(match runs {
        [_] => 0.0,
        runs => runs.iter().map(off).sum::<f64>() / (runs.len() - 1) as f64,
    })
}

/// Halvings of what a reading may be off by. Derived from half a millimetre at the most: 2^17 steps of it are some nanometres.
const HALVINGS: u32 = 17;

/// What one visit to all poses tells.
struct Run {
    /// Inverse of the products of all rows, without the offset's row and column: the coefficients' covariance for unit noise.
    inverse: DMatrix<f64>,
    /// How much the fit's uncertainty adds to the variance of a held-out parity, for unit noise.
    leverage: f64,
    /// Sum of the squares of its shares in the fit's directions.
    leverage_squares: f64,
}

/// A courier with the record's waves that is sent to the poses again.
struct Visit<'a> {
    regression: &'a Regression,
    values: [f32; PLATEN_UNKNOWNS],
    poses: &'a Poses,
    start: Sample,
}

impl<'a> Visit<'a> {
    fn new(calibration: &Calibration, regression: &'a Regression, poses: &'a Poses) -> Self {
        let mut values = [0.0; PLATEN_UNKNOWNS];
        let model = &calibration.model;
        let all = model.terms.iter().zip(&model.coefficients);
        let fitted: Vec<_> = all.filter(|(term, _)| rows::fitted(term)).collect();
        // The offset is left zero: it moves no phase.
        let segments = values.chunks_exact_mut(regression.columns());
        for (segment, of_segment) in segments.take(SEGMENTS).enumerate() {
            for (pair, (_, rows)) in of_segment.as_chunks_mut::<2>().0.iter_mut().zip(&fitted) {
                *pair = rows[segment];
            }
        }
        Self {
            regression,
            values,
            poses,
            start: poses.start(),
        }
    }

    /// One visit to all poses; none where they determine no fit.
    fn run(&self, calibration: &Calibration, number: u64) -> Option<Run> {
        let count = self.regression.unknowns();
        // Equal shares of the four segments.
        let noise_m = 0.5 * calibration.quality.residual_after_m;
        let [fitted, held_out] = self.samples(noise_m, number)?;
        let row = |sample: &Sample| {
            let (row, _) = self.regression.row(sample);
            DVector::from_iterator(count, row[..count].iter().map(|x| f64::from(*x)))
        };
        let mut products = DMatrix::zeros(count, count);
        for sample in &fitted {
            let row = row(sample);
            products.ger(1.0, &row, &row, 1.0);
        }
        // Which poses were lost is not known: each counts a little less.
        products *= f64::from(calibration.quality.poses) / fitted.len() as f64;
        let inverse = products.cholesky()?.inverse();
        let mut held_out_products = DMatrix::zeros(count, count);
        for sample in &held_out {
            let row = row(sample);
            held_out_products.ger(1.0 / held_out.len() as f64, &row, &row, 1.0);
        }
        let shares = &inverse * held_out_products;
        Some(Run {
            leverage: shares.trace(),
            leverage_squares: (&shares * &shares).trace(),
            inverse: inverse.view((0, 0), (count - 1, count - 1)).into_owned(),
        })
    }

    /// What the segments read at a pose. The board's own look ahead at a pose that it plans (`courier_sensor::calibration::foreseen`) stops some
    /// micrometres short of that where waves are steep, and rows of order 6 are off by a tenth then.
    fn reading(&self, pose: &RelativePose) -> Sample {
        let geometry = self.regression.geometry();
        let moved = outputs([pose.x_m, pose.y_m], pose.theta_rad, geometry.span_m);
        let at_start = self.regression.corrections_m(&self.values, &self.start);
        let goal_m: [f32; SEGMENTS] = std::array::from_fn(|i| {
            geometry.pitch_m * self.start.unmodified[i].fraction_turns + moved[i] + at_start[i]
        });
        let sample = |at_m: [f32; SEGMENTS]| {
            let mut sample = self.start;
            for (output, at_m) in sample.unmodified.iter_mut().zip(at_m) {
                let turns = at_m / geometry.pitch_m;
                output.teeth = output.teeth.wrapping_add(turns.round() as i32);
                output.fraction_turns = turns - turns.round();
            }
            sample
        };
        // No wave is larger than the sum of all.
        let most_m: f32 = self.values.iter().map(|k| k.abs()).sum();
        let (mut low_m, mut high_m) = (goal_m.map(|m| m - most_m), goal_m.map(|m| m + most_m));
        for _ in 0..HALVINGS {
            let middle_m = std::array::from_fn(|i| 0.5 * (low_m[i] + high_m[i]));
            let corrections_m = self
                .regression
                .corrections_m(&self.values, &sample(middle_m));
            for i in 0..SEGMENTS {
                let short = middle_m[i] + corrections_m[i] < goal_m[i];
                *(if short { &mut low_m[i] } else { &mut high_m[i] }) = middle_m[i];
            }
        }
        sample(low_m)
    }

    /// Samples of the poses for the fit, read with noise, and of those held out; none where there are none.
    fn samples(&self, noise_m: f32, number: u64) -> Option<[Vec<Sample>; 2]> {
        let (count, chosen) = (self.regression.unknowns(), self.poses.plan == Plan::Optimal);
        let mut planner = Planner::new(self.poses.range, self.poses.seed);
        let mut rng = ChaCha8Rng::seed_from_u64(number);
        let noise_turns = noise_m / self.regression.geometry().pitch_m;
        let there = |pose| self.reading(&pose);
        let mut estimator: Box<PlatenEstimator> = Box::new(PlatenEstimator::blank());
        estimator.reset(count);
        let mut fitted = Vec::with_capacity(self.poses.visited.into());
        for _ in 0..self.poses.visited {
            let mut sample = there(if chosen {
                planner.optimal(&estimator, self.regression, &self.start)
            } else {
                planner.random()
            });
            for output in &mut sample.unmodified {
                let normal: f32 = StandardNormal.sample(&mut rng);
                output.fraction_turns += noise_turns * normal;
            }
            if chosen {
                let (row, right) = self.regression.row(&sample);
                estimator.rows.enter(&row[..count], right).ok()?;
            }
            fitted.push(sample);
        }
        let held_out = (0..self.poses.held_out).map(|_| there(planner.random()));
        let held_out: Vec<Sample> = held_out.collect();
        (!fitted.is_empty() && !held_out.is_empty()).then_some([fitted, held_out])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use courier_sensor::calibration::{Range, foreseen};
    use courier_sensor::geometry::Geometry;

    /// Steep waves, as the paper's third segment has: what is read is off by what these correct, where the board's look ahead stops short of it.
    #[test]
    fn a_reading_is_what_the_waves_correct_to_the_place() {
        let mut calibration = rows::record();
        let model = &mut calibration.model;
        for (rows, size_um) in model
            .coefficients
            .iter_mut()
            .zip([20.0, 10.0, 8.0, 7.0_f32])
        {
            rows[2] = [1.0e-6 * size_um, 0.0];
        }
        let range = Range {
            travel_m: 10.0e-3,
            turn_rad: 8.7e-3,
        };
        let poses = Poses::new(Plan::Random, 1, range, &Sample::ZERO, [100, 10]);
        let regression = Regression::new(&Geometry::PAPER, &calibration.model).unwrap();
        let visit = Visit::new(&calibration, &regression, &poses);
        let mut planner = Planner::new(range, 1);
        let start = regression.corrections_m(&visit.values, &visit.start)[2];
        let (mut worst_m, mut worst_foreseen_m) = (0.0_f32, 0.0_f32);
        for _ in 0..100 {
            let pose = planner.random();
            let moved_m = outputs([pose.x_m, pose.y_m], pose.theta_rad, Geometry::PAPER.span_m)[2];
            let off_m = |seen: &Sample| {
                let output = &seen.unmodified[2];
                let at_m = Geometry::PAPER.pitch_m * (output.teeth as f32 + output.fraction_turns);
                (at_m + regression.corrections_m(&visit.values, seen)[2] - start - moved_m).abs()
            };
            worst_m = worst_m.max(off_m(&visit.reading(&pose)));
            worst_foreseen_m = worst_foreseen_m.max(off_m(&foreseen(
                &regression,
                &visit.values,
                &visit.start,
                &pose,
            )));
        }
        // f32 of ten millimetres, and the last halving.
        assert!(worst_m < 1.0e-8, "{worst_m:e}");
        assert!(worst_foreseen_m > 2.0e-6, "{worst_foreseen_m:e}");
    }
}
