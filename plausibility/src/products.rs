//! Sums of products of columns, free of zeros and of what equation (3) may add: all that a linear relation is judged by.

use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// Orders of the tooth phase that are taken out: those of equation (3) that are largest. Derived from the pair: an offset makes
/// order 1, gain and angle order 2, a third harmonic of the signals order 4.
const ORDERS: [f64; 3] = [1.0, 2.0, 4.0];
/// Directions of less than this share of the largest eigenvalue are not told by the rows. Derived from 16 digits: products keep
/// seven of a direction as weak as that.
const SINGULAR_SHARE: f64 = 1.0e-9;
/// Parity of an uncalibrated sensor, rms, m (paper, 3.1.2).
const PERIODIC_M: f64 = 30.0e-6;
/// Steps of the eigenvalue iteration: some three a column are usual. A bound on the work: what has not settled by then has no
/// inverse, and nothing but zeros is taken out.
const MOST_STEPS: usize = 10_000;
/// Rows for each column that is taken out; with fewer nothing but zeros is taken out. Derived from the least squares: an eighth
/// of the noise is then taken out with it.
const ROWS_A_COLUMN: usize = 8;

/// Mean products `[column, column]` over rows.
#[derive(Clone, Debug)]
pub(crate) struct Products {
    /// Zeros of the groups taken out.
    pub centred: DMatrix<f64>,
    /// Zeros of the groups and the periodic errors taken out.
    pub projected: DMatrix<f64>,
    /// What periodic errors may do to a reading where there were too few rows to take them out, m.
    pub periodic_m: f64,
}

impl Products {
    /// Of `columns` (each over the listed rows), within groups, with periodic errors of the tooth phases `turns` taken out.
    pub fn new(group: &[usize], columns: &[Vec<f64>], turns: &[Vec<f64>]) -> Self {
        let per_row = 1.0 / group.len().max(1) as f64;
        let wanted = matrix(group, columns);
        let nuisance = matrix(group, &periodic(group.len(), turns));
        let periodic_m = if nuisance.ncols() > 0 {
            0.0
        } else {
            PERIODIC_M
        };
        let centred = wanted.tr_mul(&wanted) * per_row;
        let (inverse, cross) = shared(&nuisance, &wanted, per_row);
        let projected = &centred - cross.tr_mul(&(inverse * &cross));
        Self {
            centred,
            projected,
            periodic_m,
        }
    }
}

/// One combination of columns row by row, with the same taken out.
pub(crate) fn residual(group: &[usize], column: &[f64], turns: &[Vec<f64>]) -> Vec<f64> {
    let per_row = 1.0 / group.len().max(1) as f64;
    let wanted = matrix(group, &[column.to_vec()]);
    let nuisance = matrix(group, &periodic(group.len(), turns));
    let (inverse, cross) = shared(&nuisance, &wanted, per_row);
    (wanted - &nuisance * (inverse * cross))
        .column(0)
        .iter()
        .copied()
        .collect()
}

/// Inverse of the nuisances' own products, and their products with what is wanted.
fn shared(
    nuisance: &DMatrix<f64>,
    wanted: &DMatrix<f64>,
    per_row: f64,
) -> (DMatrix<f64>, DMatrix<f64>) {
    let own = nuisance.tr_mul(nuisance) * per_row;
    let cross = nuisance.tr_mul(wanted) * per_row;
    (pseudo_inverse(own, SINGULAR_SHARE), cross)
}

/// Sines and cosines of the tooth phases; none if there are too few rows for them.
fn periodic(rows: usize, turns: &[Vec<f64>]) -> Vec<Vec<f64>> {
    if rows < ROWS_A_COLUMN * 2 * ORDERS.len() * turns.len() {
        return Vec::new();
    }
    let waves = |phase: &Vec<f64>| {
        ORDERS.map(|order| {
            let angle = |t: &f64| (TAU * order * t).sin_cos();
            let (sines, cosines): (Vec<f64>, Vec<f64>) = phase.iter().map(angle).unzip();
            [sines, cosines]
        })
    };
    turns.iter().flat_map(waves).flatten().collect()
}

/// `[row, column]`, less the mean of each group.
fn matrix(group: &[usize], columns: &[Vec<f64>]) -> DMatrix<f64> {
    let groups = 1 + group.iter().copied().max().unwrap_or(0);
    let mut count = vec![0.0; groups];
    group.iter().for_each(|&g| count[g] += 1.0);
    let mut matrix = DMatrix::zeros(group.len(), columns.len());
    for (c, column) in columns.iter().enumerate() {
        let mut sum = vec![0.0; groups];
        for (value, &g) in column.iter().zip(group) {
            sum[g] += value;
        }
        for (row, (value, &g)) in column.iter().zip(group).enumerate() {
            matrix[(row, c)] = value - sum[g] / count[g];
        }
    }
    matrix
}

