use super::*;
use crate::posterior::scale::log_prior;
use crate::synthetic_problem::SyntheticProblem;
use effects::random::{ChaCha8Rng, SeedableRng, normal};
use nalgebra::DMatrix;

const ROWS: usize = 60;
const BASELINE: usize = 3;
const BLOCKS: [(&str, usize); 3] = [("one", 2), ("other", 3), ("shapes", 4)];

/// Columns that share a good part, and a target.
fn rows(seed: u64) -> Vec<Vec<f64>> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let width: usize = BASELINE + BLOCKS.iter().map(|b| b.1).sum::<usize>();
    let row = |_| {
        let common = normal(&mut rng);
        let mut row: Vec<f64> = (0..width)
            .map(|_| 0.6 * common + normal(&mut rng))
            .collect();
        row.push(2.0 * row[BASELINE] - row[BASELINE + 3] + normal(&mut rng));
        row
    };
    (0..ROWS).map(row).collect()
}

/// Some columns of the rows.
fn matrix(rows: &[Vec<f64>], columns: std::ops::Range<usize>) -> DMatrix<f64> {
    DMatrix::from_fn(rows.len(), columns.len(), |i, c| rows[i][columns.start + c])
}

/// Logarithm of the density of normal values with this covariance about a flat baseline: the integral of N(y; B b, C) over b.
fn dense(y: &DVector<f64>, baseline: &DMatrix<f64>, covariance: DMatrix<f64>) -> f64 {
    let n = y.len() as f64 - baseline.ncols() as f64;
    let factor = covariance.cholesky().unwrap();
    let half_log = |m: &DMatrix<f64>| m.diagonal().iter().map(|d| d.ln()).sum::<f64>();
    let (by, bb) = (factor.solve(y), factor.solve(baseline));
    let own = (baseline.transpose() * &bb).cholesky().unwrap();
    let across = baseline.tr_mul(&by);
    let squares = y.dot(&by) - across.dot(&own.solve(&across));
    -0.5 * n * TAU.ln() - half_log(&factor.l()) - half_log(&own.l()) - 0.5 * squares
}

/// The sum of all that varies: noise, and blocks with their variances.
fn covariance(noise: f64, parts: &[(&DMatrix<f64>, f64)]) -> DMatrix<f64> {
    let mut out = DMatrix::identity(ROWS, ROWS) * noise;
    for (columns, log_variance) in parts {
        out += *columns * columns.transpose() * log_variance.exp();
    }
    out
}

/// Against log N(y; X c, N + X W Xᵀ) about a flat baseline, formed with all rows.
#[test]
fn a_sets_density_is_that_of_the_whole_covariance() {
    for seed in 0..5 {
        let rows = rows(seed);
        let centre: Vec<f64> = [0.0; BASELINE]
            .into_iter()
            .chain([0.7, 0.0, 0.0, -0.4, 0.2])
            .chain([0.0; 4])
            .collect();
        let problem = SyntheticProblem::of_rows(BASELINE, &BLOCKS, &rows).about(&centre);
        let reduced = problem.reduced(&[1, 2, 3]);
        let baseline = matrix(&rows, 0..BASELINE);
        let (one, other) = (matrix(&rows, 3..5), matrix(&rows, 5..8));
        let last = rows[0].len() - 1;
        let y = matrix(&rows, last..last + 1).column(0).into_owned();
        let about = |columns: &DMatrix<f64>, means: &[f64]| {
            &y - columns * DVector::from_column_slice(means)
        };
        for (noise, sizes) in [(1.0, [0.0, 0.0]), (1.3, [-2.0, 1.5])] {
            let found = given(&reduced, &[0], &sizes[..1], noise).unwrap();
            let wanted = dense(
                &about(&one, &[0.7, 0.0]),
                &baseline,
                covariance(noise, &[(&one, sizes[0])]),
            );
            assert!(
                (found.log_density - wanted).abs() < 1e-8,
                "{} {wanted}",
                found.log_density
            );
            let both = [(&one, sizes[0]), (&other, sizes[1])];
            let found = given(&reduced, &[0, 1], &sizes, noise).unwrap();
            let means =
                about(&one, &[0.7, 0.0]) - &other * DVector::from_column_slice(&[0.0, -0.4, 0.2]);
            let wanted = dense(&means, &baseline, covariance(noise, &both));
            assert!(
                (found.log_density - wanted).abs() < 1e-8,
                "{} {wanted}",
                found.log_density
            );
            let none = given(&reduced, &[], &[], noise).unwrap();
            let wanted = dense(&y, &baseline, covariance(noise, &[]));
            assert!(
                (none.log_density - wanted).abs() < 1e-8,
                "{} {wanted}",
                none.log_density
            );
        }
    }
}

/// Shapes beside a set add to the logarithm of the density what the whole covariance says.
#[test]
fn nameless_shapes_add_what_the_whole_covariance_says() {
    let rows = rows(11);
    let reduced = SyntheticProblem::of_rows(BASELINE, &BLOCKS, &rows).reduced(&[1, 2, 3]);
    let (noise, size, of_shapes) = (1.2, 0.4, -0.5);
    let baseline = matrix(&rows, 0..BASELINE);
    let one = matrix(&rows, 3..5);
    let shapes = matrix(&rows, 8..12);
    let last = rows[0].len() - 1;
    let y = matrix(&rows, last..last + 1).column(0).into_owned();
    let wanted = dense(
        &y,
        &baseline,
        covariance(noise, &[(&one, size), (&shapes, of_shapes)]),
    );
    let eliminated = Eliminated::new(&reduced, &[0], &[size], noise).unwrap();
    let left = reduced.beside(&[0], &eliminated, &[2], noise);
    let density = |set: &[usize]| {
        given(&left, set, &[of_shapes][..set.len()], noise)
            .unwrap()
            .log_density
    };
    let alone = given(&reduced, &[0], &[size], noise).unwrap().log_density;
    let found = alone + density(&[0]) - density(&[]);
    assert!((found - wanted).abs() < 1e-8, "{found} {wanted}");
}

