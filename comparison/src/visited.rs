//! The rows of a calibration's fit, made again from the poses that its record names.
//!
//! The board's own generator and planner are run as they were told (`courier_sensor::calibration::{Planner, foreseen}`), from the start that the
//! record keeps, on a courier that has the record's own waves. Random poses come out as they were. Where each pose was chosen by what was known so
//! far (`--plan optimal`), readings with other noise now and then choose another of two that are nearly as good: these rows are not the actual
//! ones, but of the same plan over the same candidates. So that plan is run twice, with noise as large as what was left, and by how much both
//! differ tells how much the actual one does.
//!
//! With `B = W^T (V^T V)^-1 W`, V the actual rows and W a root of the products that are taken for theirs, a difference has the expected mean square, but
//! scatters more about it, as does one whose scale was measured: about as with an F distribution of f degrees of freedom with `|B - 1|^2 = n^2 / f` for n
//! unknowns (of random rows, exactly: Hotelling 1931).

use crate::phases::Phases;
use crate::rows::{self, Rows};
use courier_sensor::calibration::record::{Calibration, Poses};
use courier_sensor::calibration::{
    PLATEN_UNKNOWNS, Plan, Planner, PlatenEstimator, Regression, Sample, foreseen,
};
use nalgebra::{DMatrix, DVector};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

/// Runs of a plan that chooses. A bound on the work: the fewest that differ.
const RUNS: u64 = 2;

/// By a record and the poses that it names; none where they determine no fit.
pub fn rows(orders: &[u8], calibration: &Calibration, poses: &Poses) -> Option<Rows> {
    let regression = Regression::new(&calibration.geometry, &calibration.model)?;
    let visit = Visit::new(calibration, &regression, poses);
    let runs = match poses.plan {
        Plan::Random => 1,
        Plan::Optimal => RUNS,
    };
    let runs: Vec<Run> = (0..runs)
        .map(|number| visit.run(calibration, number))
        .collect::<Option<_>>()?;
    let mean = runs.iter().map(|run| &run.inverse).sum::<DMatrix<f64>>() / runs.len() as f64;
    let n = mean.nrows() as f64;
    // The mean is off by its own share of what the runs differ by: a mean square by its inverse is larger by that.
    let variance = between(&runs, &mean)?;
    let of_mean = variance / runs.len() as f64;
    let of_rows = (variance + of_mean) / (n * n);
    let of_scale = (f64::from(poses.held_out) - 1.0).recip();
    Some(Rows {
        per_pose: mean * (f64::from(calibration.quality.poses) * (1.0 + of_mean / n)),
        share: 1.0,
        leverage: runs.iter().map(|run| run.leverage).sum::<f64>() / runs.len() as f64,
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

/// What one visit to all poses tells.
struct Run {
    /// Inverse of the products of all rows, without the offset's row and column: the coefficients' covariance for unit noise.
    inverse: DMatrix<f64>,
    /// How much the fit's uncertainty adds to the variance of a held-out parity, for unit noise.
    leverage: f64,
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
        for (segment, of_segment) in segments.take(courier_sensor::frame::SEGMENTS).enumerate() {
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
        let of = |row: DVector<f64>| (&inverse * &row).dot(&row);
        let sum: f64 = held_out.iter().map(|sample| of(row(sample))).sum();
        Some(Run {
            leverage: sum / held_out.len() as f64,
            inverse: inverse.view((0, 0), (count - 1, count - 1)).into_owned(),
        })
    }

    /// Samples of the poses for the fit, read with noise where that has a part in the choice, and of those held out; none where there are none.
    fn samples(&self, noise_m: f32, number: u64) -> Option<[Vec<Sample>; 2]> {
        let (count, chosen) = (self.regression.unknowns(), self.poses.plan == Plan::Optimal);
        let mut planner = Planner::new(self.poses.range, self.poses.seed);
        let mut rng = ChaCha8Rng::seed_from_u64(number);
        let noise_turns = noise_m / self.regression.geometry().pitch_m;
        let there = |pose| foreseen(self.regression, &self.values, &self.start, &pose);
        let mut estimator: Box<PlatenEstimator> = Box::new(PlatenEstimator::blank());
        estimator.reset(count);
        let mut fitted = Vec::with_capacity(self.poses.visited.into());
        for _ in 0..self.poses.visited {
            if !chosen {
                fitted.push(there(planner.random()));
                continue;
            }
            let mut sample = there(planner.optimal(&estimator, self.regression, &self.start));
            for output in &mut sample.unmodified {
                let normal: f32 = StandardNormal.sample(&mut rng);
                output.fraction_turns += noise_turns * normal;
            }
            let (row, right) = self.regression.row(&sample);
            estimator.rows.enter(&row[..count], right).ok()?;
            fitted.push(sample);
        }
        let held_out = (0..self.poses.held_out).map(|_| there(planner.random()));
        let held_out: Vec<Sample> = held_out.collect();
        (!fitted.is_empty() && !held_out.is_empty()).then_some([fitted, held_out])
    }
}