/// Of a symmetric matrix; zeros where there is none (nothing in it, or numbers that overflowed).
fn pseudo_inverse(matrix: DMatrix<f64>, singular: f64) -> DMatrix<f64> {
    PseudoInverse::new(matrix, singular).matrix
}

/// The inverse of a symmetric matrix, in the directions whose eigenvalues are not next to zero.
struct PseudoInverse {
    /// The inverse; zero in all other directions.
    matrix: DMatrix<f64>,
    /// For each row, which share of its square lies in the other directions, 0 to 1.
    untold: DVector<f64>,
}

impl PseudoInverse {
    fn new(matrix: DMatrix<f64>, singular: f64) -> Self {
        let size = matrix.nrows();
        let nothing = Self {
            matrix: DMatrix::zeros(size, size),
            untold: DVector::from_element(size, 1.0),
        };
        if matrix.is_empty() || matrix.iter().any(|v| !v.is_finite()) {
            return nothing;
        }
        let Some(eigen) = matrix.try_symmetric_eigen(f64::EPSILON, MOST_STEPS) else {
            return nothing;
        };
        let least = singular * eigen.eigenvalues.iter().copied().fold(0.0, f64::max);
        let directions = &eigen.eigenvectors;
        let of = |weight: &dyn Fn(f64) -> f64| {
            directions
                * DMatrix::from_diagonal(&eigen.eigenvalues.map(weight))
                * directions.transpose()
        };
        Self {
            matrix: of(&|v| if v > least { 1.0 / v } else { 0.0 }),
            untold: of(&|v| if v > least { 0.0 } else { 1.0 }).diagonal(),
        }
    }
}

/// Regressors that differ by less than this share of their squares are taken for one. Derived from 16 digits: of a difference as small as that
/// the products keep eight.
const COLLINEAR_SHARE: f64 = 1.0e-8;
/// A coefficient is not told where this share of its square, or more, lies in directions that the rows do not tell. A prior: a tenth of its
/// amplitude.
const UNTOLD_SHARE: f64 = 0.01;

/// A least-squares fit of one combination of columns by others.
#[derive(Clone, Debug)]
pub(crate) struct Fit {
    /// Coefficients.
    pub coefficients: DVector<f64>,
    /// How far each regressor moves by itself, rms, in its own unit: what no other regressor does as well; 0 where others do all of it.
    pub alone: Vec<f64>,
    /// What is left, rms.
    pub left: f64,
    /// What there was, rms.
    pub was: f64,
}

impl Fit {
    /// Standard error of a coefficient as if all of what is left were one error that moves with the regressor, with a floor.
    pub fn error(&self, regressor: usize, least: f64) -> f64 {
        self.left.max(least) / self.alone[regressor].max(1e-300)
    }
}

/// Fits `response` (weights of columns) by `regressors` (weights of columns, one vector each).
pub(crate) fn fit(
    products: &DMatrix<f64>,
    response: &DVector<f64>,
    regressors: &[DVector<f64>],
) -> Fit {
    let count = regressors.len();
    let product = |a: &DVector<f64>, b: &DVector<f64>| (products * b).dot(a);
    let was = product(response, response).max(0.0);
    let scale: Vec<f64> = regressors
        .iter()
        .map(|r| product(r, r).max(0.0).sqrt().max(1e-300))
        .collect();
    let normal = DMatrix::from_fn(count, count, |i, j| {
        product(&regressors[i], &regressors[j]) / scale[i] / scale[j]
    });
    let right = DVector::from_fn(count, |i, _| product(&regressors[i], response) / scale[i]);
    let PseudoInverse {
        matrix: inverse,
        untold,
    } = PseudoInverse::new(normal, COLLINEAR_SHARE);
    let scaled = &inverse * &right;
    let left = (was - scaled.dot(&right)).max(0.0).sqrt();
    let alone = (0..count).map(|i| {
        let spread = inverse[(i, i)];
        if spread > 0.0 && untold[i] < UNTOLD_SHARE {
            scale[i] / spread.sqrt()
        } else {
            0.0
        }
    });
    Fit {
        alone: alone.collect(),
        coefficients: DVector::from_fn(count, |i, _| scaled[i] / scale[i]),
        left,
        was: was.sqrt(),
    }
}
