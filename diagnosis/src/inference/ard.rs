//! Prior sizes by what the recording says of them. A prior of physical size bounds an amount, and where columns nearly cancel on a
//! motion it bounds nothing: amounts that are not there run against each other, and another motion shows it. Each amount's
//! size is set to what makes the recording likeliest, so that what is not needed goes to nothing, or to its mean (automatic relevance
//! determination: MacKay 1992's update, Tipping 2001).

use crate::design::gram::{Columns, Gram};
use nalgebra::{DMatrix, DVector};
use normal_equations::cholesky::Factor;
use std::collections::BTreeMap;

/// Most columns: the cost is cubic in them. A field over the platen has more, and all its knots one size. A bound on the work: of
/// more the sizes stay the physical ones, which is the wider prior.
const MOST_COLUMNS: usize = 320;
/// Updates. What is not needed falls by a good factor in each. A bound on the work: a size that has not settled by then is too
/// large, and so nearer to the physical one.
const ARD_UPDATES: usize = 25;
/// The same of courses, whose knots are many and share one size: that is told by a few updates, and by fewer from what the round
/// before has told. A bound on the work: of more the sizes stay the physical ones, which is the wider prior.
const MOST_COURSE_COLUMNS: usize = 640;
/// Updates of courses: at first, and where the round before has told them. A bound on the work: a size that has not settled by
/// then is nearer to the physical one.
const COURSE_UPDATES: [usize; 2] = [10, 4];
/// An amount is nothing below this share of its prior size. Derived from sizes of some micrometres: a ten-thousandth of them is
/// 0.3 nm, a thousandth of the noise floor.
const NEGLIGIBLE_PRIOR_SHARE: f64 = 1.0e-4;

/// Factors that shrink the prior sizes of all but the baseline's columns, never beyond the physical ones: for [`Gram::rescale`].
/// Those that a round before has told, if there was one, lead where the knots of a course share one. Cost: 25 times the cube of the
/// columns, of courses 10 or 4 times.
pub fn factors(gram: &Gram, columns: &Columns, before: &[f64]) -> Vec<f64> {
    let first = columns.blocks[0].columns.end;
    let width = gram.width();
    let courses = columns.regressors.iter().any(|r| r.course.is_some());
    let most = if courses {
        MOST_COURSE_COLUMNS
    } else {
        MOST_COLUMNS
    };
    if width == first || width > most {
        return vec![1.0; width];
    }
    let led = courses && before.len() == width;
    let start = |c: usize| if led { before[c].powi(-2) } else { 1.0 };
    let mut precision = DVector::from_fn(width, |c, _| start(c));
    let updates = match (courses, led) {
        (false, _) => ARD_UPDATES,
        (true, led) => COURSE_UPDATES[usize::from(led)],
    };
    let sharing = sharing(columns);
    let training = gram.training(None);
    let all: Vec<usize> = (0..width).collect();
    let (normal, right) = (training.square(&all), training.right(&all));
    let rows = gram.total_rows() as f64;
    for _ in 0..updates {
        let Some((coefficients, variance)) = fitted(gram, &normal, &right, &precision) else {
            return vec![1.0; width];
        };
        // What is left beyond the noise is no evidence for small amounts.
        let left = training.at(width, width) - 2.0 * right.dot(&coefficients)
            + coefficients.dot(&(&normal * &coefficients));
        let noise = (left / rows).max(1.0);
        for group in &sharing {
            let estimate = |c: &usize| (1.0 - precision[*c] * variance[*c]).max(0.0);
            let square = |c: &usize| (coefficients[*c] - gram.centre[*c]).powi(2) / noise;
            let estimate: f64 = group.iter().map(estimate).sum();
            let square: f64 = group.iter().map(square).sum();
            let shared = (estimate / square.max(1e-30)).clamp(1.0, NEGLIGIBLE_PRIOR_SHARE.powi(-2));
            group.iter().for_each(|c| precision[*c] = shared);
        }
    }
    precision.iter().map(|p| 1.0 / p.sqrt()).collect()
}

