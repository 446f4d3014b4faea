//! The incremental least squares against nalgebra's batch SVD in f64, and its behaviour at the ends of f32.
use courier_sensor::lsq::{Estimator, RowError, Triangle, packed_len};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng, seq::SliceRandom};
use rand_chacha::ChaCha8Rng;

const N: usize = 7;
type Small = Estimator<N, { packed_len(N) }>;
type Rows = Vec<([f32; N], f32)>;

/// Well-conditioned random rows with a known solution and noise.
fn problem(seed: u64, rows: usize, noise: f32) -> Rows {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let truth: [f32; N] = std::array::from_fn(|i| i as f32 - 2.5);
    (0..rows)
        .map(|_| {
            let row: [f32; N] = std::array::from_fn(|_| rng.random_range(-1.0..1.0));
            let exact: f32 = row.iter().zip(truth).map(|(a, x)| a * x).sum();
            (row, exact + noise * rng.random_range(-1.0..1.0f32))
        })
        .collect()
}

fn incremental(rows: &Rows) -> Small {
    let mut estimator = Small::new(N);
    for (row, rhs) in rows {
        estimator.rows.enter(row, *rhs).unwrap();
    }
    estimator.solve().unwrap();
    estimator
}

fn matrix(rows: &Rows) -> (DMatrix<f64>, DVector<f64>) {
    let a = DMatrix::from_fn(rows.len(), N, |i, j| f64::from(rows[i].0[j]));
    (a, DVector::from_fn(rows.len(), |i, _| f64::from(rows[i].1)))
}

