//! The rows of a calibration's fit, made again from the poses that its record names.
//!
//! The board's own generator and planner are run as they were told (`courier_sensor::calibration::Planner`), from the start that the record
//! keeps, on a courier that has the record's own waves. So random poses are the actual ones. Rows are taken where the segments read, though, and
//! readings are off by what was left, and by as much that both segments of a pair share and no parity tells: by 4 µm of displaced teeth, rows of order 6
//! are off by a tenth. Where each pose was chosen by what was known so far (`--plan optimal`), such readings now and then choose another of two that are
//! nearly as good, too. These rows are then not the actual ones, but of the same plan over the same candidates. So the poses are visited twice, with noise as large as that, and by how
//! much both differ tells how much the actual rows do.
//!
//! With `B = W^T (V^T V)^-1 W`, V the actual rows and W a root of the products that are taken for theirs, a difference has the expected mean square, but
//! scatters more about it, as does one whose scale was measured: about as with an F distribution of f degrees of freedom with `|B - 1|^2 = n^2 / f` for n
//! unknowns (of random rows, exactly: Hotelling 1931).

use crate::lateral::{self, Lateral};
use crate::phases::Phases;
use crate::rows::{self, Rows};
use crate::significance::held_out_freedom;
use courier_sensor::calibration::record::{Calibration, Poses};
use courier_sensor::calibration::{
    PLATEN_UNKNOWNS, Plan, Planner, PlatenEstimator, Regression, RelativePose, Sample,
};
use courier_sensor::equations::{outputs, theta};
use courier_sensor::frame::SEGMENTS;
use nalgebra::{DMatrix, DVector};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};

/// Visits to all poses. A bound on the work: the fewest that differ.
const RUNS: u64 = 2;

/// What both segments of a pair are off by, over what the parity is left with: 6.5 µm of position and 5.5 µm of residual in one fly-by (paper, 3.1.2).
const SHARED: f32 = 6.5 / 5.5;

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
        lateral: runs.into_iter().next().map(|run| run.lateral),
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
    /// What lateral terms make of it.
    lateral: Lateral,
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
        let [fitted, held_out] = self.samples(calibration.quality.residual_after_m, number)?;
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
        let leverage = shares.trace();
        let rows = |samples: &[Sample]| {
            let of = |sample| (row(sample), self.lateral(sample));
            samples.iter().map(of).collect::<Vec<_>>()
        };
        Some(Run {
            leverage,
            leverage_squares: (&shares * &shares).trace(),
            lateral: Lateral::of(&inverse, &rows(&fitted), &rows(&held_out), 1.0 + leverage),
            inverse: inverse.view((0, 0), (count - 1, count - 1)).into_owned(),
        })
    }

    /// Lateral terms in the parity at a sample, which lies from the start as it reads.
    fn lateral(&self, sample: &Sample) -> DVector<f64> {
        let geometry = self.regression.geometry();
        let span_m = f64::from(geometry.span_m);
        let [here_m, start_m] = [sample, &self.start].map(|of| self.places_m(of));
        let theta_rad = theta(&here_m, span_m) - theta(&start_m, span_m);
        // Segments of a pair begin at the same tooth: whole teeth are not in the record.
        let pitch_m = f64::from(geometry.pitch_m);
        let teeth = |i: usize| match i {
            0 | 1 => 0.0,
            i => ((start_m[i] - start_m[i - 2]) / pitch_m).round(),
        };
        let places_m = std::array::from_fn(|i| here_m[i] - teeth(i) * pitch_m);
        DVector::from_row_slice(&lateral::waves(geometry, places_m, theta_rad))
    }

    /// Places of the segments along themselves, metres.
    fn places_m(&self, sample: &Sample) -> [f64; SEGMENTS] {
        let corrections_m = self.regression.corrections_m(&self.values, sample);
        std::array::from_fn(|i| {
            let output = &sample.unmodified[i];
            let turns = f64::from(output.teeth) + f64::from(output.fraction_turns);
            f64::from(self.regression.geometry().pitch_m) * turns + f64::from(corrections_m[i])
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

    /// Samples of the poses for the fit, read with noise that leaves so much in the parity, and of those held out; none where there are none.
    fn samples(&self, left_m: f32, number: u64) -> Option<[Vec<Sample>; 2]> {
        let (count, chosen) = (self.regression.unknowns(), self.poses.plan == Plan::Optimal);
        let mut planner = Planner::new(self.poses.range, self.poses.seed);
        let mut rng = ChaCha8Rng::seed_from_u64(number);
        let left_turns = left_m / self.regression.geometry().pitch_m;
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
            let mut normal = || -> f32 { StandardNormal.sample(&mut rng) };
            let of_pairs = [0, 1].map(|_| SHARED * normal());
            for (output, of_pair) in sample.unmodified.iter_mut().zip(of_pairs.iter().cycle()) {
                // Of the parity the four segments have equal shares.
                output.fraction_turns += left_turns * (of_pair + 0.5 * normal());
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

    /// Steep waves, and a start where one segment of each pair is across the middle between two teeth, so that their fractions are apart by one.
    #[test]
    fn lateral_terms_are_those_of_the_pose() {
        let mut calibration = rows::record();
        calibration.model.coefficients[0][2] = [20.0e-6, 0.0];
        let mut origin = Sample::ZERO;
        for (output, fraction_turns) in origin.unmodified.iter_mut().zip([0.48, -0.3, -0.5, -0.3]) {
            output.fraction_turns = fraction_turns;
        }
        let range = Range {
            travel_m: 10.0e-3,
            turn_rad: 8.7e-3,
        };
        let poses = Poses::new(Plan::Random, 1, range, &origin, [100, 10]);
        let regression = Regression::new(&Geometry::PAPER, &calibration.model).unwrap();
        let visit = Visit::new(&calibration, &regression, &poses);
        let pitch_m = f64::from(Geometry::PAPER.pitch_m);
        let mut start_m = visit.places_m(&visit.start);
        start_m[2] += pitch_m;
        let mut planner = Planner::new(range, 1);
        for _ in 0..20 {
            let pose = planner.random();
            let [x_m, y_m, theta_rad, span_m] =
                [pose.x_m, pose.y_m, pose.theta_rad, Geometry::PAPER.span_m].map(f64::from);
            let moved_m = outputs([x_m, y_m], theta_rad, span_m);
            let places_m = std::array::from_fn(|i| start_m[i] + moved_m[i]);
            let wanted = lateral::waves(&Geometry::PAPER, places_m, theta_rad);
            let found = visit.lateral(&visit.reading(&pose));
            let off = found.iter().zip(wanted).map(|(a, b)| (a - b).abs());
            // 10 nm of a pitch, times order 3 and its size.
            assert!(off.fold(0.0, f64::max) < 1.0e-3, "{found} {wanted:?}");
        }
    }
}
