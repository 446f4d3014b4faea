//! The condition number over many spectra, clustered ones among them, against the singular values that the rows were made of.
use courier_sensor::lsq::{Estimator, packed_len};
use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use std::f64::consts::PI;

/// A third of what is asked. 16 steps of the process do not reach it.
const TOLERANCE: f64 = 0.01;

/// Singular values of a problem of so many unknowns, not in order.
type Spectrum = fn(&mut ChaCha8Rng, usize) -> Vec<f64>;

/// Families of spectra by name. What takes long is to tell the ends from their neighbours.
const SPECTRA: [(&str, Spectrum); 6] = [
    ("geometric", |rng, n| {
        let decades: f64 = rng.random_range(0.5..3.0);
        each(n, |share, _| 10f64.powf(-decades * share))
    }),
    ("even", |rng, n| {
        let low: f64 = rng.random_range(0.003..0.5);
        each(n, |share, _| 1.0 - (1.0 - low) * share)
    }),
    ("two clusters", |rng, n| {
        let low: f64 = rng.random_range(0.001..0.5);
        each(n, |_, i| {
            (if i % 2 == 0 { 1.0 } else { low }) * rng.random_range(0.95..1.05)
        })
    }),
    ("one beside a cluster at each end", |rng, n| {
        let (low, apart) = (rng.random_range(0.001..0.5), rng.random_range(1.02..1.2));
        each(n, |_, i| match i {
            0 => apart,
            1 => low / apart,
            i if i % 2 == 0 => rng.random_range(0.9..1.0),
            _ => low / rng.random_range(0.9..1.0),
        })
    }),
    ("dense towards the ends", |rng, n| {
        let low: f64 = rng.random_range(0.001..0.5);
        each(n, |share, _| {
            0.5 * ((1.0 + low) + (1.0 - low) * (PI * share).cos())
        })
    }),
    ("drawn", |rng, n| {
        let decades: f64 = rng.random_range(0.5..3.0);
        each(n, |_, _| 10f64.powf(rng.random_range(-decades..0.0)))
    }),
];

/// A value for each index, given as a share of the last one and as itself.
fn each(n: usize, mut value: impl FnMut(f64, usize) -> f64) -> Vec<f64> {
    (0..n)
        .map(|i| value(i as f64 / (n - 1) as f64, i))
        .collect()
}

/// The directions that the values belong to, as rows.
type Basis = fn(&mut ChaCha8Rng, usize) -> DMatrix<f64>;

/// A start vector with an order in it has no part along some of those with an order in them.
const BASES: [Basis; 4] = [
    |rng, n| {
        DMatrix::from_fn(n, n, |_, _| rng.sample(StandardNormal))
            .qr()
            .q()
    },
    |_, n| DMatrix::identity(n, n),
    |_, n| {
        let mut pairs = DMatrix::identity(n, n);
        for i in (0..n - 1).step_by(2) {
            pairs
                .view_mut((i, i), (2, 2))
                .copy_from_slice(&[1.0, 1.0, 1.0, -1.0]);
        }
        pairs
            .row_iter_mut()
            .for_each(|mut row| _ = row.normalize_mut());
        pairs
    },
    |_, n| {
        let mut cosines = DMatrix::from_fn(n, n, |i, j| {
            (PI * i as f64 * (j as f64 + 0.5) / n as f64).cos()
        });
        cosines
            .row_iter_mut()
            .for_each(|mut row| _ = row.normalize_mut());
        cosines
    },
];

/// Relative error of the condition number of `count` problems of a family.
fn errors<const N: usize, const P: usize>(spectrum: Spectrum, count: usize) -> Vec<f64> {
    let mut estimator: Box<Estimator<N, P>> = Box::new(Estimator::new(N));
    let mut rng = ChaCha8Rng::seed_from_u64(71);
    let mut error = |index: usize| {
        let values = spectrum(&mut rng, N);
        let basis = BASES[index % BASES.len()](&mut rng, N);
        estimator.reset(N);
        for (value, direction) in values.iter().zip(basis.row_iter()) {
            let row: [f32; N] = std::array::from_fn(|i| (value * direction[i]) as f32);
            estimator.rows.enter(&row, 0.0).expect("finite");
        }
        let solution = estimator.solve().expect("a solution");
        assert_eq!(solution.rank, N);
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = values.iter().copied().fold(0.0, f64::max);
        f64::from(solution.condition) * low / high - 1.0
    };
    (0..count).map(&mut error).collect()
}

fn assert_within<const N: usize, const P: usize>(each: usize) {
    for (name, spectrum) in SPECTRA {
        let errors = errors::<N, P>(spectrum, each);
        let (low, high) = errors.iter().fold((0.0f64, 0.0f64), |(low, high), e| {
            (low.min(*e), high.max(*e))
        });
        println!("{N} unknowns, {name}: {low:.4} to {high:.4}");
        assert!(
            -low < TOLERANCE && high < 1e-3,
            "{N} {name}: {low} to {high}"
        );
    }
}

#[test]
fn condition_number_is_within_one_percent_for_any_spectrum() {
    assert_within::<33, { packed_len(33) }>(3000);
    assert_within::<62, { packed_len(62) }>(300);
}