fn relative(a: f32, b: f64) -> f64 {
    (f64::from(a) - b).abs() / b.abs()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn incremental_is_batch_is_permuted(seed: u64, count in 12usize..200) {
        let mut rows = problem(seed, count, 0.1);
        let (a, b) = matrix(&rows);
        let svd = a.clone().svd(true, true);
        let x = svd.solve(&b, 0.0).unwrap();
        let residual = (&a * &x - &b).norm();
        let covariance = (a.transpose() * &a).try_inverse().unwrap();
        let condition = svd.singular_values.max() / svd.singular_values.min();
        for _ in 0..2 {
            let estimator = incremental(&rows);
            let s = estimator.solution();
            prop_assert_eq!(s.rank, N);
            // f32's rounding, a random walk over the rows, magnified by the condition number.
            let rounding = f64::from(f32::EPSILON) * (count as f64).sqrt() * condition * x.norm();
            for i in 0..N {
                prop_assert!((f64::from(s.values[i]) - x[i]).abs() < rounding, "{:?} {}", s.values, x);
                prop_assert!(relative(estimator.covariance(i, i), covariance[(i, i)]) < 1e-3);
                let expected = covariance[(i, i)].sqrt() * residual / ((count - N) as f64).sqrt();
                prop_assert!(relative(s.deviations[i], expected) < 1e-3);
            }
            prop_assert!((f64::from(estimator.covariance(0, 3)) - covariance[(0, 3)]).abs() < 1e-3 * covariance[(0, 0)]);
            prop_assert!(relative(estimator.rows.residual_norm(), residual) < 1e-3);
            prop_assert!(relative(s.condition, condition) < 0.02, "{} {condition}", s.condition);
            rows.shuffle(&mut ChaCha8Rng::seed_from_u64(seed ^ 1));
        }
    }

    #[test]
    fn scale_does_not_matter(seed: u64, row_exponent in -120i32..120, apart in -120i32..120) {
        let rows = problem(seed, 60, 0.1);
        let rhs_exponent = (row_exponent + apart).clamp(-120, 120); // keeps the solution inside f32
        let (by, rhs_by) = (2f32.powi(row_exponent), 2f32.powi(rhs_exponent));
        let scaled: Rows = rows.iter().map(|(row, rhs)| (row.map(|x| x * by), rhs * rhs_by)).collect();
        let (plain, extreme) = (incremental(&rows), incremental(&scaled));
        let back = f64::from(by) / f64::from(rhs_by);
        prop_assert_eq!(extreme.solution().rank, N);
        prop_assert!(relative(extreme.solution().condition, plain.solution().condition.into()) < 1e-3);
        for i in 0..N {
            let value = f64::from(extreme.solution().values[i]) * back;
            // Where the solution itself is below f32's normal range, only its absolute size can be right.
            let grain = f64::from(f32::MIN_POSITIVE) * 1e-6 * back;
            prop_assert!((value - f64::from(plain.solution().values[i])).abs() < 1e-4 + grain, "{value} {i}");
        }
    }

    #[test]
    fn any_finite_rows_give_finite_results(rows in prop::collection::vec(
        (prop::array::uniform7(prop::num::f32::ANY), prop::num::f32::ANY), 1..40)) {
        let mut estimator = Small::new(N);
        let mut entered = 0;
        for (row, rhs) in &rows {
            let finite = row.iter().all(|x| x.is_finite()) && rhs.is_finite();
            let result = estimator.rows.enter(row, *rhs);
            prop_assert_eq!(result.is_ok(), finite);
            entered += u32::from(finite);
        }
        prop_assert_eq!(estimator.rows.rows(), entered);
        if let Ok(solution) = estimator.solve() {
            prop_assert!(solution.rank <= N);
            prop_assert!(solution.values.iter().all(|x| x.is_finite()));
        }
    }

    #[test]
    fn deficient_rank_is_found_and_least_norm_given(seed: u64, from in 0usize..N, to in 0usize..N, zero in 0usize..N) {
        prop_assume!(from != to && zero != from && zero != to);
        let mut rows = problem(seed, 80, 0.01);
        for (row, _) in &mut rows {
            row[to] = row[from];
            row[zero] = 0.0;
        }
        // Oracle: the problem without the two columns, of full rank; the least norm splits the copied column in half.
        let (a, b) = matrix(&rows);
        let reduced = a.remove_columns_at(&[to.min(zero), to.max(zero)]);
        let y = reduced.clone().svd(true, true).solve(&b, 0.0).unwrap();
        let noise = (&reduced * &y - &b).norm() / f64::from(80 - 5).sqrt();
        let mut x = y.insert_rows(to.min(zero), 1, 0.0).insert_rows(to.max(zero), 1, 0.0);
        x[from] /= 2.0;
        x[to] = x[from];
        let estimator = incremental(&rows);
        let s = estimator.solution();
        prop_assert_eq!(s.rank, N - 2);
        prop_assert!(s.condition.is_infinite());
        prop_assert!(relative(s.noise, noise) < 1e-3);
        for i in 0..N {
            prop_assert!((f64::from(s.values[i]) - x[i]).abs() < 2e-5, "{:?} {}", s.values, x);
            prop_assert_eq!(s.deviations[i].is_infinite(), i == from || i == to || i == zero, "{:?}", s.deviations);
        }
    }
}

#[test]
fn bad_rows_are_named_and_change_nothing() {
    let mut triangle = Triangle::<2, { packed_len(2) }>::new(2);
    triangle.enter(&[1.0, 2.0], 3.0).unwrap();
    assert_eq!(
        triangle.enter(&[1.0], 3.0),
        Err(RowError::Length {
            given: 1,
            unknowns: 2
        })
    );
    assert_eq!(
        triangle.enter(&[1.0, f32::NAN], 3.0),
        Err(RowError::Entry { column: 1 })
    );
    assert_eq!(
        triangle.enter(&[f32::INFINITY, 1.0], 3.0),
        Err(RowError::Entry { column: 0 })
    );
    assert_eq!(
        triangle.enter(&[1.0, 1.0], f32::NAN),
        Err(RowError::RightHandSide)
    );
    assert_eq!(
        (triangle.rows(), triangle.entry(0, 0), triangle.entry(0, 1)),
        (1, 1.0, 2.0)
    );
    assert_eq!(
        RowError::Entry { column: 1 }.to_string(),
        "row's entry 1 is not a finite number"
    );
}

