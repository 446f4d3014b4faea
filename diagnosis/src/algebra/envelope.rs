//! Cholesky's factor of a matrix whose rows begin late: left of a row's first entry there is nothing, and nothing comes there
//! (Jennings 1966). A band with a border of full rows costs little more than the band.

use normal_equations::symmetric::dot;

/// The factor, row by row from each row's first entry to the diagonal.
pub struct Envelope {
    first: Vec<usize>,
    rows: Vec<Vec<f64>>,
}

impl Envelope {
    /// Of a positive definite matrix, given by its rows up to the diagonal; `None` where it is not. Cost: for each entry of the
    /// envelope the length that its row and its column's row have in common.
    pub fn factor(lower: Vec<Vec<f64>>) -> Option<Self> {
        let mut out = Self {
            first: Vec::new(),
            rows: Vec::new(),
        };
        for (i, mut row) in lower.into_iter().enumerate() {
            let begin = row.iter().position(|v| *v != 0.0)?;
            row.drain(..begin);
            for j in begin..i {
                let (from, above) = (out.first[j].max(begin), &out.rows[j]);
                let known = dot(
                    &row[from - begin..j - begin],
                    &above[from - out.first[j]..j - out.first[j]],
                );
                row[j - begin] = (row[j - begin] - known) / above[j - out.first[j]];
            }
            let (diagonal, known) = row.split_last_mut()?;
            let square = *diagonal - dot(known, known);
            if !(square > 0.0 && square.is_finite()) {
                return None;
            }
            *diagonal = square.sqrt();
            out.first.push(begin);
            out.rows.push(row);
        }
        Some(out)
    }

    /// Logarithm of the matrix's determinant.
    pub fn ln_determinant(&self) -> f64 {
        let of_diagonal = |row: &Vec<f64>| row.last().map_or(0.0, |d| 2.0 * d.ln());
        self.rows.iter().map(of_diagonal).sum()
    }

    /// The solution for a right side.
    pub fn solve(&self, mut right: Vec<f64>) -> Vec<f64> {
        for (i, row) in self.rows.iter().enumerate() {
            let (known, diagonal) = row.split_at(row.len() - 1);
            right[i] = (right[i] - dot(known, &right[self.first[i]..i])) / diagonal[0];
        }
        for (i, row) in self.rows.iter().enumerate().rev() {
            let (known, diagonal) = row.split_at(row.len() - 1);
            right[i] /= diagonal[0];
            let coefficient = right[i];
            let above = right[self.first[i]..i].iter_mut();
            above.zip(known).for_each(|(r, k)| *r -= k * coefficient);
        }
        right
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A band of two with a full last row, solved against its own product.
    #[test]
    fn a_band_with_a_border_is_solved() {
        const N: usize = 12;
        let entry = |i: usize, j: usize| match i - j {
            0 => 20.0 + i as f64,
            1 => 3.0,
            2 if i % 3 > 0 => -2.0,
            _ if i == N - 1 => 0.5 + j as f64,
            _ => 0.0,
        };
        let lower: Vec<Vec<f64>> = (0..N)
            .map(|i| (0..=i).map(|j| entry(i, j)).collect())
            .collect();
        let wanted: Vec<f64> = (0..N).map(|k| (k as f64).sin()).collect();
        let row = |i: usize| (0..N).map(move |j| entry(i.max(j), i.min(j)));
        let right = (0..N).map(|i| row(i).zip(&wanted).map(|(a, x)| a * x).sum());
        let right = right.collect();
        let factor = Envelope::factor(lower).expect("positive definite");
        let found = factor.solve(right);
        assert!(factor.rows[N - 2].len() <= 3, "nothing left of the band");
        assert!(found.iter().zip(&wanted).all(|(f, w)| (f - w).abs() < 1e-9));
        assert!(Envelope::factor(vec![vec![1.0], vec![2.0, 1.0]]).is_none());
    }

    #[test]
    fn the_determinant_of_two_rows_is_theirs() {
        let factor = Envelope::factor(vec![vec![4.0], vec![2.0, 3.0]]).expect("positive");
        assert!((factor.ln_determinant() - 8f64.ln()).abs() < 1e-12);
    }
}
