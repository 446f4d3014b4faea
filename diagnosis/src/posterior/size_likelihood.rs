//! How the evidence goes with the size of one block: for all sizes at the cost of one.
//!
//! A size only adds to the diagonal of the block's products. Where these are a diagonal, or three, each size then costs as many steps as
//! there are columns (Golub and Van Loan 2013, section 8.3.1).

use nalgebra::{DMatrix, DVector, SymmetricTridiagonal};

/// The likelihood of a block's size.
pub struct SizeLikelihood {
    /// Diagonal of the products over the noise.
    diagonal: Vec<f64>,
    kind: Kind,
}

enum Kind {
    /// The products are no more than a diagonal. Squares of the products with the target.
    Diagonal(Vec<f64>),
    /// Squares beside the diagonal, and of the products with the target, which are those of the first axis alone.
    Tridiagonal(Vec<f64>, f64),
}

impl SizeLikelihood {
    /// Of products that are a diagonal, over the noise, and those with the target.
    pub fn of_diagonal(diagonal: Vec<f64>, right: &DVector<f64>) -> Self {
        Self {
            diagonal,
            kind: Kind::Diagonal(right.iter().map(|r| r * r).collect()),
        }
    }

    /// Of any products, over the noise, and those with the target. Cost: four thirds of the cube.
    pub fn new(normal: &DMatrix<f64>, right: &DVector<f64>) -> Self {
        let n = right.len();
        // With the target as a column before the others, the first reflection turns its products to one axis.
        let mut bordered = normal.clone().insert_column(0, 0.0).insert_row(0, 0.0);
        bordered.view_mut((1, 0), (n, 1)).copy_from(right);
        bordered
            .view_mut((0, 1), (1, n))
            .copy_from(&right.transpose());
        let (diagonal, beside) = SymmetricTridiagonal::new(bordered).unpack_tridiagonal();
        let squares: Vec<f64> = beside.iter().map(|b| b * b).collect();
        Self {
            diagonal: diagonal.iter().skip(1).copied().collect(),
            kind: Kind::Tridiagonal(
                squares[1.min(n)..].to_vec(),
                squares.first().copied().unwrap_or(0.0),
            ),
        }
    }

    /// Number of columns.
    pub fn columns(&self) -> usize {
        self.diagonal.len()
    }

    /// Logarithm of the density with columns of this variance (a logarithm) over that without.
    pub fn log_ratio(&self, log_variance: f64) -> f64 {
        let prior = (-log_variance).exp();
        let (explained, log_determinant) = match &self.kind {
            Kind::Diagonal(squares) => self
                .diagonal
                .iter()
                .zip(squares)
                .map(|(d, r)| (r / (d + prior), (d + prior).ln()))
                .fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1)),
            Kind::Tridiagonal(beside, squares) => {
                // From the last axis up: what is left of each when those after it are eliminated.
                let (mut left, mut log) = (f64::INFINITY, 0.0);
                for (k, d) in self.diagonal.iter().enumerate().rev() {
                    let next = beside.get(k).map_or(0.0, |b| b / left);
                    left = d + prior - next;
                    log += left.ln();
                }
                (squares / left, log)
            }
        };
        let out = 0.5 * (explained - log_determinant - self.diagonal.len() as f64 * log_variance);
        if out.is_finite() {
            out
        } else {
            f64::NEG_INFINITY
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use effects::random::{ChaCha8Rng, SeedableRng, normal};

    /// Against the determinant and the solution of the whole matrix, for one column and for many.
    #[test]
    fn each_size_has_the_whole_matrixs_likelihood() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        for n in [1, 2, 7, 20] {
            let rows = DMatrix::from_fn(n + 5, n, |_, _| normal(&mut rng));
            let plain = rows.tr_mul(&rows);
            let right = DVector::from_fn(n, |_, _| 3.0 * normal(&mut rng));
            let diagonal = DMatrix::from_diagonal(&plain.diagonal());
            let cases = [
                (SizeLikelihood::new(&plain, &right), &plain),
                (SizeLikelihood::new(&diagonal, &right), &diagonal),
                (
                    SizeLikelihood::of_diagonal(plain.diagonal().iter().copied().collect(), &right),
                    &diagonal,
                ),
            ];
            for (likelihood, whole) in cases {
                for size in [-4.0, 0.0, 1.5_f64] {
                    let precision = whole + DMatrix::identity(n, n) * (-size).exp();
                    let factor = precision.cholesky().unwrap();
                    let explained = right.dot(&factor.solve(&right));
                    let wanted = 0.5 * (explained - factor.determinant().ln() - n as f64 * size);
                    let found = likelihood.log_ratio(size);
                    assert!(
                        (found - wanted).abs() < 1e-9 * wanted.abs().max(1.0),
                        "{n}: {found} {wanted}"
                    );
                }
            }
        }
    }
}