#[test]
fn largest_and_smallest_floats_neither_overflow_nor_vanish() {
    let mut estimator = Estimator::<2, { packed_len(2) }>::new(2);
    for _ in 0..1000 {
        estimator.rows.enter(&[f32::MAX, 0.0], f32::MAX).unwrap();
        estimator
            .rows
            .enter(&[0.0, f32::MIN_POSITIVE], f32::MIN_POSITIVE)
            .unwrap();
    }
    let solution = estimator.solve().unwrap();
    assert_eq!(solution.rank, 2);
    assert!(
        (solution.values[0] - 1.0).abs() < 1e-5,
        "{:?}",
        solution.values
    );
    assert!((estimator.rows.entry(1, 1) / f32::MIN_POSITIVE - 1000f32.sqrt()).abs() < 1e-3);
    // A tiny row first must not spoil the scale of the large ones that follow, and the other way round.
    for order in [[1e-38f32, 1e30], [1e30, 1e-38]] {
        let mut estimator = Estimator::<1, { packed_len(1) }>::new(1);
        for size in order {
            estimator.rows.enter(&[size], 2.0 * size).unwrap();
        }
        assert!((estimator.solve().unwrap().values[0] - 2.0).abs() < 1e-6);
    }
}

#[test]
fn prediction_is_the_solution_and_its_spread() {
    let rows = problem(3, 50, 0.1);
    let estimator = incremental(&rows);
    let row: [f32; N] = std::array::from_fn(|i| 0.3 * i as f32 - 1.0);
    let value: f32 = row
        .iter()
        .zip(estimator.solution().values)
        .map(|(a, x)| a * x)
        .sum();
    let prediction = estimator.rows.predict(&row).unwrap();
    assert!((prediction.value - value).abs() < 1e-4);
    assert!((prediction.leverage.sqrt() - estimator.functional_deviation(&row)).abs() < 1e-5);
    let mut few = Small::new(N);
    few.rows.enter(&rows[0].0, rows[0].1).unwrap();
    assert!(few.rows.predict(&row).unwrap().leverage.is_infinite());
}

#[test]
fn forgetting_follows_a_change_and_keeps_the_window() {
    let mut estimator = Estimator::<1, { packed_len(1) }>::new(1);
    for i in 0..2000 {
        estimator.rows.forget(0.98);
        estimator
            .rows
            .enter(&[1.0], if i < 1000 { 5.0 } else { -3.0 })
            .unwrap();
    }
    assert!((estimator.rows.effective_rows() - 50.0).abs() < 0.1);
    assert!((estimator.solve().unwrap().values[0] + 3.0).abs() < 1e-5);
}

#[test]
fn fits_the_memory_bound() {
    assert!(size_of::<Estimator<49, { packed_len(49) }>>() <= 12 * 1024);
}

#[test]
fn removing_a_row_is_as_if_it_had_not_been_entered() {
    let rows = problem(11, 40, 0.1);
    let (mut with, without) = (incremental(&rows), incremental(&rows[..39].to_vec()));
    assert!(with.rows.remove(&rows[39].0, rows[39].1));
    with.solve().unwrap();
    for (a, b) in with.solution().values.iter().zip(without.solution().values) {
        assert!((a - b).abs() < 2e-5, "{a} {b}");
    }
    assert!((with.solution().noise / without.solution().noise - 1.0).abs() < 1e-4);
    assert!((with.covariance(2, 2) / without.covariance(2, 2) - 1.0).abs() < 1e-4);
    assert_eq!(with.rows.rows(), 39);
    let mut exact = incremental(&rows[..N].to_vec());
    assert!(!exact.rows.remove(&rows[0].0, rows[0].1));
}

#[test]
fn unknowns_counted_from_another_point_are_less_by_it() {
    let rows = problem(12, 40, 0.1);
    let to: [f32; N] = std::array::from_fn(|i| 0.3 * i as f32 - 1.0);
    let less = |(row, rhs): &([f32; N], f32)| {
        let told: f32 = row.iter().zip(to).map(|(a, x)| a * x).sum();
        (*row, rhs - told)
    };
    let wanted = incremental(&rows.iter().map(less).collect());
    let mut shifted = incremental(&rows);
    shifted.rows.shift(&to);
    shifted.solve().unwrap();
    for (a, b) in shifted
        .solution()
        .values
        .iter()
        .zip(wanted.solution().values)
    {
        assert!((a - b).abs() < 2e-5, "{a} {b}");
    }
    assert!((shifted.solution().noise / wanted.solution().noise - 1.0).abs() < 1e-4);
}
