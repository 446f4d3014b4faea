//! A straight line through several estimates: generalized least squares with each one's covariance (Aitken 1935).

use crate::difference::{covariance, values};
use crate::distribution::effective_freedom;
use crate::estimate::{Certainty, Estimate, Unknown};
use crate::significance::{JointTest, Root, Scale};
use nalgebra::{DMatrix, DVector};

/// What the line is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Over {
    /// Days, where every estimate has its time.
    Days,
    /// The order in which they are given.
    Order,
}

impl Over {
    /// One of it.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::Days => "day",
            Self::Order => "step",
        }
    }
}

/// The line.
#[derive(Clone, Debug)]
pub struct Trend {
    /// What it is over.
    pub over: Over,
    /// Where each estimate is on it: days from the first, or 0, 1, 2 and so on.
    pub at: Vec<f64>,
    /// Unknowns that every estimate has estimated.
    pub unknowns: Vec<Unknown>,
    /// Slope of each, its unit a day or a step.
    pub slope: DVector<f64>,
    /// Covariance of the slopes, raised where the estimates stray.
    pub certainty: Certainty,
    /// Whether there is a slope at all.
    pub slope_test: JointTest,
    /// Whether estimates stray from the line more than their covariances allow.
    pub straying: JointTest,
    /// By how much the slopes' ± are raised for that: the Birge ratio (Birge 1932, Physical Review 40, 207), not below one.
    pub raised: f64,
}

/// Seconds in a day, by definition 24 hours of 3,600.
const DAY_S: f64 = 86_400.0;

/// Of three estimates or more, in the order given.
///
/// # Errors
/// Too few, one without a covariance, or nothing that all have estimated.
pub fn trend(estimates: &[Estimate]) -> Result<Trend, String> {
    if estimates.len() < 3 {
        return Err(format!(
            "{} calibrations, wanted 3 or more for a trend",
            estimates.len()
        ));
    }
    let (certainties, unknowns) = shared(estimates)?;
    let (over, at) = places(estimates);
    let lines = Lines::new(estimates, &certainties, &unknowns, &at);
    let freedom = effective_freedom(certainties.iter().map(|of| (1.0, of.freedom)));
    let straying = lines.straying(freedom, 2);
    let raised = straying.mean_square.max(1.0).sqrt();
    let slope_covariance = raised * raised * lines.covariance_of_slopes();
    // What was raised is known as well as the straying is.
    let known = if raised > 1.0 {
        straying.directions as f64
    } else {
        f64::INFINITY
    };
    let freedom = freedom.min(known);
    let slope_test = Root::of(&slope_covariance).test(&lines.slope, Scale::apart(freedom));
    Ok(Trend {
        over,
        slope_test,
        straying,
        raised,
        slope: lines.slope,
        certainty: Certainty {
            covariance: slope_covariance,
            freedom,
            own: 0.0,
            lateral: None,
            source: String::new(),
        },
        unknowns,
        at,
    })
}

/// How far estimates of one state scatter about their mean, in their own deviations: about one where their covariances are right.
///
/// # Errors
/// Fewer than two, one without a covariance, or nothing that all have estimated.
pub fn scatter(estimates: &[Estimate]) -> Result<JointTest, String> {
    if estimates.len() < 2 {
        return Err(format!("{} repeats, wanted 2 or more", estimates.len()));
    }
    let (certainties, unknowns) = shared(estimates)?;
    let lines = Lines::new(
        estimates,
        &certainties,
        &unknowns,
        &vec![0.0; estimates.len()],
    );
    let freedom = effective_freedom(certainties.iter().map(|of| (1.0, of.freedom)));
    Ok(lines.straying(freedom, 1))
}

/// Each one's covariance, and the unknowns that all have estimated.
fn shared(estimates: &[Estimate]) -> Result<(Vec<&Certainty>, Vec<Unknown>), String> {
    let known = |of: &'_ Estimate| {
        of.certainty
            .as_ref()
            .map_err(|why| format!("{}: {why}", of.name))
            .map(|_| ())
    };
    estimates.iter().try_for_each(known)?;
    let certainties = estimates
        .iter()
        .filter_map(|of| of.certainty.as_ref().ok())
        .collect();
    let unknowns = common(estimates);
    if unknowns.is_empty() {
        return Err("no unknown that all calibrations have estimated".into());
    }
    Ok((certainties, unknowns))
}