/// A baseline column that is a sum of others changes nothing.
#[test]
fn a_dependent_baseline_column_is_left_out() {
    let rows = rows(3);
    let doubled: Vec<Vec<f64>> = rows
        .iter()
        .map(|row| [&[row[0] - 2.0 * row[1]], &row[..]].concat())
        .collect();
    let density = |baseline: usize, rows: &[Vec<f64>]| {
        let reduced = SyntheticProblem::of_rows(baseline, &BLOCKS, rows).reduced(&[1, 2]);
        (
            given(&reduced, &[0, 1], &[0.0, 0.0], 1.0).unwrap().squares,
            reduced.baseline,
        )
    };
    let (plain, more) = (density(BASELINE, &rows), density(BASELINE + 1, &doubled));
    assert_eq!((plain.1, more.1), (BASELINE, BASELINE));
    assert!((plain.0 - more.0).abs() < 1e-8, "{plain:?} {more:?}");
}

/// One size after the other, against the sum over all sizes at once.
#[test]
fn sizes_are_integrated_over() {
    let reduced = SyntheticProblem::of_rows(BASELINE, &BLOCKS, &rows(5)).reduced(&[1, 2, 3]);
    let density = |sizes: [f64; 2]| given(&reduced, &[0, 1], &sizes, 1.0).unwrap().log_density;
    let grid: Vec<f64> = (0..90).map(|k| -12.0 + 0.2 * f64::from(k)).collect();
    let all = grid.iter().flat_map(|a| grid.iter().map(move |b| [*a, *b]));
    let values: Vec<f64> = all
        .map(|s| density(s) + log_prior(s[0]) + log_prior(s[1]))
        .collect();
    let wanted = super::super::noise_scale::log_sum(values.into_iter()) + 2.0 * 0.2_f64.ln();
    let found = fitted(&reduced, &[0, 1], &[0.0, 0.0], 1.0).unwrap();
    let told = found.given.log_density + found.log_widths;
    assert!((told - wanted).abs() < 0.5, "{told} {wanted}");
}

/// The same set has the same density, sizes, squares and told coefficients whatever axes its blocks are in; a column that no row shows is
/// left out.
#[test]
fn a_blocks_own_axes_change_nothing() {
    let mut rows = rows(8);
    rows.iter_mut().for_each(|row| row[7] = 0.0);
    let centre = [0.0, 0.0, 0.0, 0.7, 0.0, 0.0, -0.4, 0.0, 0.3, 0.0, 0.0, 0.0];
    let problem = SyntheticProblem::of_rows(BASELINE, &BLOCKS, &rows).about(&centre);
    let plain = problem.reduced(&[1, 2, 3]);
    let own = plain.clone().in_own_axes();
    assert_eq!((plain.normal.nrows(), own.normal.nrows()), (9, 8));
    for set in [&[0][..], &[1], &[0, 1], &[0, 1, 2]] {
        let start = vec![0.0; set.len()];
        let [a, b] = [&plain, &own].map(|reduced| fitted(reduced, set, &start, 1.1).unwrap());
        let told = |f: &Fitted| {
            [
                f.given.log_density,
                f.log_widths,
                f.given.squares,
                f.given.told,
            ]
        };
        for (a, b) in told(&a).into_iter().zip(told(&b)) {
            assert!((a - b).abs() < 1e-6, "{set:?}: {a} {b}");
        }
        let [a, b] = [&plain, &own].map(|r| gain(r, set, &start, (set[0] + 1) % 3, 1.1).unwrap());
        assert!(
            set.len() > 1 || (a.0 - b.0).abs() < 1e-6,
            "{set:?}: {a:?} {b:?}"
        );
    }
}

/// Amounts at thirty times their stated size: a set of both effects has sizes within what is looked at, as each alone has. Amounts beyond would make any
/// companion a reason to leave less.
#[test]
fn sizes_in_a_set_are_no_larger_than_alone() {
    let blocks = [("one", &[1.0][..]), ("other", &[1.0])];
    let problem = SyntheticProblem::new(&blocks, &|rng| {
        let (one, other, noise) = (normal(rng), normal(rng), normal(rng));
        vec![1.0, one, other, 30.0 * one + noise]
    });
    let reduced = problem.reduced(&[1, 2]);
    let alone = [0, 1].map(|b| {
        let one = fitted(&reduced, &[b], &[0.0], 1.0).unwrap();
        (one.log_variances[0], one.log_widths)
    });
    let both = roughly(&reduced, &[0, 1], &alone, 1.0).unwrap();
    let largest = scale::within(f64::INFINITY);
    assert!(
        alone[0].0 <= largest && alone[0].0 > largest - 1.0,
        "{alone:?}"
    );
    assert!(both.log_variances[0] <= largest, "{:?}", both.log_variances);
}