/// Columns that share a size: the knots of a course; any other by itself. The baseline's keep theirs.
fn sharing(columns: &Columns) -> Vec<Vec<usize>> {
    let mut out = Vec::new();
    for block in &columns.blocks[1..] {
        let mut courses: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for c in block.columns.clone() {
            match columns.regressors[c].course {
                Some(course) => courses.entry(course).or_default().push(c),
                None => out.push(vec![c]),
            }
        }
        out.extend(courses.into_values());
    }
    out
}

/// Amounts with unit noise, and their variances.
fn fitted(
    gram: &Gram,
    normal: &DMatrix<f64>,
    right: &DVector<f64>,
    precision: &DVector<f64>,
) -> Option<(DVector<f64>, DVector<f64>)> {
    let mut normal = normal.clone();
    let mut right = right.clone();
    for c in 0..precision.len() {
        normal[(c, c)] += precision[c];
        right[c] += precision[c] * gram.centre[c];
    }
    let factor = Factor::new(normal)?;
    let coefficients = factor.solve(&right);
    // Of the covariance its diagonal alone is asked for: squares of the columns of the factor's inverse.
    let inverse = factor.lower_inverse();
    let variances = inverse.column_iter().map(|column| column.norm_squared());
    Some((
        coefficients,
        DVector::from_iterator(precision.len(), variances),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::folds::FOLDS;
    use crate::inference::fit::solve;
    use effects::random::{ChaCha8Rng, SeedableRng, normal};
    use effects::sensor::Regressor;
    use normal_equations::symmetric::Symmetric;

    fn columns(names: &[&str]) -> Columns {
        let mut columns = Columns::default();
        let one = |name: &&str| Regressor::channel(*name, "m", 1.0, 0, |_| 1.0);
        columns.push("baseline", names[..1].iter().map(one).collect());
        columns.push("effect", names[1..].iter().map(one).collect());
        columns
    }

    /// Two columns that hardly differ, of which the recording holds one: fitted freely they run against each other.
    #[test]
    fn what_a_recording_does_not_need_goes_to_nothing() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let columns = columns(&["constant", "there", "like it", "elsewhere"]);
        let fold: Vec<Symmetric> = (0..FOLDS)
            .map(|_| {
                let mut sum = Symmetric::zeros(5);
                for _ in 0..400 {
                    let (there, other) = (normal(&mut rng), normal(&mut rng));
                    let like = there + 0.01 * normal(&mut rng);
                    let target = 2.0 * there + normal(&mut rng);
                    let row = [1.0, there, like, other, target];
                    for (column, value) in row.iter().enumerate() {
                        let below = sum.below_mut(column).iter_mut().zip(&row[column..]);
                        below.for_each(|(sum, other)| *sum += value * other);
                    }
                }
                sum
            })
            .collect();
        let mut total = Symmetric::zeros(5);
        fold.iter().for_each(|fold| total += fold);
        let mut gram = Gram {
            total,
            fold,
            rows: vec![400; FOLDS],
            scale: vec![10.0; 4],
            centre: vec![0.0; 4],
            shrunk: vec![1.0; 4],
            overstated: false,
            loud: false,
        };
        gram.rescale(&[10.0; 4]);
        let coefficients = |gram: &Gram| {
            let fit = solve(gram.training(None), &[0, 1, 2, 3], &gram.centre, 1.0).unwrap();
            [1, 2, 3].map(|c| fit.coefficient[c] * gram.shrunk[c])
        };
        let free = coefficients(&gram);
        gram.rescale(&factors(&gram, &columns, &[]));
        let shrunk = coefficients(&gram);
        // The sum of the two is what is known.
        assert!((shrunk[0] + shrunk[1] - 2.0).abs() < 0.1, "{shrunk:?}");
        let size = |a: &[f64; 3]| a[0].abs() + a[1].abs();
        assert!(size(&shrunk) < 0.95 * size(&free), "{shrunk:?} {free:?}");
        assert!(
            shrunk[2].abs() < 0.01 * free[2].abs(),
            "{shrunk:?} {free:?}"
        );
        // The baseline's sizes stay, and none grows beyond the physical one.
        assert_eq!(gram.shrunk[0], 10.0);
        assert!(gram.shrunk.iter().all(|s| *s <= 10.0));
    }
}