/// Unknowns that every estimate has estimated.
fn common(estimates: &[Estimate]) -> Vec<Unknown> {
    let has = |estimate: &Estimate, unknown: &Unknown| {
        (0..estimate.unknowns.len())
            .any(|k| estimate.unknowns[k].is(unknown) && estimate.is_estimated(k))
    };
    let all = estimates[0]
        .unknowns
        .iter()
        .filter(|unknown| estimates.iter().all(|of| has(of, unknown)));
    all.cloned().collect()
}

/// Where each estimate is: by its time where all have one and these are not all the same.
fn places(estimates: &[Estimate]) -> (Over, Vec<f64>) {
    let times: Option<Vec<f64>> = estimates.iter().map(|of| of.made_s).collect();
    match times {
        Some(times) if times.iter().any(|time| *time != times[0]) => (
            Over::Days,
            times.iter().map(|time| (time - times[0]) / DAY_S).collect(),
        ),
        _ => (
            Over::Order,
            (0..estimates.len()).map(|k| k as f64).collect(),
        ),
    }
}

/// The fit: for each estimate its values, the inverse of its covariance, and its place.
struct Lines {
    parts: Vec<(DVector<f64>, DMatrix<f64>, f64)>,
    /// Pseudo-inverse of the normal equations, by the middle and the slope, in units of each estimate's own deviation.
    inverse: DMatrix<f64>,
    middle: DVector<f64>,
    slope: DVector<f64>,
    directions: usize,
}

impl Lines {
    fn new(
        estimates: &[Estimate],
        certainties: &[&Certainty],
        unknowns: &[Unknown],
        at: &[f64],
    ) -> Self {
        let n = unknowns.len();
        let mean = at.iter().sum::<f64>() / at.len() as f64;
        let mut directions = 0;
        let parts: Vec<(DVector<f64>, DMatrix<f64>, f64)> = estimates
            .iter()
            .zip(certainties)
            .zip(at)
            .map(|((estimate, certainty), at)| {
                let root = Root::of(&covariance(certainty, estimate, unknowns));
                directions += root.rank();
                (
                    values(estimate, unknowns),
                    root.inverse.transpose() * &root.inverse,
                    at - mean,
                )
            })
            .collect();
        let (mut normal, mut right) = (DMatrix::zeros(2 * n, 2 * n), DVector::zeros(2 * n));
        for (values, weight, at) in &parts {
            let weighted = weight * values;
            for (row, factor) in [(0, 1.0), (n, *at)] {
                let mut rows = right.rows_mut(row, n);
                rows += factor * &weighted;
                for (column, other) in [(0, 1.0), (n, *at)] {
                    let mut block = normal.view_mut((row, column), (n, n));
                    block += factor * other * weight;
                }
            }
        }
        // The pseudo-inverse of a symmetric matrix is its own roots' product.
        let root = Root::of(&normal);
        let inverse = root.inverse.transpose() * &root.inverse;
        let solution = &inverse * right;
        Self {
            middle: solution.rows(0, n).into_owned(),
            slope: solution.rows(n, n).into_owned(),
            parts,
            inverse,
            directions,
        }
    }

    fn covariance_of_slopes(&self) -> DMatrix<f64> {
        let n = self.slope.len();
        let block = self.inverse.view((n, n), (n, n)).into_owned();
        0.5 * (&block + block.transpose())
    }

