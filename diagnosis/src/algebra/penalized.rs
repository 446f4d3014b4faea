//! Sparse rows fitted by least squares with a prior, and what such a fit leaves on pieces that it has not seen.

use crate::algebra::envelope::Envelope;
use crate::data::folds::FOLDS;
use normal_equations::symmetric::dot;

/// One value and the few columns that it depends on.
#[derive(Clone, Debug, Default)]
pub struct Row {
    /// Column and entry.
    pub entries: Vec<(usize, f64)>,
    /// What is to be explained.
    pub value: f64,
    /// Piece that the row belongs to.
    pub fold: usize,
}

/// A combination of amounts that is expected about 1 in size, beside each amount by itself.
pub type Penalty = Vec<(usize, f64)>;

/// Products of the columns with each other (on and below the diagonal) and with the values, and the values' squares.
#[derive(Clone)]
struct Sums {
    normal: Vec<Vec<f64>>,
    right: Vec<f64>,
    squares: f64,
}

impl Sums {
    fn new(columns: usize) -> Self {
        Self {
            normal: (0..columns).map(|row| vec![0.0; row + 1]).collect(),
            right: vec![0.0; columns],
            squares: 0.0,
        }
    }

    /// Adds a row; several of its entries may be of one column. In the order of the columns every product is formed once.
    fn add(&mut self, mut entries: Vec<(usize, f64)>, value: f64) {
        entries.sort_unstable_by_key(|entry| entry.0);
        entries.dedup_by(|next, kept| {
            let same = next.0 == kept.0;
            kept.1 += if same { next.1 } else { 0.0 };
            same
        });
        for (k, &(a, x)) in entries.iter().enumerate() {
            let row = &mut self.normal[a];
            for &(b, y) in &entries[..=k] {
                row[b] += x * y;
            }
            self.right[a] += x * value;
        }
        self.squares += value * value;
    }

    /// Adds so many times the sums of others.
    fn add_sums(&mut self, other: &Self, times: f64) {
        let rows = self.normal.iter_mut().zip(&other.normal);
        for (row, add) in rows.chain([(&mut self.right, &other.right)]) {
            row.iter_mut().zip(add).for_each(|(r, a)| *r += times * a);
        }
        self.squares += times * other.squares;
    }

    fn left(&self, coefficients: &[f64]) -> f64 {
        let mut left = self.squares;
        for (a, row) in self.normal.iter().enumerate() {
            let (below, diagonal) = row.split_at(a);
            let beside = dot(below, &coefficients[..a]);
            left +=
                coefficients[a] * (2.0 * (beside - self.right[a]) + diagonal[0] * coefficients[a]);
        }
        left
    }
}

/// Times that the noise is found anew from what a fit at the last one leaves. A derivation: what a fit leaves hardly depends on the noise that
/// it was made with, so that two steps come near the likeliest noise, about which the evidence is flat.
const NOISE_STEPS: usize = 2;

/// Rows over some columns, summed piece by piece.
pub struct Pieces {
    folds: Vec<Sums>,
    all: Sums,
    rows: usize,
}

impl Pieces {
    /// Cost: rows times the square of their entries.
    pub fn new(columns: usize, rows: impl Iterator<Item = Row>) -> Self {
        let mut folds = vec![Sums::new(columns); FOLDS];
        let mut count = 0;
        for row in rows {
            folds[row.fold].add(row.entries, row.value);
            count += 1;
        }
        let mut all = Sums::new(columns);
        folds.iter().for_each(|fold| all.add_sums(fold, 1.0));
        Self {
            folds,
            all,
            rows: count,
        }
    }

    /// Amounts of all columns, with noise of variance `noise`. Cost: that of one Cholesky factor within the envelope of the columns' products.
    pub fn coefficients(&self, noise: f64, penalties: &[Penalty]) -> Option<Vec<f64>> {
        solved(&self.all, noise, penalties)
    }

    /// Logarithm of the probability density of all values, where amounts are normal about zero with a deviation of one (Bishop 2006, equation
    /// 3.86), less a constant that is the same for all columns. The noise has at least this variance, and as much more as the columns leave.
    /// Cost: that of three factors.
    pub fn log_evidence(&self, least_noise: f64) -> Option<f64> {
        let rows = self.rows.max(1) as f64;
        let mut noise = least_noise;
        for _ in 0..NOISE_STEPS {
            let left = self.all.left(&solved(&self.all, noise, &[])?);
            noise = least_noise.max(left / rows);
        }
        let factor = factored(&self.all, noise, &[])?;
        let coefficients = factor.solve(self.all.right.clone());
        let explained = dot(&self.all.right, &coefficients);
        let of_columns = factor.ln_determinant() - coefficients.len() as f64 * noise.ln();
        let of_rows = rows * noise.ln();
        Some(-0.5 * (of_rows + of_columns + (self.all.squares - explained) / noise))
    }

