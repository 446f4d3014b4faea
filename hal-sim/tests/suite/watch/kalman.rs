//! What a Kalman filter makes of the windows that the recalibration learns from: the bound of what can be known at any time without
//! knowing what comes.
//!
//! The amounts of equation (3) in the outputs' errors walk at random, at the rate at which they truly do; each window is a reading of all of
//! them (Kalman 1960). Of that model no other estimate has smaller errors. It takes everything off the corrections at once, sure or
//! not: no test, no memory that is cut off, no write to flash.

use courier_sensor::calibration::watch::{AMOUNTS, Amounts, Whole};
use nalgebra::{DMatrix, DVector};

/// Amounts that walk at random, and what the windows so far tell of them.
pub struct Kalman {
    /// By the calibration, metres.
    amounts_m: DVector<f64>,
    covariance_m2: DMatrix<f64>,
    /// What an amount's variance grows by in a second, once it walks.
    rate_m2_per_s: f64,
    /// Until when they have walked: at first, when that begins.
    time_s: f64,
    /// What has been taken off the outputs that the windows see, metres.
    amended_m: DVector<f64>,
    /// Mean squares of windows about what was expected of them, over their variance, and how many.
    surprise: (f64, u32),
}

impl Kalman {
    /// Begins with a calibration that left each amount known to a deviation, and with a walk that begins at a time.
    pub fn new(left_m: f64, rate_m2_per_s: f64, from_s: f64) -> Self {
        Self {
            amounts_m: DVector::zeros(AMOUNTS),
            covariance_m2: DMatrix::identity(AMOUNTS, AMOUNTS) * (left_m * left_m),
            rate_m2_per_s,
            time_s: from_s,
            amended_m: DVector::zeros(AMOUNTS),
            surprise: (0.0, 0),
        }
    }

    /// These amounts are taken off the outputs from now on.
    pub fn amend(&mut self, by_m: &Amounts) {
        for (sum, by) in self.amended_m.iter_mut().zip(by_m) {
            *sum += f64::from(*by);
        }
    }

    /// A window that ends at a time.
    pub fn enter(&mut self, time_s: f64, window: &Whole<'_>) {
        let (rows, rhs): (Vec<Amounts>, Vec<f32>) = (0..AMOUNTS).map(|i| window.row(i)).unzip();
        let rows = DMatrix::from_fn(AMOUNTS, AMOUNTS, |i, j| f64::from(rows[i][j]));
        let seen = DVector::from_iterator(AMOUNTS, rhs.into_iter().map(f64::from));
        self.read(time_s, &rows, &(seen + &rows * &self.amended_m));
    }

    /// A reading of amounts, of unit variance but for what readings differ by beyond it.
    fn read(&mut self, time_s: f64, rows: &DMatrix<f64>, seen: &DVector<f64>) {
        let walked_s = (time_s - self.time_s).max(0.0);
        self.time_s = self.time_s.max(time_s);
        let grown = self.rate_m2_per_s * walked_s;
        (0..AMOUNTS).for_each(|i| self.covariance_m2[(i, i)] += grown);
        let together = &self.covariance_m2 * rows.transpose();
        let expected = rows * &together;
        let off = seen - rows * &self.amounts_m;
        let one = DMatrix::identity(AMOUNTS, AMOUNTS);
        // Both are sums of squares and one: they have inverses.
        let Some(factor) = (&expected + &one).cholesky() else {
            return;
        };
        let (sum, count) = &mut self.surprise;
        *sum += factor.solve(&off).dot(&off) / AMOUNTS as f64;
        *count += 1;
        let variance = (*sum / f64::from(*count)).max(1.0);
        let Some(factor) = (expected + one * variance).cholesky() else {
            return;
        };
        let gain = factor.solve(&together.transpose()).transpose();
        self.amounts_m += &gain * off;
        let covariance = &self.covariance_m2 - &gain * together.transpose();
        self.covariance_m2 = 0.5 * (&covariance + covariance.transpose());
    }

    /// What is to be taken off the calibration's corrections by now, metres.
    pub fn amounts_m(&self) -> Amounts {
        core::array::from_fn(|i| self.amounts_m[i] as f32)
    }
}

/// Two readings of amounts that walk, against the sums that they are: a mean of the first and of the second, weighted by their variances.
#[test]
fn a_reading_counts_by_what_is_known_of_the_walk() {
    let mut kalman = Kalman::new(1.0, 0.5, 10.0);
    let one = DMatrix::identity(AMOUNTS, AMOUNTS);
    let first = DVector::from_element(AMOUNTS, 1.0);
    kalman.read(5.0, &one, &first);
    // Before the walk begins: half of the prior, half of the reading.
    assert!((kalman.amounts_m[3] - 0.5).abs() < 1.0e-12);
    kalman.read(11.0, &one, &DVector::zeros(AMOUNTS));
    // Half of a square metre was known, and half came with the walk: as much as the second reading's.
    assert!((kalman.amounts_m[3] - 0.25).abs() < 1.0e-12);
    assert!((kalman.covariance_m2[(3, 3)] - 0.5).abs() < 1.0e-12);
}