    /// What estimates leave beside the line, over the directions that it has not taken: of as many estimates as it has `points` that fix it.
    fn straying(&self, freedom: f64, points: usize) -> JointTest {
        let left = |(values, weight, at): &(DVector<f64>, DMatrix<f64>, f64)| {
            let off = values - &self.middle - *at * &self.slope;
            (off.transpose() * weight * &off)[(0, 0)]
        };
        let square: f64 = self.parts.iter().map(left).sum();
        let line = points * self.directions / self.parts.len();
        let directions = self.directions.saturating_sub(line);
        let mean_square = square / directions.max(1) as f64;
        JointTest {
            mean_square,
            directions,
            unknowns: self.slope.len(),
            freedom: freedom.is_finite().then_some(freedom),
            chance: crate::distribution::chance_of_mean_square(mean_square, directions, freedom),
            convention_differs: false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::difference::tests::of_order;

    fn series(values_m: &[f64]) -> Vec<Estimate> {
        let one = |(k, value): (usize, &f64)| Estimate {
            made_s: Some(DAY_S * 2.0 * k as f64),
            ..of_order(1, [*value, 0.0], 0.1e-6)
        };
        values_m.iter().enumerate().map(one).collect()
    }

    /// Four points at 0, 2, 4, 6 days: the deviation of a slope is 0.1 µm over the root of 20 days squared.
    #[test]
    fn the_slope_and_its_deviation_are_those_of_a_line() {
        let trend = trend(&series(&[1.0e-6, 2.0e-6, 3.0e-6, 4.0e-6])).unwrap();
        assert_eq!(
            (trend.over, trend.at.as_slice()),
            (Over::Days, &[0.0, 2.0, 4.0, 6.0][..])
        );
        assert!(
            (trend.slope[0] / 0.5e-6 - 1.0).abs() < 1.0e-9,
            "{}",
            trend.slope
        );
        let deviation = trend.certainty.covariance[(0, 0)].sqrt();
        assert!(
            (deviation / (0.1e-6 / 20.0_f64.sqrt()) - 1.0).abs() < 1.0e-9,
            "{deviation:e}"
        );
        assert!(
            trend.slope_test.chance < 1.0e-6 && trend.straying.mean_square < 1.0e-9,
            "{trend:?}"
        );
        assert_eq!(
            (trend.slope_test.directions, trend.straying.directions),
            (2, 4)
        );
    }

    #[test]
    fn what_strays_from_a_line_is_told() {
        let trend = trend(&series(&[0.0, 3.0e-6, 0.0, 3.0e-6])).unwrap();
        assert!(trend.straying.chance < 1.0e-6, "{trend:?}");
        // 0, 3, 0 and 3 µm leave 7.2 µm² beside their line, of 0.01 µm² each, in two of the four directions left.
        assert!(
            (trend.raised / (720.0_f64 / 4.0).sqrt() - 1.0).abs() < 1.0e-6,
            "{trend:?}"
        );
        let deviation = trend.certainty.covariance[(0, 0)].sqrt();
        let alone = 0.1e-6 / 20.0_f64.sqrt();
        assert!(
            (deviation / (trend.raised * alone) - 1.0).abs() < 1.0e-9,
            "{deviation:e}"
        );
    }

    #[test]
    fn a_series_without_times_goes_by_its_order() {
        let mut list = series(&[1.0e-6, 2.0e-6, 3.0e-6]);
        list[1].made_s = None;
        let trend = trend(&list).unwrap();
        assert_eq!(
            (trend.over, trend.at.as_slice()),
            (Over::Order, &[0.0, 1.0, 2.0][..])
        );
        assert!((trend.slope[0] / 1.0e-6 - 1.0).abs() < 1.0e-9);
    }

    /// Means of 1 µm and zero: 2 µm² beside them, of 0.01 µm² each, over four directions.
    #[test]
    fn repeats_scatter_about_their_mean() {
        let test = scatter(&series(&[0.0, 1.0e-6, 2.0e-6])).unwrap();
        assert_eq!(test.directions, 4);
        assert!((test.mean_square / 50.0 - 1.0).abs() < 1.0e-6, "{test:?}");
        assert!(scatter(&series(&[0.0])).unwrap_err().contains("1 repeats"));
    }

    #[test]
    fn what_gives_no_trend_is_named() {
        assert!(
            trend(&series(&[1.0, 2.0]))
                .unwrap_err()
                .contains("2 calibrations")
        );
        let mut list = series(&[1.0, 2.0, 3.0]);
        list[2].certainty = Err("unknown".into());
        assert!(trend(&list).unwrap_err().contains("order 1: unknown"));
        let apart = [
            of_order(1, [0.0; 2], 1.0),
            of_order(2, [0.0; 2], 1.0),
            of_order(1, [0.0; 2], 1.0),
        ];
        assert!(trend(&apart).unwrap_err().contains("no unknown"));
    }
}