    /// Mean square that fits of the other pieces leave. Cost: that of a factor for each piece.
    pub fn held_out(&self, noise: f64, penalties: &[Penalty]) -> Option<f64> {
        let mut left = 0.0;
        for fold in &self.folds {
            let mut others = self.all.clone();
            others.add_sums(fold, -1.0);
            left += fold.left(&solved(&others, noise, penalties)?);
        }
        Some(left / self.rows.max(1) as f64)
    }
}

/// Amounts of unit prior, and bonds of unit size, against noise of this variance.
fn solved(sums: &Sums, noise: f64, penalties: &[Penalty]) -> Option<Vec<f64>> {
    Some(factored(sums, noise, penalties)?.solve(sums.right.clone()))
}

/// The factor of the same's normal equations.
fn factored(sums: &Sums, noise: f64, penalties: &[Penalty]) -> Option<Envelope> {
    let mut prior = Sums::new(sums.right.len());
    penalties
        .iter()
        .for_each(|bond| prior.add(bond.clone(), 0.0));
    (0..sums.right.len()).for_each(|k| prior.normal[k][k] += 1.0);
    let mut normal = sums.clone();
    normal.add_sums(&prior, noise);
    Envelope::factor(normal.normal)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};

    fn rows(column: fn(f64) -> f64, value: fn(f64) -> f64) -> impl Iterator<Item = Row> {
        (0..1000).map(move |k| {
            let x = k as f64 / 500.0 - 1.0;
            Row {
                entries: vec![(0, 1.0), (1, column(x))],
                value: value(x),
                fold: k * 40 / 1000 % FOLDS,
            }
        })
    }

    #[test]
    fn a_line_is_found_and_a_foreign_column_explains_nothing() {
        let line = Pieces::new(2, rows(|x| x, |x| 0.3 * x));
        let coefficients = line.coefficients(1e-9, &[]).expect("regular");
        assert!((coefficients[1] - 0.3).abs() < 1e-6 && line.held_out(1e-9, &[]).unwrap() < 1e-9);
        let other = Pieces::new(2, rows(|x| (300.0 * x).sin(), |x| 0.3 * x));
        assert!(other.held_out(1e-9, &[]).unwrap() > 0.029);
    }

    /// A row's entries in any order, two of them of one column.
    #[test]
    fn entries_of_one_column_add_up() {
        let line = |apart: bool| {
            Pieces::new(
                2,
                rows(|x| x, |x| 0.3 * x).map(move |mut row| {
                    let (_, x) = row.entries[1];
                    if apart {
                        row.entries = vec![(1, 0.75 * x), (0, 1.0), (1, 0.25 * x)];
                    }
                    row
                }),
            )
        };
        let [whole, parts] = [false, true].map(|apart| line(apart).coefficients(1.0, &[]));
        let (whole, parts) = (whole.expect("regular"), parts.expect("regular"));
        assert!(whole.iter().zip(&parts).all(|(a, b)| (a - b).abs() < 1e-12));
    }

    /// A bond between two columns makes them what it says, where the rows leave it open.
    #[test]
    fn a_bond_holds_amounts_together() {
        let both = Pieces::new(2, rows(|_| 1.0, |_| 1.0));
        let bond = vec![(0, 1e3), (1, -3e3)];
        let coefficients = both.coefficients(1e-6, &[bond]).expect("regular");
        assert!(
            (coefficients[0] / coefficients[1] - 3.0).abs() < 1e-3,
            "{coefficients:?}"
        );
    }

    /// The density of all values by their whole covariance, noise and columns.
    #[test]
    fn the_evidence_is_that_of_the_whole_covariance() {
        const ROWS: usize = 9;
        // Beyond what the columns leave, so that it stays.
        const NOISE: f64 = 0.3;
        let entry = |i: usize, k: usize| ((i + 1) as f64 * [0.7, 1.9][k]).sin();
        let value = |i: usize| (0.4 * i as f64).cos();
        let whole = |columns: usize| {
            let covariance = DMatrix::from_fn(ROWS, ROWS, |i, j| {
                let own = if i == j { NOISE } else { 0.0 };
                own + (0..columns).map(|k| entry(i, k) * entry(j, k)).sum::<f64>()
            });
            let values = DVector::from_fn(ROWS, |i, _| value(i));
            let factor = covariance.cholesky().expect("positive");
            -0.5 * (factor.determinant().ln() + values.dot(&factor.solve(&values)))
        };
        for columns in [1, 2] {
            let rows = (0..ROWS).map(|i| Row {
                entries: (0..columns).map(|k| (k, entry(i, k))).collect(),
                value: value(i),
                fold: i % FOLDS,
            });
            let found = Pieces::new(columns, rows)
                .log_evidence(NOISE)
                .expect("regular");
            assert!(
                (found - whole(columns)).abs() < 1e-9,
                "{found} {}",
                whole(columns)
            );
        }
    }
}
